"""The file of a comparison: what every trained agent scored, kept as it is found, by several processes at a time."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace
from pathlib import Path
from typing import Any

import numpy as np

from agents.training.validation_rigs import of_validation
from agents.variants import COMPARISONS
from drillrig_env.env.task import Task
from drillrig_env.evaluation.provenance import provenance
from drillrig_env.evaluation.runner import run
from drillrig_env.evaluation.scores import score
from drillrig_env.evaluation.suites import suite
from drillrig_env.files import json_text, owned, read_json, write_text
from drillrig_env.policy import Policy, context_of, make_policy
from drillrig_env.seeds import VALIDATION_SEEDS

SUITES = ("default", "wide", "load")
"""Suites whose draws are scored on, with seeds of the training side."""

_WAIT = 60.0  # s, for another process that writes


@dataclass(frozen=True)
class Compared:
    """What a comparison has found, in `file`; `lock` is a folder in which those who write take turns.

    `names` are those of all its settings, in the order that they are to have, and `command` is what makes the file.
    `comparison` is what they are compared for: a file of another one is not touched. None takes any.
    """

    file: Path
    lock: Path
    names: Sequence[str]
    command: str
    comparison: str | None = None

    def read(self) -> dict[str, Any]:
        """All that is there by now. `ValueError` where the file is damaged, or of another comparison."""
        content = read_compared(self.file)
        if self.comparison is not None and self.file.is_file() and self.comparison != (of := _comparison_of(content)):
            known = "does not tell which comparison it is of" if of is None else f"is of the comparison {of!r}"
            raise ValueError(f"{self.file} {known}, and not {self.comparison!r}; name another file with --output")
        return content

    def check(self, rigs: int) -> None:
        """Raise `ValueError` where nothing on `rigs` rigs can be added: the file is damaged, or of other ones."""
        content = self.read()
        numbers = {one["rigs"] for one in (content["beside"], *content["settings"].values()) if one} - {rigs}
        if numbers:
            there = " and ".join(map(str, sorted(numbers)))
            raise ValueError(f"{self.file} is of {there} rigs, not of {rigs}; name another file with --output")

    def has(self, name: str, about: Mapping[str, Any], seed: int) -> bool:
        """Whether this seed of a setting is there, trained and scored as `about` has it."""
        entry = self.read()["settings"].get(name, {})
        return _about(entry) == about and str(seed) in entry["runs"]

    def keep(self, name: str, about: Mapping[str, Any], seed: int, found: Mapping[str, Any]) -> None:
        """Keep what a seed of a setting was found to do. Seeds of the same setting as it was before are left out."""
        with owned(self.lock, _WAIT):
            content = self.read()
            settings = content["settings"]
            if _about(settings.get(name, {})) != about:
                settings[name] = {**about, "runs": {}}
            runs = {**settings[name]["runs"], str(seed): found}
            settings[name]["runs"] = {key: runs[key] for key in sorted(runs, key=int)}
            content["settings"] = {one: settings[one] for one in self.names if one in settings}
            self._write(content)

    def keep_beside(self, rigs: int, name: str, row: Mapping[str, Any]) -> None:
        """Keep what a policy that is not trained scored on `rigs` rigs, with what a table calls it."""
        with owned(self.lock, _WAIT):
            content = self.read()
            policies = {**content["beside"].get("policies", {}), name: row}
            self._write({**content, "beside": {"rigs": rigs, "policies": policies}})

    def _write(self, content: Mapping[str, Any]) -> None:
        of = {} if self.comparison is None else {"comparison": self.comparison}
        made = {"command": self.command, **of, "provenance": provenance()}
        write_text(
            self.file, json_text({**made, "beside": content["beside"], "settings": content["settings"]}, indent=1)
        )


def read_compared(file: Path) -> dict[str, Any]:
    """What a comparison's file holds; no setting and no policy beside them where there is none.

    `ValueError` where it is damaged.
    """
    nothing: dict[str, Any] = {"beside": {}, "settings": {}}
    return read_json(file, "remove it, and begin again", _fault) if file.is_file() else nothing


def _fault(content: Mapping[str, Any]) -> str:
    """What a file's content lacks, in words; empty where nothing."""
    for name in ("beside", "settings"):
        if not isinstance(content.get(name), dict):
            return f"it has no {name} by name"
    beside = content["beside"]
    if beside and not (_has_rigs(beside) and _all_dicts(beside.get("policies", {}))):
        return "what stands beside the settings has no rigs and policies"
    for name, entry in content["settings"].items():
        if not isinstance(entry, dict) or not _has_rigs(entry) or not _all_dicts(entry.get("runs")):
            return f"setting {name!r} has no rigs and runs"
        for seed, scored in entry["runs"].items():
            if not seed.isdecimal() or not _all_dicts(scored.get("scores")):
                return f"setting {name!r} has no scores of seed {seed}"
    return ""


def _has_rigs(entry: Mapping[str, Any]) -> bool:
    return type(entry.get("rigs")) is int


def _all_dicts(entries: Any) -> bool:
    return isinstance(entries, dict) and all(isinstance(one, dict) for one in entries.values())


def _comparison_of(content: Mapping[str, Any]) -> str | None:
    """Which comparison a file is of; where it does not say so, by the command that made it. None where none tells."""
    if "comparison" in content:
        return str(content["comparison"])
    return next((word for word in str(content.get("command", "")).split() if word in COMPARISONS), None)


def evaluate(
    policy: Policy | str, sensors: Any, rigs: int, threads: int | None = None, suites: Sequence[str] | None = None
) -> dict[str, Any]:
    """What a policy that sees these sensors does on `rigs` rigs of the training side, drawn as in each of some suites.

    `policy` is one, or its name: then it is made for each suite, such as one that is told which rig of a fleet it has.
    `suites` are SUITES if None; of a fleet there are at most as many rigs as the suite has, with all of their draws.

    Of each suite: mitigated and calm share of all rigs, mitigated share of those below the critical speed (None where
    there is none), median time to calm (s) and mean cost with the environment's default reward.
    """
    found = {}
    for name in SUITES if suites is None else suites:
        drawn = suite(name, rigs)
        drawn = replace(drawn, first_seed=VALIDATION_SEEDS.start, scenario=of_validation(drawn.scenario))
        task = Task.of(sensors=sensors, scenario=drawn.scenario, **drawn.env)
        made = make_policy(policy, **context_of(task)) if isinstance(policy, str) else policy
        scores = score(run(made, drawn, sensors=sensors, threads=threads))
        below = scores["mitigated"][scores["region"] == "below"]
        found[name] = {
            "mitigated": float(scores["mitigated"].mean()),
            "calm": float(scores["calm"].mean()),
            "below": float(below.mean()) if len(below) else None,
            "time_to_calm": float(np.median(np.asarray(scores["time_to_calm"], dtype=float))),
            "cost": float(scores["cost"].mean()),
        }
    return found


def _about(entry: Mapping[str, Any]) -> dict[str, Any]:
    return {name: value for name, value in entry.items() if name != "runs"}
