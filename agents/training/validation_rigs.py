"""Evaluation during training: the agent without exploration, on rigs that are neither trained nor judged on."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from typing import Any

import numpy as np
import numpy.typing as npt

from agents.policy.agent import Agent
from drillrig_env.env.core import RigBatch
from drillrig_env.env.generators import first_uniforms
from drillrig_env.evaluation.runner import play
from drillrig_env.evaluation.suites import STICKING

PRACTICE_SEEDS = 600_000_000
"""Rig i of the evaluation during training has the seed PRACTICE_SEEDS + i; training takes seeds below only."""


@dataclass(frozen=True, eq=False)
class Practice:
    """What an agent did with the rigs: sum of rewards and whether the rig was mitigated, shape (n,)."""

    returns: npt.NDArray[np.float64]
    mitigated: npt.NDArray[np.bool_]
    steps: int  # of an episode


def practise(agent: Agent, arguments: Mapping[str, Any], rigs: int) -> Practice:
    """Run `rigs` episodes side by side, from developed stick-slip and with a constant normal force.

    `arguments` are those of `RigBatch`. No generator of the training is touched.
    """
    core = RigBatch(rigs, **arguments)
    core.reset(np.arange(rigs), first_uniforms(PRACTICE_SEEDS, rigs), STICKING)
    returns = np.zeros(rigs)
    for _ in play(agent, core):
        returns += core.rigs["reward"]
    return Practice(returns, core.mitigated, core.steps)
