"""A contest: who competes, and how everyone is put through a suite while failures stay their own."""

from __future__ import annotations

import json
import traceback
from collections.abc import Callable, Iterable, Mapping, Sequence
from dataclasses import asdict, dataclass, field
from pathlib import Path
from typing import Any

import numpy as np
import numpy.typing as npt

from drillrig_env.drive import Drive
from drillrig_env.evaluation.conditions import Conditions
from drillrig_env.evaluation.histories import Histories
from drillrig_env.evaluation.results import Results
from drillrig_env.evaluation.runner import Episodes, run
from drillrig_env.evaluation.scores import score
from drillrig_env.evaluation.store import save
from drillrig_env.evaluation.suites import Suite
from drillrig_env.policy import Policy
from drillrig_env.rig import Rig

_FRAMES = 3
"""Calls that a failure's traceback shows, the innermost."""


@dataclass(frozen=True)
class Contestant:
    """A policy that competes, or several training seeds of one.

    `members` make the policy for a suite, by training seed; "" is the seed of what is not trained. A
    policy is made anew for each suite, since its action is a share of the suite's slew limit. `env` holds
    the arguments of the environment, the sensors among them, and `about` what tells this policy from a
    changed one of the same name. `privileged` and `drive` are what it is told beyond the sensors, and how it sets the
    drive; `exact` whether it is shown its channels without noise and delay.
    """

    name: str
    members: Mapping[str, Callable[[Suite], Policy]]
    env: Mapping[str, Any]
    privileged: tuple[str, ...] = ()
    drive: Drive | None = None
    about: Mapping[str, Any] = field(default_factory=dict)
    exact: bool = False

    def description(self) -> dict[str, Any]:
        """What the results say of this policy."""
        return {
            "sensors": self.env["sensors"],
            "privileged": list(self.privileged),
            **({"exact": True} if self.exact else {}),
            "drive": None if self.drive is None else self.drive.as_dict(),
            "seeds": list(self.members),
            **self.about,
        }


@dataclass(frozen=True)
class Failure:
    """A policy that could not be made or run: its name, the suite if it got that far, and what was raised."""

    policy: str
    suite: str
    error: str
    trace: str = ""

    def __str__(self) -> str:
        where = f" in {self.suite}" if self.suite else ""
        return f"{self.policy} failed{where}: {self.error}"

    @classmethod
    def of(cls, policy: str, suite: str, error: BaseException) -> Failure:
        """The failure behind an exception, with the innermost calls of its traceback."""
        text = f"{type(error).__name__}: {error}"
        return cls(policy, suite, text, "".join(traceback.format_tb(error.__traceback__)[-_FRAMES:]).rstrip())


def run_contest(
    suite: Suite,
    contestants: Iterable[Contestant],
    results: Results,
    histories: Histories,
    folder: Path | None = None,
    progress: Callable[[str, int, int], None] | None = None,
) -> list[Failure]:
    """Put every contestant through a suite, but for those whose results are there already.

    Results are added to `results` and `histories`, and written to `folder` after each policy. Whatever
    a policy raises is a `Failure`; it leaves no rows, and the others go on. `progress` is called with a
    policy's name, the steps done and the steps in all.
    """
    failures = []
    for contestant in contestants:
        if results.has(suite.name, contestant.name):
            continue
        try:
            scores = _run_members(contestant, suite, histories, progress)
        except KeyboardInterrupt:
            raise
        except BaseException as error:  # a stranger's policy may raise anything
            failures.append(Failure.of(contestant.name, suite.name, error))
            continue
        results.add(suite.name, contestant.name, scores)
        results.arrange(results.config.get("policies", ()))
        if folder:
            save(folder, results, histories)
    return failures


def _run_members(
    contestant: Contestant,
    suite: Suite,
    histories: Histories,
    progress: Callable[[str, int, int], None] | None,
) -> dict[str, npt.NDArray[Any]]:
    """Scores of all members, one after another; the first member's typical rigs are kept."""
    parts: list[dict[str, npt.NDArray[Any]]] = []
    first: Episodes | None = None
    for number, (seed, make) in enumerate(contestant.members.items()):

        def shown(done: int, of: int, number: int = number) -> None:
            if progress:
                progress(contestant.name, number * of + done, len(contestant.members) * of)

        episodes = run(make(suite), suite, progress=shown, **contestant.env)
        first = first or episodes
        named = {"seed": np.full(suite.rigs, seed), "episode": np.arange(suite.rigs)}
        parts.append({**named, **score(episodes)})
    if first is None:
        raise ValueError(f"{contestant.name} has no members; allowed: at least one")
    histories.keep(suite.name, contestant.name, first, parts[0])
    return {name: np.concatenate([part[name] for part in parts]) for name in parts[0]}


def config_of(
    conditions: str | Conditions,
    suites: Sequence[Suite],
    contestants: Sequence[Contestant],
    version: str,
    command: str,
    reference: str,
) -> dict[str, Any]:
    """What `results.json` says was asked for, and what a continuation is compared with, as it reads from the file."""
    held = Conditions.named(conditions)
    config = {
        "command": command,
        "env": held.env_id,
        "noise": held.noise,
        "delay": held.delay,
        "version": version,
        "reference": reference,
        "suites": {suite.name: suite.definition() for suite in suites},
        "policies": {contestant.name: contestant.description() for contestant in contestants},
    }
    if held.rig != Rig():
        config["rig"] = asdict(held.rig)
    if held.largest_reference is not None:
        config["largest_reference"] = held.largest_reference
    if held.friction is not None:
        config["friction"] = held.friction.as_dict()
    read_back: dict[str, Any] = json.loads(json.dumps(config))
    return read_back
