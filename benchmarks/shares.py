"""Where a training's time goes: Stable-Baselines3's own methods, timed while it learns.

The timers are put around methods of the classes and taken away again at the end; the training itself knows
nothing of them and learns the same. Phases:

| phase | holds |
|---|---|
| env | `reset` and `step` of the vector environment, resets at the ends of episodes included |
| policy | the network's answers while experience is collected: actions, values, probabilities |
| update | `train`: drawing batches, gradients, the optimisers' steps |
| validation | episodes that only tell how good the agent is; apart from training, in no share |
| other | the rest of training: buffers, advantages, callbacks, logs, checkpoints |
"""

from __future__ import annotations

import time
from collections.abc import Callable, Iterator
from contextlib import ExitStack, contextmanager
from functools import wraps
from typing import Any, TypeVar
from unittest import mock

import torch
from stable_baselines3.common.base_class import BaseAlgorithm
from stable_baselines3.common.callbacks import BaseCallback
from stable_baselines3.common.on_policy_algorithm import OnPolicyAlgorithm

PARTS = ("env", "policy", "update")
"""The timed phases of training; `other` is what they leave."""

F = TypeVar("F", bound=Callable[..., Any])


class Stopwatch:
    """Seconds spent in named phases; of a phase within a phase only the outer one counts."""

    def __init__(self) -> None:
        self.seconds = dict.fromkeys((*PARTS, "validation"), 0.0)
        self.readings = 0
        self._inside = False

    def timed(self, phase: str, function: F) -> F:
        """The same function, whose time counts for `phase`."""

        @wraps(function)
        def wrapped(*arguments: Any, **named: Any) -> Any:
            if self._inside:
                return function(*arguments, **named)
            self._inside = True
            begin = time.perf_counter()
            try:
                return function(*arguments, **named)
            finally:
                self.seconds[phase] += time.perf_counter() - begin
                self.readings += 1
                self._inside = False

        return wrapped  # type: ignore[return-value]


def seconds_of_a_reading(calls: int = 10_000) -> float:
    """What timing one call costs, s: the mean over `calls` of a function that does nothing."""

    def nothing() -> None:
        return

    timed = Stopwatch().timed("env", nothing)
    begin = time.perf_counter()
    for _ in range(calls):
        timed()
    return (time.perf_counter() - begin) / calls


class Watch(BaseCallback):
    """Read the stopwatch every `chunk` steps, validate, and end a training that has shown what is asked.

    `validate` gives the mitigated share of a model, and is called at the first rollout after each
    `validate_every` steps; without it there is no goal. The training ends when the share has reached `goal` and
    `chunks` have been read, or with the training's own last step. Chunks begin after the first update (and so
    after SAC's random steps): what comes before counts for the seconds to the goal alone. From the start on
    PyTorch has `torch_threads`, where they are given.
    """

    def __init__(
        self,
        chunk: int,
        chunks: int,
        validate: Callable[[BaseAlgorithm], float] | None = None,
        validate_every: int = 1,
        goal: float = 0.9,
        torch_threads: int | None = None,
    ) -> None:
        super().__init__()
        self.stopwatch = Stopwatch()
        self.chunk, self.least_chunks, self.goal, self.torch_threads = chunk, chunks, goal, torch_threads
        self.validate = self.stopwatch.timed("validation", validate) if validate else None
        self.validate_every = validate_every
        self.validations: dict[str, list[float]] = {"steps": [], "seconds": [], "mitigated": []}
        self.chunks: dict[str, list[float]] = {name: [] for name in ("steps", "seconds", *PARTS)}
        self.reached: dict[str, float] | None = None
        self.begun = self.ended = 0.0
        self._mark: dict[str, float] | None = None
        self._finished = False

    @property
    def seconds(self) -> float:
        """Seconds of training so far, validation not counted."""
        return (self.ended or time.perf_counter()) - self.begun - self.stopwatch.seconds["validation"]

    def _on_training_start(self) -> None:
        if self.torch_threads is not None:
            torch.set_num_threads(self.torch_threads)

    def _on_rollout_start(self) -> None:
        self._read()
        self._validate()
        enough = self.reached is not None or self.validate is None
        self._finished = enough and len(self.chunks["steps"]) >= self.least_chunks

    def _on_step(self) -> bool:
        return not self._finished

    def _on_training_end(self) -> None:
        if not self._finished:
            self._read()
            self._validate()

    def _read(self) -> None:
        """Close the chunk of steps that is full, and begin the next."""
        if self.model._n_updates == 0:
            return
        now = {"steps": self.num_timesteps, "seconds": self.seconds}
        now |= {name: self.stopwatch.seconds[name] for name in PARTS}
        if self._mark is None:
            self._mark = now
        elif now["steps"] - self._mark["steps"] >= self.chunk:
            for name, values in self.chunks.items():
                values.append(now[name] - self._mark[name])
            self._mark = now

    def _validate(self) -> None:
        last = self.validations["steps"][-1] if self.validations["steps"] else 0
        if self.validate is None or self.num_timesteps // self.validate_every <= last // self.validate_every:
            return
        seconds = self.seconds
        share = self.validate(self.model)
        for name, value in (("steps", self.num_timesteps), ("seconds", seconds), ("mitigated", share)):
            self.validations[name].append(value)
        if share >= self.goal and self.reached is None:
            self.reached = {"steps": self.num_timesteps, "seconds": seconds}


@contextmanager
def watched(kind: type[BaseAlgorithm], watch: Watch) -> Iterator[None]:
    """Let `watch` see every training of this algorithm that begins within the block."""
    learn = kind.learn

    def watched_learn(model: BaseAlgorithm, total: int, callback: Any = None, **named: Any) -> BaseAlgorithm:
        given = callback if isinstance(callback, list) else [callback] if callback else []
        watch.begun = time.perf_counter()
        try:
            with _timers(model, watch.stopwatch):
                return learn(model, total, callback=[*given, watch], **named)
        finally:
            watch.ended = time.perf_counter()

    with mock.patch.object(kind, "learn", watched_learn):
        yield


@contextmanager
def _timers(model: BaseAlgorithm, stopwatch: Stopwatch) -> Iterator[None]:
    """Time the methods that make up the phases, on their classes: an object that is saved must not hold a timer."""
    env, policy = type(model.env), type(model.policy)
    methods: list[tuple[str, type, str]] = [
        ("env", env, "reset"),
        ("env", env, "step"),
        ("update", type(model), "train"),
    ]
    if isinstance(model, OnPolicyAlgorithm):
        methods += [("policy", policy, "forward"), ("policy", policy, "predict_values")]
    else:
        methods += [("policy", type(model), "predict")]
    with ExitStack() as stack:
        for phase, owner, name in methods:
            stack.enter_context(mock.patch.object(owner, name, stopwatch.timed(phase, getattr(owner, name))))
        yield
