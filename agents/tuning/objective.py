"""What a try is worth: an objective by name, on a suite's draws of rigs that are neither trained nor judged on."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import replace
from functools import partial
from typing import Any

import numpy as np
from stable_baselines3.common.base_class import BaseAlgorithm
from stable_baselines3.common.callbacks import BaseCallback

from agents.policy.agent import Agent
from agents.policy.finding import at_slew_limit
from drillrig_env.evaluation.conditions import Conditions
from drillrig_env.evaluation.contestants import contestant_of
from drillrig_env.evaluation.runner import run
from drillrig_env.evaluation.scores import score
from drillrig_env.evaluation.suites import Suite, suite
from drillrig_env.parameters import closest, refuse
from drillrig_env.policy import PolicySource
from drillrig_env.rig import Rig
from drillrig_env.scales import Scales
from drillrig_env.seeds import TUNING_FLEETS, VALIDATION_SEEDS

_COST = 0.1

OBJECTIVES: dict[str, Callable[[Mapping[str, Any]], float]] = {
    "worth": lambda scores: float(scores["mitigated"].mean() - _COST * scores["cost"].mean()),
    "mitigated": lambda scores: float(scores["mitigated"].mean()),
    "calm": lambda scores: float(scores["calm"].mean()),
    "reward": lambda scores: -float(scores["cost"].mean()),
    "time_to_calm": lambda scores: -float(scores["time_to_calm"].mean()),
}
"""What is to be as large as can be, by name: the share mitigated less a tenth of the mean cost, either alone, ..."""

FIRST_RIG = VALIDATION_SEEDS.start + 100_000_000
"""The seed of the first rig: far from those by which a training chooses its best model."""


def validation_suite(name: str, rigs: int, scales: Scales | None = None) -> Suite:
    """Draws as in the suite of that name, of rigs for validation. `ValueError` for an unknown name and fixed rigs."""
    found = replace(suite(name, rigs, scales or Scales()), first_seed=FIRST_RIG)
    if found.name == "chapter":
        raise refuse("tune", "suite", name, "", "one that is drawn: its rigs are all judged on")
    fleet = found.scenario.rigs
    if fleet is None:
        return found
    return replace(found, scenario=replace(found.scenario, rigs=replace(fleet, seed=TUNING_FLEETS[-1])))


def objective_named(name: str) -> Callable[[Mapping[str, Any]], float]:
    """An objective by its name. `ValueError` for an unknown one, with the closest."""
    if name not in OBJECTIVES:
        raise ValueError(f"objective {name!r} is not known; {closest(name, OBJECTIVES)}")
    return OBJECTIVES[name]


def worth_of(
    model: BaseAlgorithm, config: Mapping[str, Any], objective: str, suite_name: str, rigs: int, threads: int | None
) -> float:
    """What an agent is worth, without exploration, under the conditions of its training. No generator is touched."""
    agent = Agent(model, config)
    conditions = Conditions.of(config["env_id"], config["env_kwargs"])
    rig, largest = Rig.of(config["env_kwargs"].get("rig")), config["env_kwargs"].get("largest_reference")
    conditions = replace(conditions, rig=rig, largest_reference=largest)
    source = PolicySource("agent", {"": partial(at_slew_limit, agent)}, {"kind": "run"})
    contestant = contestant_of(source, conditions)
    faced = validation_suite(suite_name, rigs, conditions.scales)
    scores = score(run(contestant.members[""](faced), faced, threads=threads, **contestant.env))
    return objective_named(objective)(scores)


class Watch(BaseCallback):
    """Tell what the agent is worth every `every` steps and at the end; the training ends where `told` says so.

    `told` gets steps and worth, and returns True where the try is not worth going on with.
    """

    def __init__(self, worth: Callable[[BaseAlgorithm], float], every: int, told: Callable[[int, float], bool]) -> None:
        super().__init__()
        self.worth, self.every, self.told = worth, every, told
        self.stopped = False
        self.last: tuple[int, float] = (0, -np.inf)

    def _on_rollout_start(self) -> None:
        if self.num_timesteps // self.every > self.last[0] // self.every:
            self._look()

    def _on_training_end(self) -> None:
        if not self.stopped and self.num_timesteps != self.last[0]:
            self._look()

    def _on_step(self) -> bool:
        return not self.stopped

    def _look(self) -> None:
        self.last = self.num_timesteps, self.worth(self.model)
        self.stopped = self.told(*self.last)
