"""A curriculum: what episodes draw and what is seen of them grow harder whenever enough of the last were mitigated."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np
from stable_baselines3.common.callbacks import BaseCallback

from agents.policy.environment import batch_of
from drillrig_env.allowed import COUNT, SHARE, Made
from drillrig_env.env.scenario import Scenario
from drillrig_env.parameters import check_fields, parameter, refuse
from drillrig_env.toml import record_of

_SEEN = ("noise", "delay")
"""What stages may have beside scenarios: of the environment, how well it is seen."""


def _listed(given: Any, what: str) -> tuple[Any, ...]:
    if isinstance(given, str | Mapping) or not isinstance(given, Sequence):
        raise ValueError(f"{given!r} is not allowed; allowed: a list of {what}, from easy to hard")
    return tuple(given)


def _scenarios(given: Any) -> tuple[Any, ...]:
    for scenario in (found := _listed(given, "scenarios")):
        Scenario.named(scenario)
    return found


@dataclass(frozen=True)
class Stages:
    """Scenarios, noises and delays that come before the environment's own. `ValueError` for one that is not allowed."""

    scenarios: tuple[Any, ...] = parameter(
        (),
        meaning="what episodes draw, from easy to hard; then comes the environment's own",
        allowed=Made(_scenarios, "a list of scenarios, each as the environment takes it"),
    )
    noise: tuple[Any, ...] = parameter(
        (),
        meaning="of the measurements with each of these scenarios; if none, the environment's own",
        allowed=Made(lambda given: _listed(given, "noises"), "a list of noises, each as the environment takes it"),
    )
    delay: tuple[Any, ...] = parameter(
        (),
        "control steps",
        meaning="of the measurements with each of these scenarios; if none, the environment's own",
        allowed=Made(lambda given: _listed(given, "delays"), "a list of delays, each as the environment takes it"),
    )
    share: float = parameter(0.8, meaning="of the last episodes: mitigated before the next one begins", allowed=SHARE)
    episodes: int = parameter(200, meaning="of which that share is, since the scenario is what it is", allowed=COUNT)

    def __post_init__(self) -> None:
        check_fields(self)
        for name in _SEEN:
            if len(getattr(self, name)) not in (0, len(self.scenarios)):
                allowed = f"{len(self.scenarios)}, one for each scenario, or none"
                raise refuse("curriculum", f"length of {name}", len(getattr(self, name)), "", allowed)

    def environments(self, last: Mapping[str, Any]) -> list[dict[str, Any]]:
        """What of the environment is given anew in each stage, by name; in the end the `last` of it, its own."""
        names = ["scenario", *(name for name in _SEEN if getattr(self, name))]
        columns = (self.scenarios, *(getattr(self, name) for name in names[1:]))
        stages = [dict(zip(names, values, strict=True)) for values in zip(*columns, strict=True)]
        return [*stages, {name: last[name] for name in names}]

    @classmethod
    def of(cls, given: Any) -> Stages:
        """Stages from their fields. `ValueError` for an unknown one, with the closest known name, and for no stages."""
        stages = record_of(cls, "curriculum", given)
        if not stages.scenarios:
            raise ValueError("curriculum: scenarios: [] is not allowed; allowed: a list of scenarios, easy ones first")
        return stages


class Curriculum(BaseCallback):
    """Give all rigs of a training the next stage once they have mitigated a share of their last episodes.

    It does so between two rollouts, and scenario and delay hold from the next episodes on: those that began before are
    not counted. `last` has the environment's own scenario, noise and delay, as it takes them. How far a training is, is
    kept with its model, so that one that goes on is as far.
    """

    def __init__(self, stages: Stages, last: Mapping[str, Any]) -> None:
        super().__init__()
        self.stages, self.environments = stages, stages.environments(last)

    @property
    def stage(self) -> int:
        """How many stages are behind the training."""
        return int(self._so_far["stage"])

    @property
    def _so_far(self) -> dict[str, Any]:
        """The stage, which of its last episodes were mitigated, and which rigs are still in an episode from before."""
        model: Any = self.model
        if not hasattr(model, "curriculum"):
            model.curriculum = _at_stage(0, began_before=[False] * self.training_env.num_envs)
        found: dict[str, Any] = model.curriculum
        return found

    def _on_rollout_start(self) -> None:
        mitigated = self._so_far["mitigated"]
        enough = len(mitigated) == self.stages.episodes and np.mean(mitigated) >= self.stages.share
        if enough and self.stage < len(self.stages.scenarios):
            model: Any = self.model
            model.curriculum = _at_stage(self.stage + 1, began_before=[True] * self.training_env.num_envs)
            batch_of(self.training_env).change(**self.environments[self.stage])
        self.logger.record("curriculum/stage", self.stage)

    def _on_step(self) -> bool:
        so_far, infos = self._so_far, self.locals["infos"]
        for rig in np.flatnonzero(self.locals["dones"]).tolist():
            if not so_far["began_before"][rig]:
                so_far["mitigated"].append(infos[rig]["is_success"])
            so_far["began_before"][rig] = False
        del so_far["mitigated"][: -self.stages.episodes]
        return True


def _at_stage(stage: int, began_before: list[bool]) -> dict[str, Any]:
    return {"stage": stage, "mitigated": [], "began_before": began_before}
