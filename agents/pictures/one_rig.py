"""One rig over time under rivals and an agent, all from the very same start."""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np
from matplotlib.axes import Axes

import baselines
from agents.policy.finding import at_slew_limit
from agents.policy.run_folder import TRAINED, load_policy
from drillrig_env.arrays import FloatArray
from drillrig_env.env.core import EpisodeBatch
from drillrig_env.env.generators import first_uniforms
from drillrig_env.evaluation.histories import typical_rigs
from drillrig_env.evaluation.runner import Episodes, run
from drillrig_env.evaluation.scores import describe, time_to_calm
from drillrig_env.evaluation.suites import STICKING, default_suite
from drillrig_env.friction import Friction
from drillrig_env.plots.style import BLUE, DARK, PURPLE, TIME, VERMILLION, Picture, new_figure
from drillrig_env.policy import Policy
from drillrig_env.scales import CONTROL_PERIOD

RIVALS = ("constant", "z_torque", "lqg")
_SHOWN = 40.0  # s of the episode
_CONTACT = ("normal_force", "mu_s", "mu_k", "v_b")


@dataclass(frozen=True)
class TypicalRig:
    """A rig of the suite `default`: its place there, its friction, target and critical speed (rad/s), hardness."""

    place: int
    friction: Friction
    speed_target: float
    critical_speed: float
    hardness: float

    @property
    def words(self) -> str:
        """The rig in a caption."""
        return (
            f"rig {self.place} of the suite default (ω* = {self.speed_target:.2f} rad/s, "
            f"ω_c = {self.critical_speed:.2f} rad/s, N_1 = {float(self.friction.normal_force):.1f} N, "
            f"q = {self.hardness:.2f})"
        )


def typical_rig() -> TypicalRig:
    """Of the rigs of `default` below their critical speed, the one of median hardness."""
    suite = default_suite()
    core = EpisodeBatch(suite.rigs, scenario=suite.scenario)
    options = {**STICKING, "start": "steady"}  # no start needs to be run to know the rigs
    core.reset(np.arange(suite.rigs), first_uniforms(suite.first_seed, suite.rigs), options)
    rigs = describe(core.rig, core.friction, core.episodes["speed_target"])
    place = typical_rigs({**rigs, "seed": np.full(suite.rigs, "")})["below"]
    own = {name: float(values[place]) for name, values in rigs.items() if name != "region"}
    contact = Friction(*(own[name] for name in _CONTACT))
    return TypicalRig(place, contact, own["speed_target"], own["critical_speed"], own["hardness"])


def plot_one_rig(agent: str, trained: Path = TRAINED) -> Picture:
    """Bit speed with speed reference and target, and string torque below, a column a policy."""
    learnt = load_policy(trained / agent)
    policies: dict[str, tuple[Policy, Any]] = {name: (baselines.make(name), "state") for name in RIVALS}
    typical = typical_rig()
    alone = default_suite().only(typical.place)
    policies[agent] = (at_slew_limit(learnt, alone.slew_limit), learnt.environment["sensors"])
    figure = new_figure(3.4)
    panels = figure.subplots(2, len(policies), sharex=True, sharey="row", height_ratios=(1.7, 1.0))
    highest = 0.0
    for column, (name, (policy, sensors)) in enumerate(policies.items()):
        episodes = run(policy, alone, sensors=sensors)
        draw_speeds(panels[0, column], episodes, _SHOWN)
        panels[0, column].axhline(
            typical.critical_speed, color=DARK, lw=0.9, ls=(0, (1, 1.5)), label=r"critical speed $\omega_c$"
        )
        _torque(panels[1, column], episodes, _SHOWN)
        highest = max(highest, float(episodes.highest.max()))
        calm = float(time_to_calm(episodes)[0])
        over = "not calm" if calm >= episodes.lowest.shape[1] * CONTROL_PERIOD else f"calm at {calm:.1f} s"
        panels[0, column].set_title(name)
        panels[0, column].text(0.97, 0.97, over, ha="right", va="top", transform=panels[0, column].transAxes)
    panels[0, 0].set_ylim(-0.3, 1.15 * highest)
    panels[0, 0].set_ylabel("speed, rad/s")
    panels[1, 0].set_ylabel("string torque, N m")
    figure.legend(*panels[0, 0].get_legend_handles_labels(), loc="outside upper center", ncols=4)
    caption = (
        f"The same start under {len(policies)} policies: {typical.words}, which lies below its critical speed; it is "
        "the one of median hardness there. Calm: from when on the stick-slip index over the trailing 5 s stays below "
        "0.1, which takes 5 s at least."
    )
    return Picture(figure, caption)


def draw_speeds(panel: Axes, episodes: Episodes, shown: float, target: FloatArray | None = None) -> None:
    """Bit speed, speed reference and target of the first rig over the first `shown` s.

    The `target` (rad/s) has an entry a control step where it is not the last one all along.
    """
    time = _times(episodes, shown)
    panel.plot(time, episodes.average[0, : len(time)], color=BLUE, lw=0.9, label="bit speed")
    reference = episodes.speed_reference[0, : len(time)]
    panel.plot(time, reference, color=VERMILLION, lw=1.2, label=r"speed reference $\omega_{ref}$")
    wanted = np.full(len(time), episodes.speed_target[0]) if target is None else target[: len(time)]
    panel.step(time, wanted, where="pre", color=DARK, lw=0.9, ls=(0, (4, 2)), label=r"target $\omega^*$")
    panel.set_xlim(0.0, shown)


def _torque(panel: Axes, episodes: Episodes, shown: float) -> None:
    time = _times(episodes, shown)
    panel.plot(time, episodes.torque_into_string[0, : len(time)], color=PURPLE)
    panel.set_xlabel(TIME)
    panel.set_xticks([0, 20, 40])


def _times(episodes: Episodes, shown: float) -> np.ndarray:
    steps = min(episodes.lowest.shape[1], round(shown / CONTROL_PERIOD))
    return np.arange(1, steps + 1) * CONTROL_PERIOD
