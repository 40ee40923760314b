"""Evaluation during training: the agent without exploration, on rigs that are neither trained nor judged on."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from typing import Any

import numpy as np
import numpy.typing as npt
from gymnasium.utils import seeding

from agents.agent import Agent
from drillrig_env.env.core import RigBatch

PRACTICE_SEEDS = 600_000_000
"""Rig i of the evaluation during training has the seed PRACTICE_SEEDS + i; training takes seeds below only."""

_OPTIONS = {"start": "stick_slip", "load_steps": []}


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
    generators = [seeding.np_random(PRACTICE_SEEDS + i)[0] for i in range(rigs)]
    core.reset(np.arange(rigs), generators, _OPTIONS)
    returns, state, begins = np.zeros(rigs), None, np.ones(rigs, dtype=np.bool_)
    for _ in range(core.steps):
        actions, state = agent.predict(core.observations, state, begins)
        begins = np.zeros(rigs, dtype=np.bool_)
        core.step(np.ascontiguousarray(actions, dtype=np.float32))
        returns += core.rigs["reward"]
    return Practice(returns, core.mitigated, core.steps)
