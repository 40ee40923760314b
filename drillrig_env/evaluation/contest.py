"""A contest: who competes, and how everyone is put through a suite while failures stay their own."""

from __future__ import annotations

import json
from collections.abc import Callable, Iterable, Iterator, Mapping, Sequence
from dataclasses import asdict, dataclass, field
from pathlib import Path
from typing import Any

import numpy as np

from drillrig_env.drive import Drive
from drillrig_env.engine import Engine, used
from drillrig_env.engine.contract import innermost
from drillrig_env.evaluation.conditions import Conditions
from drillrig_env.evaluation.histories import Histories
from drillrig_env.evaluation.large import ROWS, check_large, store
from drillrig_env.evaluation.pieces import Field, Gathered, Piece, Told, file_name
from drillrig_env.evaluation.results import Results
from drillrig_env.evaluation.store import save
from drillrig_env.evaluation.suites import LARGE, Suite
from drillrig_env.policy import Policy
from drillrig_env.rig import Rig


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
    def of(cls, policy: str, suite: str, error: BaseException, calls: str | None = None) -> Failure:
        """The failure behind an exception, with the innermost `calls` of its traceback, by default its own."""
        text = f"{type(error).__name__}: {error}"
        return cls(policy, suite, text, innermost(error) if calls is None else calls)


def run_contest(
    suite: Suite,
    contestants: Iterable[Contestant],
    results: Results,
    histories: Histories,
    folder: Path | None = None,
    progress: Told | None = None,
    engine: Engine | str | None = None,
) -> list[Failure]:
    """Put every contestant through a suite, but for those whose results are there already.

    Results are added to `results` and `histories`, and written to `folder` after each policy; pieces of one that is not
    done are kept there too. Whatever a policy raises is a `Failure`; it leaves no rows, and the others go on.
    `progress` is called with a policy's name, and how many of how many steps or pieces are done. `engine` does the
    pieces; by default it is this process.
    """
    field = [one for one in contestants if not results.has(suite.name, one.name)]
    gathered = [Gathered(suite, one, place, folder) for place, one in enumerate(field)]
    failures: dict[int, Failure] = {}
    given: list[Piece] = []
    if folder and any(len(one.pieces) > 1 for one in gathered):
        if suite.rigs > LARGE:
            check_large()
        save(folder, results, histories)  # what the pieces are of
    with used(engine) as at:

        def waiting() -> Iterator[Piece]:
            for place, one in enumerate(gathered):
                for piece in one.open:
                    if place not in failures:
                        if progress and not at.here:
                            progress(one.contestant.name, len(one.pieces) - len(one.open), len(one.pieces))
                        given.append(piece)
                        yield piece

        for one in gathered:
            if one.pieces and not one.open:
                _end(one, results, histories, folder)
        for outcome in at.outcomes(Field(suite, field, progress if at.here else None), waiting()):
            piece = given[outcome.number]
            one = gathered[piece.contestant]
            if outcome.error is not None:
                failed = Failure.of(one.contestant.name, suite.name, outcome.error, outcome.calls)
                failures.setdefault(piece.contestant, failed)
                continue
            one.take(piece, outcome.value())
            if progress and not at.here:
                progress(one.contestant.name, len(one.pieces) - len(one.open), len(one.pieces))
            if not one.open:
                _end(one, results, histories, folder)
    for place, one in enumerate(gathered):
        if not one.pieces:
            nobody = ValueError(f"{one.contestant.name} has no members; allowed: at least one")
            failures[place] = Failure.of(one.contestant.name, suite.name, nobody)
    return [failures[place] for place in sorted(failures)]


def _end(one: Gathered, results: Results, histories: Histories, folder: Path | None) -> None:
    """Add a contestant whose pieces are all done to the results, and write them."""
    suite, name = one.suite, one.contestant.name
    if folder and suite.rigs > LARGE:
        path = folder / ROWS / suite.name / f"{file_name(name)}.parquet"
        results.add_stored(suite.name, name, store(path, (played.scores for played in one.played())))
        first = next(one.played()).scores
    else:
        parts = [played.scores for played in one.played()]
        scores = {column: np.concatenate([part[column] for part in parts]) for column in parts[0]}
        results.add(suite.name, name, scores)
        first = {column: values[: suite.rigs] for column, values in scores.items()}
    histories.keep(suite.name, name, one.traces, first)
    results.arrange(results.config.get("policies", ()))
    histories.arrange(results.policies)
    if folder:
        save(folder, results, histories)
        one.forget()


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
