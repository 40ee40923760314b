"""Evaluation during training: the agent without exploration, on rigs that are neither trained nor judged on."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, replace
from typing import Any

import numpy as np
import numpy.typing as npt

from drillrig_env.env.core import EpisodeBatch
from drillrig_env.env.generators import first_uniforms
from drillrig_env.env.scenario import Scenario
from drillrig_env.evaluation.runner import play
from drillrig_env.evaluation.suites import LARGEST_FLEET, STICKING
from drillrig_env.policy import Policy
from drillrig_env.seeds import VALIDATION_FLEETS, VALIDATION_SEEDS
from drillrig_env.verdict import CALM_INDEX, MOVING_INDEX


@dataclass(frozen=True, eq=False)
class Validation:
    """What a policy did with the rigs: sum of rewards and whether the rig was mitigated, shape (n,)."""

    returns: npt.NDArray[np.float64]
    mitigated: npt.NDArray[np.bool_]
    steps: int  # of an episode


def of_validation(scenario: Scenario) -> Scenario:
    """The scenario with a fleet, where it has one that is drawn, of other rigs: to choose settings by, not to learn on.

    It has at most as many as a suite's fleet.
    """
    fleet = scenario.rigs
    if fleet is None or not fleet.spread:
        return scenario
    others = replace(fleet, seed=VALIDATION_FLEETS.start, count=min(fleet.count, LARGEST_FLEET))
    return replace(scenario, rigs=others)


def validate(policy: Policy, arguments: Mapping[str, Any], rigs: int) -> Validation:
    """Run `rigs` episodes side by side, from developed stick-slip and with a constant normal force.

    `arguments` are those of `EpisodeBatch`. The rigs are drawn evenly, also where training shows the hard ones more
    often, and of a fleet that is drawn, they are others. No generator of the training is touched. A rig whose disc is
    tilted is never quite calm: there, as in the suite `drift`, a bit that is certain not to stop counts as calm.
    """
    core = EpisodeBatch(rigs, **arguments)
    core.change(scenario=of_validation(replace(core.scenario, candidates=1, target_skew=1.0)))
    core.reset(np.arange(rigs), first_uniforms(VALIDATION_SEEDS.start, rigs), STICKING)
    returns = np.zeros(rigs)
    for _ in play(policy, core):
        returns += core.episodes["reward"]
    index = CALM_INDEX if core.scenario.tilt is None else MOVING_INDEX
    return Validation(returns, core.mitigated_below(index), core.steps)
