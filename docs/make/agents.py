"""docs/agents.md and its pictures: what ships, how it learnt, what it does, and what each choice is worth.

The numbers come from `agents.shipping.ship` (agents/trained/*/seeds.json) and, as far as they are there, from
`agents.compare`, `agents.limits` and `agents.noise_and_delay` (docs/agents/*.json) and the stored results of `eval.py`
(docs/results); what a person saw in the pictures is quoted from docs/agents/findings.md.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np

from agents import limits_kept, noise_and_delay
from agents.beside_lqg import results_with_both, section
from agents.pictures.learning import action_zero, learning_curves
from agents.policy.run_folder import TRAINED, read_config, read_seeds, shipped
from agents.rivals import ahead, beside
from agents.shipping.card import SHARED_DRAWS, imitation_steps, training_minutes
from docs.make.choices import choices, made
from docs.make.contents import with_contents
from docs.make.use import USE
from drillrig_env import markdown
from drillrig_env.evaluation.provenance import when_and_where
from drillrig_env.evaluation.report import markdown_table
from drillrig_env.evaluation.results import Results
from drillrig_env.evaluation.statistics import interquartile_mean
from drillrig_env.evaluation.store import read
from drillrig_env.evaluation.suites import home_suite
from drillrig_env.evaluation.tables import MAIN, OTHERS, Table, stored_row

COMMAND = "python -m docs.make agents"
AGENT = "ppo"
"""The agent whose behaviour is shown."""


@dataclass(frozen=True)
class _Group:
    """Agents that are shown in one table: words above it, and what stands beside them.

    The latter are policies, each with its environment and what it is called. The agents are those at home in the suite
    `home`, through a softened drive or not.
    """

    words: str
    beside: tuple[tuple[str, str, str], ...]
    home: str = "default"
    is_soft: bool = False


_SHOWN = Table((*MAIN.columns, OTHERS.columns[0]), f"{MAIN.caption}; cost: mean of - reward")
_GROUPS = (
    _Group(
        "**On the rig's own drive**, the environment as `gym.make` gives it:\n",
        (
            ("constant", "DrillRig-v0", "action 0, same drive (`constant`)"),
            ("lqg", "DrillRig-v0", "`lqg`, same drive and sensors"),
            ("lqg", "DrillRigSurface-v0", "`lqg`, sensors of the surface"),
        ),
    ),
    _Group(
        "**Where nobody knows the rig**: sensors of the surface, late, on the rig's own drive, in the suite `unknown` "
        "([fleets](fleets.md)):\n",
        (
            ("constant", "DrillRigUnknown-v0", "action 0, same drive (`constant`)"),
            ("lqg", "DrillRigUnknown-v0", "`lqg`"),
            ("baselines/for_fleets.py:LQGOfFleet", "DrillRigUnknown-v0", "`lqg`, tuned on a fleet"),
        ),
        home="unknown",
    ),
    _Group(
        "**Where the rig drifts**: its friction wanders, its disc is tilted and its target steps, seen by sensors of "
        "the surface, late, on the rig's own drive, in the suite `drift` ([drift](drift.md)):\n",
        (
            ("constant", "DrillRigDrift-v0", "action 0, same drive (`constant`)"),
            ("lqg", "DrillRigDrift-v0", "`lqg`"),
            ("baselines/for_fleets.py:LQGOfFleet", "DrillRigDrift-v0", "`lqg`, tuned on a fleet"),
        ),
        home="drift",
    ),
    _Group(
        "**Where the drive is ours to change.** Softened gains, those of `soft_torque`, free most rigs without any "
        "agent; what an agent adds is small, and on the rig's own drive these agents do not work:\n",
        (("soft_torque", "DrillRig-v0", "action 0, same drive (`soft_torque`)"),),
        is_soft=True,
    ),
)

_LEVELS = (0.5, 0.9, 0.95)


@dataclass(frozen=True)
class _Agent:
    """A shipped agent: what its `config.json` and its `seeds.json` hold."""

    config: Mapping[str, Any]
    seeds: Mapping[str, Any]

    @property
    def home(self) -> str:
        """The suite of its rigs."""
        return home_suite(self.config["env_id"])

    @property
    def is_soft(self) -> bool:
        """Whether it works through a softened drive."""
        return bool(self.config["env_kwargs"].get("drive"))


def page(docs: Path, trained: Path = TRAINED) -> str:
    """The page as Markdown. `ValueError` where the agent that it shows is not shipped."""
    found = _found(trained)
    return with_contents(_written(docs, found, _stored(docs, found), noise_and_delay.read_shares(docs)))


def draw_pictures(docs: Path) -> list[Path]:
    """Draw the pictures of the page and list them."""
    from agents.pictures import draw_all

    found = _found()
    late = noise_and_delay.read_shares(docs)
    return draw_all(AGENT, docs / "images" / "agents", results=_beside_lqg(_stored(docs, found), found), late=late)


def _found(trained: Path = TRAINED) -> dict[str, _Agent]:
    """The shipped agents by name. `ValueError` where the one that the page shows is not among them."""
    found = {
        name: _Agent(read_config(trained / name), seeds)
        for name in shipped(trained)
        if (seeds := read_seeds(trained / name)) is not None
    }
    if AGENT not in found:
        raise ValueError(
            f"{trained} holds no agent {AGENT!r} with its seeds.json; make it with: python -m agents.shipping.ship"
        )
    return found


def _stored(docs: Path, found: Mapping[str, _Agent]) -> dict[str, Results]:
    """The stored results by environment, of the agents' and of those beside them, as far as they are there."""
    environments = {one.config["env_id"] for one in found.values()} | {
        one[1] for group in _GROUPS for one in group.beside
    }
    folders = {env_id: docs / "results" / env_id for env_id in sorted(environments)}
    return {env_id: read(folder) for env_id, folder in folders.items() if folder.is_dir()}


def _beside_lqg(stored: Mapping[str, Results], found: Mapping[str, _Agent]) -> dict[str, Results]:
    """The stored results of every agent for the rig's own drive, where they hold LQG too."""
    return results_with_both(stored, {name: one.config["env_id"] for name, one in found.items() if not one.is_soft})


def _written(
    docs: Path, found: Mapping[str, _Agent], stored: Mapping[str, Results], late: Mapping[str, Any] | None
) -> str:
    parts = [_shipped(found, stored), _learning(found), _behaviour(docs), section(_beside_lqg(stored, found))]
    parts += [noise_and_delay.section(late), limits_kept.section(limits_kept.read_limits(docs)), choices(docs)]
    parts += [ahead(stored, {name: one.config["env_id"] for name, one in found.items()}), USE, _made(docs, found, late)]
    return "\n".join(part for part in parts if part)


def _shipped(found: Mapping[str, _Agent], stored: Mapping[str, Results]) -> str:
    """What ships and what it scores, on the rig's own drive and on the softened one, beside action 0 and a rival."""
    parts = [
        "# The agents\n",
        "The agents learn on random rigs to move the drive's speed reference so that stick-slip ends and the bit turns "
        "calmly at the target. They are told neither the normal force nor the friction. The names below work wherever "
        'a policy is asked for, as in `python eval.py ppo`, and `drillrig_env.policy.load("ppo")` brings one with '
        "the environment that it belongs in.\n",
        f"On {found[AGENT].seeds['rigs']['default']:,} held-out rigs of the suite `default`, interquartile "
        "mean over all training seeds with its 95 % bootstrap interval; of what is not trained, with that over rigs. "
        f"{SHARED_DRAWS}\n",
    ]
    for group in _GROUPS:
        rows = {
            f"[`{name}`](../agents/trained/{name}/README.md)": stored_row(
                {**agent.seeds["pooled"][group.home]["main"], **agent.seeds["pooled"][group.home]["others"]}
            )
            for name, agent in found.items()
            if (agent.is_soft, agent.home) == (group.is_soft, group.home)
        }
        if rows:
            rows |= beside(stored, group.beside, group.home)
            parts += [group.words, markdown_table(_SHOWN, rows, {}, "policy"), ""]
    about = []
    for name, agent in found.items():
        config = agent.config
        steps, minutes = f"{config['hyperparameters']['n_timesteps']:,}", training_minutes(agent.seeds)
        imitated = imitation_steps(config)
        about.append(
            (
                f"`{name}`",
                f"`{config['env_id']}`",
                config["algorithm"],
                f"{imitated:,}" if imitated else "none",
                steps,
                minutes,
                len(agent.seeds["seeds"]),
            )
        )
    headings = ("agent", "environment", "algorithm", "steps of imitation", "of trial", "training, min a seed", "seeds")
    return "\n".join(
        [
            *parts,
            f"*{markdown.sentence(_SHOWN.caption)}*\n",
            markdown.table(headings, about, 3),
            "\nHeld calm at the target by the seed that ships, left to itself for longer than the suites' 60 s:\n",
            _endurance(found),
            "\nThe seed that ships is the one of median mitigated share, not the best one. Each agent's card has its "
            "scores in all suites, seed by seed, and where it fails.\n",
        ]
    )


def _endurance(found: Mapping[str, _Agent]) -> str:
    """How long each agent holds what it reached, as a table."""
    times = list(found[AGENT].seeds["endurance"])
    held = {f"`{name}`": agent.seeds["endurance"] for name, agent in found.items()}
    for agent in sorted(found.values(), key=lambda agent: agent.is_soft):
        drive = "softened drive" if agent.is_soft else "the rig's own drive"
        held.setdefault(f"action 0, {drive}, `{agent.config['env_id']}`", agent.seeds["action_zero"]["endurance"])
    rows = [[words, *(f"{shares[time]:.3f}" for time in times)] for words, shares in held.items()]
    return markdown.table(["agent", *(f"{time} s" for time in times)], rows)


def _learning(found: Mapping[str, _Agent]) -> str:
    """The learning curves, and when they pass what."""
    lines = [
        "## How they learn\n",
        "![Share of rigs mitigated over training steps, every seed](images/agents/learning.png)\n",
    ]
    headings = [
        "agent",
        *(f"steps to {level:g}" for level in _LEVELS),
        "at the end, lowest to highest seed",
        "action 0",
    ]
    rows = []
    for name, agent in found.items():
        steps, shares = learning_curves(agent.seeds)
        curve = interquartile_mean(shares, axis=0)
        passed = [
            f"{steps[np.argmax(curve >= level)]:,.0f}" if (curve >= level).any() else "never" for level in _LEVELS
        ]
        ends = f"{shares[:, -1].min():.3f} to {shares[:, -1].max():.3f}"
        rows.append([f"`{name}`", *passed, ends, f"{action_zero(agent.config):.3f}"])
    lines.append(markdown.table(headings, rows))
    lines.append(
        "\n*Steps by trial, beside those of imitation above, after which the interquartile mean over the seeds first "
        "reaches a mitigated share, as far as the evaluations during training resolve it; these rigs are not those of "
        "the suites. Action 0: the reference stays at the target, on the same drive and rigs.*\n"
    )
    return "\n".join(lines)


def _behaviour(docs: Path) -> str:
    """The pictures of behaviour and what a person saw in them."""
    words = docs / "agents" / "findings.md"
    seen = words.read_text(encoding="utf-8").strip() + "\n" if words.is_file() else ""
    return "\n".join(
        [
            f"## What `{AGENT}` does\n",
            "![One rig over time under three rivals and the agent, from the same start](images/agents/histories.png)\n",
            "![The agent's action over twist and bit speed, beside the torque law's](images/agents/plane.png)\n",
            seen,
        ]
    )


def _made(docs: Path, found: Mapping[str, _Agent], late: Mapping[str, Any] | None) -> str:
    """Commands, dates and machines behind the numbers."""
    lines = [f"## How it was made\n\nThis page and its pictures come from stored numbers with `{COMMAND}`.\n"]
    lines += [
        f"- `{name}`: `{agent.seeds['command']}`, {when_and_where(agent.seeds['provenance'])}"
        for name, agent in found.items()
    ]
    lines += made(docs)
    if limited := limits_kept.read_limits(docs):
        lines.append(f"- what limits: `{limited['command']}`, {when_and_where(limited['provenance'])}")
    if late:
        lines.append(f"- noise and delay: `{late['command']}`, {when_and_where(late['provenance'])}")
    return "\n".join(lines) + "\n"
