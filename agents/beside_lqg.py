"""What an agent frees that LQG does not, and the other way round, rig by rig, from the stored results of `eval.py`."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass

import numpy as np

from drillrig_env import markdown
from drillrig_env.evaluation.results import Results

LAW = "lqg"


@dataclass(frozen=True)
class HardRig:
    """The hardest rig that an agent mitigates and the law does not, in the suite that has most such rigs."""

    suite: str
    place: int
    hardness: float
    normal_force: float  # N
    speed_target: float  # rad/s


def results_with_both(stored: Mapping[str, Results], agents: Mapping[str, str]) -> dict[str, Results]:
    """The results by agent, of those by environment, where they hold the law as well.

    `agents` are their environments by name.
    """
    return {
        name: stored[env_id]
        for name, env_id in agents.items()
        if env_id in stored and {name, LAW} <= set(stored[env_id].policies)
    }


def hard_rig(results: Results, agent: str) -> HardRig | None:
    """That rig; None where the agent mitigates none that the law does not."""
    found: HardRig | None = None
    most = 0
    for name in _suites(results, agent):
        own, law = results.scores[name][agent], results.scores[name][LAW]
        only = own["mitigated"] & ~law["mitigated"]
        if only.sum() > most:
            most = int(only.sum())
            place = int(np.argmax(np.where(only, own["hardness"], -np.inf)))
            numbers = (float(own[column][place]) for column in ("hardness", "normal_force", "speed_target"))
            found = HardRig(name, place, *numbers)
    return found


def section(found: Mapping[str, Results]) -> str:
    """For every agent which rigs only it and which only the law frees, with the picture of one; empty without any."""
    if not found:
        return ""
    lines = [
        f"## What the agents do that `{LAW}` does not\n",
        "The same rigs under both, from [the stored results](results.md): how many are mitigated by both, by the "
        f"agent alone, by `{LAW}` alone and by neither; and who is calm sooner, where both get there.\n",
    ]
    headings = ("suite", "rigs", "both", "agent alone", f"`{LAW}` alone", "neither", "calm sooner: agent", f"`{LAW}`")
    for name, results in found.items():
        rows = [_compared(suite, results, name) for suite in _suites(results, name)]
        lines += [f"`{name}`:\n", markdown.table(headings, rows), ""]
        if hard_rig(results, name):
            about = f"A hard rig under `{LAW}` and under `{name}`, and the rates that both ask for"
            lines.append(f"![{about}](images/agents/{picture_name(name)}.png)\n")
    return "\n".join(lines)


def picture_name(agent: str) -> str:
    """The name of an agent's picture."""
    return f"beside_{agent}"


def _suites(results: Results, agent: str) -> list[str]:
    return [name for name, scores in results.scores.items() if {agent, LAW} <= set(scores)]


def _compared(suite: str, results: Results, agent: str) -> tuple[str, ...]:
    own, law = results.scores[suite][agent], results.scores[suite][LAW]
    ours, theirs = own["mitigated"], law["mitigated"]
    both = ours & theirs
    sooner = own["time_to_calm"] - law["time_to_calm"]
    counts = (len(ours), both.sum(), (ours & ~theirs).sum(), (theirs & ~ours).sum(), (~ours & ~theirs).sum())
    sooner_of_both = ((both & (sooner < 0)).sum(), (both & (sooner > 0)).sum())
    return (f"`{suite}`", *(f"{count:,}" for count in (*counts, *sooner_of_both)))
