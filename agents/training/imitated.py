"""How far an imitation has come, in one small file, so that a stop loses seconds of it.

What was played is not in it, that would be gigabytes. It is played again, each round by the network of then, which
gives the same episodes; what was fitted to them is not fitted again.
"""

from __future__ import annotations

import copy
import hashlib
import io
import json
import pickle
import time
from collections.abc import Sequence
from contextlib import suppress
from pathlib import Path
from typing import Any

import numpy as np
import torch

from agents.training.actor import is_finite
from drillrig_env.files import write_bytes

_SECONDS = 2.0  # of work that a stop may lose
_SECONDS_OF_FILE = 60.0  # and a machine that fails

_DIGEST = hashlib.sha256().digest_size  # bytes before the rest of the file, since PyTorch does not look for damage
_UNREADABLE = (KeyError, ValueError, TypeError, RuntimeError, EOFError, OSError, IndexError, pickle.UnpicklingError)


class Imitated:
    """What `learns` (networks and their optimiser) and the generator `random` were like when, as far as it matters.

    As a context it writes its `file` when the imitation ends or is stopped, and each minute before; None writes none.
    Raises `ValueError` for a file that is damaged, and `FloatingPointError` rather than remember what is no number.
    """

    def __init__(self, learns: Sequence[Any], random: np.random.Generator, file: Path | None = None) -> None:
        self.learns, self.random, self.file = learns, random, file
        self.rounds: list[dict[str, Any]] = []  # as each began
        self.fit: tuple[int, dict[str, Any]] | None = None  # updates after the last of them, and how all then was
        self._remembered, self._written = 0.0, time.monotonic()
        if file is not None and file.is_file():
            found, content = (read := file.read_bytes())[:_DIGEST], read[_DIGEST:]
            try:
                if found != hashlib.sha256(content).digest():
                    raise ValueError("it is not as it was written")
                kept = torch.load(io.BytesIO(content), map_location="cpu", weights_only=True)
                self.rounds, self.fit = kept["rounds"], kept["fit"]
                self._make(self.rounds[-1])
            except _UNREADABLE as error:
                raise ValueError(f"{file} is damaged ({error}); remove it, and the imitation begins anew") from error

    def __enter__(self) -> Imitated:
        return self

    def __exit__(self, *_: object) -> None:
        self._write()

    def begin(self, number: int) -> None:
        """Before round `number`, from 0: remember how all is, or make it as it was then."""
        if number < len(self.rounds):
            self._make(self.rounds[number])
        else:
            self.rounds.append(self._now())
            self.fit = None

    def updates(self, number: int) -> int | None:
        """How many updates after round `number` are done, with all as it was after them; None where all are."""
        if number + 1 < len(self.rounds):
            return None
        if self.fit is None:
            return 0
        done, then = self.fit
        self._make(then)
        return done

    def remember(self, updates: int) -> None:
        """After so many updates of a round, where nothing but what learns and the generator matters for what comes."""
        now = time.monotonic()
        if now - self._remembered >= _SECONDS:
            self.fit, self._remembered = (updates, self._now()), now
        if now - self._written >= _SECONDS_OF_FILE:
            self._write()

    def _now(self) -> dict[str, Any]:
        if not all(is_finite(one) for one in self.learns if isinstance(one, torch.nn.Module)):
            raise FloatingPointError("what imitates has weights that are no numbers any more")
        parts = [copy.deepcopy(one.state_dict()) for one in self.learns]
        generators = {"random": json.dumps(self.random.bit_generator.state), "torch": torch.get_rng_state()}
        return {"parts": parts, **generators}

    def _make(self, then: dict[str, Any]) -> None:
        for one, part in zip(self.learns, then["parts"], strict=True):
            one.load_state_dict(copy.deepcopy(part))
        self.random.bit_generator.state = json.loads(then["random"])
        torch.set_rng_state(then["torch"])  # which drops units out, where a network has that

    def _write(self) -> None:
        self._written = time.monotonic()
        if self.file is None:
            return
        content = io.BytesIO()  # PyTorch's own error for a full disk is none of the system's
        torch.save({"rounds": self.rounds, "fit": self.fit}, content)
        whole = content.getvalue()
        with suppress(OSError):  # a full disk must not end what it is to keep
            write_bytes(self.file, hashlib.sha256(whole).digest() + whole)
