"""Does an agent hold what it reached? Episodes much longer than those that it was trained and judged in.

An episode of a suite lasts 60 s. A policy may be calm that long and still be on its way out: a reference
that is kept away from the target winds up the integral of the drive's speed loop.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence

import numpy as np

from agents.policy.action_zero import ActionZero
from agents.policy.agent import Agent
from drillrig_env.env.core import EpisodeBatch
from drillrig_env.env.generators import first_uniforms
from drillrig_env.evaluation.runner import play
from drillrig_env.evaluation.suites import STICKING, suite
from drillrig_env.scales import CONTROL_PERIOD
from drillrig_env.seeds import EVALUATION_SEEDS
from drillrig_env.verdict import WINDOW, is_mitigated

TIMES = (60.0, 120.0, 300.0, 600.0)
"""When the verdict is asked for, s."""

ENDURING = 200
"""Rigs that are put through that."""


def endurance(
    agent: Agent | ActionZero,
    rigs: int = ENDURING,
    times: Sequence[float] = TIMES,
    progress: Callable[[int, int], object] | None = None,
    suite_name: str = "default",
) -> dict[str, float]:
    """The share of rigs that are calm and at their target over the last 10 s before each of `times` (s).

    The rigs are drawn as in the suite `suite_name`, with the seeds of its first ones, each under the agent from
    stick-slip on without a break. `progress` is called with the control steps done, and with how many there are.
    """
    drawn = suite(suite_name, rigs)
    arguments = {**agent.environment, "duration": max(times), "scenario": drawn.scenario}
    core = EpisodeBatch(rigs, **arguments)
    core.reset(np.arange(rigs), first_uniforms(EVALUATION_SEEDS.start, rigs), STICKING)
    window = round(WINDOW / CONTROL_PERIOD)
    traces = np.zeros((3, window, rigs))
    found = {}
    for step in play(agent, core):
        traces[:, step % window] = [core.episodes[name] for name in ("lowest", "highest", "average")]
        for time in times:
            if step + 1 == round(time / CONTROL_PERIOD):
                lowest, highest, mean = traces[0].min(axis=0), traces[1].max(axis=0), traces[2].mean(axis=0)
                target, index = core.episodes["speed_target"], drawn.calm_index
                held = is_mitigated(lowest, highest, mean, target, index=index)
                found[f"{time:g}"] = float(np.mean(held))
        if progress and ((step + 1) % window == 0 or step + 1 == core.steps):
            progress(step + 1, core.steps)
    return found
