"""The comparisons of settings as sections of the page, from what `agents.compare` has found."""

from __future__ import annotations

from collections import Counter
from collections.abc import Iterable, Mapping
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np

from agents.compared import read_compared
from drillrig_env import markdown

Score = tuple[str, str, int]
"""A score of a comparison: its suite, its name, and the digits that it is shown with."""

_ABLATED: dict[str, Score] = {
    "`default`": ("default", "mitigated", 3),
    "below ω_c": ("default", "below", 3),
    "`wide`": ("wide", "mitigated", 3),
    "`load`": ("load", "mitigated", 3),
    "to calm, s": ("default", "time_to_calm", 1),
    "cost": ("default", "cost", 3),
}
_UNKNOWN: dict[str, Score] = {
    "mitigated": ("unknown", "mitigated", 3),
    "below ω_c": ("unknown", "below", 3),
    "calm": ("unknown", "calm", 3),
    "to calm, s": ("unknown", "time_to_calm", 1),
    "cost": ("unknown", "cost", 3),
}
_MET: dict[str, Score] = {
    "mitigated": ("default", "mitigated", 3),
    "calm": ("default", "calm", 3),
    "to calm, s": ("default", "time_to_calm", 1),
    "cost": ("default", "cost", 3),
}


@dataclass(frozen=True)
class _Section:
    """A comparison of `agents.compare` as a section: its name, heading and words, what a row is, and its columns.

    `rigs` says which they are that all are scored on, behind their number.
    """

    name: str
    heading: str
    words: str
    row: str
    scores: Mapping[str, Score]
    rigs: str = "rigs of each kind, of the training side, from developed stick-slip but for `load`"


_SECTIONS = (
    _Section(
        "ablations",
        "What each choice is worth",
        "The recipe that `ppo` began from with one piece changed at a time, and fewer steps by trial than the shipped "
        "agent had, whose draws are what this table led to. "
        "Mitigated shares on rigs drawn as in `default`, in all and below ω_c, in `wide` and in "
        "`load`; time to calm and cost in `default`.",
        "choice",
        _ABLATED,
    ),
    _Section(
        "newcomer",
        "What a newcomer gets",
        '`PPO("MlpPolicy", env)` and `SAC("MlpPolicy", env)` as Stable-Baselines3 has them, with no setting of one\'s '
        "own, on one rig, where no two seeds meet the same draws, and on many, on rigs drawn as in `default`.",
        "training",
        _MET,
    ),
    _Section(
        "unknown",
        "What was tried where nobody knows the rig",
        "A recipe for `ppo_unknown` that takes minutes, with one piece changed at a time (frames have settings of "
        "their own): a sixth of the steps by trial and three quarters of those of imitation that the shipped agent "
        "had. It imitates `LQROfRig`, its reward is `phases` as it is, and its memory estimates nothing; the row *as "
        "what ships* has all three as the shipped agent. * is told what no real rig tells.",
        "try",
        _UNKNOWN,
        "rigs at most, those of a fleet for validation drawn as in `unknown`, 16 episodes of each",
    ),
)


def choices(docs: Path) -> str:
    """What each piece of the recipe of `ppo` is worth, and what a newcomer gets; empty where nothing was compared."""
    return "\n".join(
        f"## {section.heading}\n\n{section.words} {_how(section, content['settings'].values())}\n\n"
        f"{_table(section.row, section.scores, content)}\n"
        for section, content in _found(docs)
    )


def made(docs: Path) -> list[str]:
    """Commands, dates and machines behind these sections, a line each."""
    return [
        f"- {section.name}: `{content['command']}`, {content['provenance']['date']}, {_machines(content)}"
        for section, content in _found(docs)
    ]


def _machines(content: Mapping[str, Any]) -> str:
    """Where the trainings ran, with how many of them where they ran on several machines."""
    count = Counter(run["machine"] for one in content["settings"].values() for run in one["runs"].values())
    return "; ".join(f"{machine} ({number} trainings)" for machine, number in count.most_common())


def _found(docs: Path) -> list[tuple[_Section, dict[str, Any]]]:
    """The sections that something was found for, with it."""
    found = [(section, read_compared(docs / "agents" / f"{section.name}.json")) for section in _SECTIONS]
    return [(section, content) for section, content in found if content["settings"]]


def _how(section: _Section, settings: Iterable[Mapping[str, Any]]) -> str:
    """How many rigs and of which side they are, and what the entries of the table say."""
    rigs = markdown.listed([f"{number:,}" for number in sorted({one["rigs"] for one in settings})], "or")
    return (
        f"{rigs} {section.rigs}. Mean over seeds, "
        "with the lowest and the highest, likely too near to each other where several rigs are learnt on at a time, as "
        "said above. The cost is that of the default reward, whatever they learnt with."
    )


def _table(what: str, scores: Mapping[str, Score], content: Mapping[str, Any]) -> str:
    """A row a setting, then the policies that are not trained."""
    headings = [what, "steps by trial", "seeds", *scores, "training, min"]
    rows = []
    for one in content["settings"].values():
        runs = one["runs"].values()
        minutes = _cell([run["seconds"] / 60 for run in runs], 1)
        steps = _steps(one["hyperparameters"])
        rows.append([one["words"], steps, len(runs), *_cells([run["scores"] for run in runs], scores), minutes])
    for one in content["beside"].get("policies", {}).values():
        rows.append([one["words"], "", "", *_cells([one["scores"]], scores), ""])
    return markdown.table(headings, rows)


def _steps(hyperparameters: Mapping[str, Any]) -> str:
    """Steps by trial, and in how many of them PPO's critic alone learns while the policy stays as it is."""
    rollout = hyperparameters.get("n_steps", 0) * hyperparameters.get("n_envs", 1)
    critic = int(hyperparameters.get("critic_iterations", 0) * rollout)
    return f"{hyperparameters['n_timesteps']:,}" + (f", {critic:,} of them the critic's alone" if critic else "")


def _cells(found: list[Mapping[str, Any]], scores: Mapping[str, Score]) -> list[str]:
    return [_cell([one[suite][name] for one in found], digits) for suite, name, digits in scores.values()]


def _cell(values: list[float | None], digits: int) -> str:
    """The mean over the seeds, with the lowest and the highest of several; "none" where no rig is of the kind."""
    known = [value for value in values if value is not None]
    if not known:
        return "none"
    ends = f" ({min(known):.{digits}f} to {max(known):.{digits}f})" if len(known) > 1 else ""
    return f"{np.mean(known):.{digits}f}{ends}"
