"""What an agent does that LQG does not: a hard rig that only the agent brings to its target, step by step."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import numpy as np
import numpy.typing as npt
from matplotlib.axes import Axes
from matplotlib.ticker import MultipleLocator

from agents.beside_lqg import LAW, hard_rig
from agents.pictures.one_rig import draw_speeds
from agents.policy.run_folder import TRAINED, read_config
from drillrig_env.arrays import FloatArray
from drillrig_env.env.core import EpisodeBatch
from drillrig_env.env.generators import first_uniforms
from drillrig_env.evaluation.contest import Contestant
from drillrig_env.evaluation.contestants import contestant_of
from drillrig_env.evaluation.results import Results
from drillrig_env.evaluation.runner import Episodes, run
from drillrig_env.evaluation.suites import Suite, suite
from drillrig_env.plots.style import BLUE, DARK, TIME, VERMILLION, Picture, new_figure
from drillrig_env.policy import Policy, find_policy
from drillrig_env.scales import CONTROL_PERIOD

_SHAKES = 0.3  # swing of the bit speed over the target from which a step counts as shaking


def plot_beside(agent: str, results: Results, trained: Path = TRAINED) -> Picture:
    """The rig over time under the law and under the agent, and the agent's rate over the one the law would ask for.

    `ValueError` where the agent mitigates no rig that the law does not.
    """
    rig = hard_rig(results, agent)
    if rig is None:
        raise ValueError(f"{agent} mitigates no rig that {LAW} does not in the stored results")
    alone = suite(rig.suite, _rigs(results, rig.suite)).only(rig.place)
    env_id = read_config(trained / agent)["env_id"]
    law, learnt = (contestant_of(find_policy(name), env_id, agent) for name in (LAW, str(trained / agent)))
    listening = Listening(_made(learnt, alone), _made(law, alone))
    under_law, under_agent = run(_made(law, alone), alone, **law.env), run(listening, alone, **learnt.env)
    figure = new_figure(2.6)
    grid = figure.subplot_mosaic([["law", "rates"], ["agent", "rates"]], width_ratios=(1.75, 1.0))
    for panel, name, episodes in (("law", LAW, under_law), ("agent", agent, under_agent)):
        steps = episodes.average.shape[1]
        draw_speeds(grid[panel], episodes, CONTROL_PERIOD * steps, _target(alone, steps))
        grid[panel].set_title(name)
        grid[panel].set_ylabel("rad/s")
    grid["law"].sharex(grid["agent"])
    grid["law"].tick_params(labelbottom=False)
    top = 1.1 * max(float(one.highest.max()) for one in (under_law, under_agent))
    for panel in ("law", "agent"):
        grid[panel].set_ylim(-0.3, top)
    grid["agent"].set_xlabel(TIME)
    agreed = _rates(grid["rates"], agent, listening, alone.slew_limit, under_agent)
    figure.legend(*grid["law"].get_legend_handles_labels(), loc="outside upper center", ncols=3)
    caption = (
        f"The hardest rig that {agent} brings to its target and {LAW} does not, of the suite {rig.suite} (rig "
        f"{rig.place}, q = {rig.hardness:.1f}, N_1 = {rig.normal_force:.1f} N, ω* = {rig.speed_target:.2f} rad/s), the "
        f"suite in which there are most of them. Left: from the same start under either. Right: the rate that {agent} "
        f"asks for in each step of its own episode over the one that {LAW} would ask for in its place; the bit shakes "
        f"where it swung by more than {_SHAKES:.0%} of ω* in the step's last 2.5 s. Their signs agree in {agreed:.0%} "
        "of the steps."
    )
    return Picture(figure, caption)


class Listening(Policy):
    """An agent that acts, and a law that sees what it sees and is only asked; keeps what both say, in actions."""

    def __init__(self, agent: Policy, law: Policy) -> None:
        self.agent, self.law = agent, law
        self.said: list[tuple[float, float]] = []

    def predict(
        self,
        observation: npt.NDArray[np.float32],
        state: Any = None,
        episode_start: npt.NDArray[np.bool_] | None = None,
        deterministic: bool = True,
    ) -> tuple[np.ndarray, Any]:
        """The agent's actions."""
        own, law = state or (None, None)
        actions, own = self.agent.predict(observation, own, episode_start, deterministic)
        others, law = self.law.predict(observation, law, episode_start, deterministic)
        self.said.append((float(actions[0, 0]), float(others[0, 0])))
        return actions, (own, law)


def _rigs(results: Results, name: str) -> int:
    return int(results.config["suites"][name]["rigs"])


def _target(alone: Suite, steps: int) -> FloatArray:
    """The target of the only rig of a suite in each control step, rad/s."""
    core = EpisodeBatch(1, scenario=alone.scenario)
    core.reset(np.arange(1), first_uniforms(alone.first_seed, 1), {**alone.groups[0][1], "start": "steady"})
    rig = core.episodes[0]
    stepped = CONTROL_PERIOD * np.arange(steps) >= rig["target_time"]
    return np.asarray(np.where(stepped, rig["next_target"], rig["speed_target"]))


def _made(contestant: Contestant, alone: Suite) -> Policy:
    return next(iter(contestant.members.values()))(alone)


def _rates(panel: Axes, agent: str, listening: Listening, slew_limit: float, episodes: Episodes) -> float:
    """Draw the agent's rates over the law's, and return the share of steps in which their signs agree."""
    own, law = slew_limit * np.array(listening.said).T
    shaking = _swing(episodes) > _SHAKES
    for chosen, colour, marker, words in ((shaking, VERMILLION, "x", "shaking"), (~shaking, BLUE, ".", "calm")):
        panel.plot(law[chosen], own[chosen], marker, color=colour, ms=3.0, mew=0.7, alpha=0.6, label=words)
    panel.axline((0.0, 0.0), slope=1.0, color=DARK, lw=0.8, ls=(0, (4, 2)))
    reach = 1.08 * slew_limit
    panel.set(xlim=(-reach, reach), ylim=(-reach, reach), aspect="equal")
    for axis in (panel.xaxis, panel.yaxis):
        axis.set_major_locator(MultipleLocator(slew_limit / 2.0))
    panel.set_xlabel(f"rate of {LAW}, rad/s²")
    panel.set_ylabel(f"rate of {agent}, rad/s²")
    panel.legend(loc="lower center", bbox_to_anchor=(0.5, 1.0), ncols=2, markerscale=1.5, handletextpad=0.2)
    return float(np.mean(np.sign(own) == np.sign(law)))


def _swing(episodes: Episodes) -> FloatArray:
    """Half the range of the bit speed over the last 2.5 s before the end of each step, over the target."""
    width = round(2.5 / CONTROL_PERIOD)
    low, high = (
        np.array([ends(trace[0, max(0, k - width + 1) : k + 1]) for k in range(trace.shape[1])])
        for trace, ends in ((episodes.lowest, np.min), (episodes.highest, np.max))
    )
    return np.asarray((high - low) / 2.0 / episodes.speed_target[0])
