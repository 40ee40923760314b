"""What a policy does where: its action over the phase plane of twist and bit speed, around steady rotation."""

from __future__ import annotations

from collections.abc import Mapping
from pathlib import Path
from typing import Any

import numpy as np
from matplotlib.axes import Axes

import baselines
from agents.pictures.one_rig import TypicalRig, typical_rig
from agents.policy.run_folder import TRAINED, load_policy
from drillrig_env.arrays import FloatArray
from drillrig_env.env.core import EpisodeBatch
from drillrig_env.env.generators import first_uniforms
from drillrig_env.env.sensors import LIMIT, Sensors
from drillrig_env.evaluation.suites import STICKING
from drillrig_env.plots.style import BIT_SPEED, DARK, Picture, new_figure
from drillrig_env.policy import Policy
from drillrig_env.rig import Rig
from drillrig_env.scales import SLEW_LIMIT
from drillrig_env.verdict import STUCK_SPEED

LAW = "z_torque"
"""The torque law that is drawn beside the agent."""

_POINTS = 61  # along either axis
_BEFORE = 200  # control steps of steady rotation that the policy has seen
_CYCLES = 100  # control steps, more than two cycles of stick-slip
_WIDE = 1.15  # rad, of the twist to either side of that of steady rotation


def plot_plane(agent: str, trained: Path = TRAINED) -> Picture:
    """The rate of the speed reference that the torque law and the agent ask for, the agent in calm and in shaking."""
    typical = typical_rig()
    learnt = load_policy(trained / agent)
    law = baselines.make(LAW)
    shaking = {"bit_speed_deviation": typical.speed_target}
    panels_of: dict[str, tuple[Policy, Mapping[str, Any], Mapping[str, float]]] = {
        f"{LAW}": (law, {"sensors": "state"}, {}),
        f"{agent}, after calm": (learnt, learnt.environment, {}),
        f"{agent}, after shaking": (learnt, learnt.environment, shaking),
    }
    cycle = stick_slip_cycle(typical)
    figure = new_figure(2.6)
    panels = figure.subplots(1, len(panels_of), sharex=True, sharey=True)
    for panel, (title, (policy, arguments, pinned)) in zip(panels, panels_of.items(), strict=True):
        twist, speed, rate, steady_twist = rates_on_plane(policy, arguments, typical, pinned)
        mesh = panel.pcolormesh(
            twist, speed, rate, cmap="RdBu_r", vmin=-SLEW_LIMIT, vmax=SLEW_LIMIT, shading="gouraud", rasterized=True
        )
        panel.contour(twist, speed, rate, levels=[0.0], colors=[DARK], linewidths=0.8)
        panel.plot(*cycle, color="0.35", lw=1.0, ls=(0, (3, 1.5)))
        _mark_steady(panel, steady_twist, typical.speed_target)
        panel.set_title(title)
        panel.set_xlabel("twist of the string, rad")
        panel.grid(False)
    panels[0].set_ylabel(BIT_SPEED)
    figure.colorbar(mesh, ax=panels, label=r"rate of $\omega_{ref}$, rad/s$^2$", pad=0.02)
    caption = (
        f"The rate at which {LAW} and {agent} move the speed reference over the twist of the whole string and the bit "
        f"speed, {typical.words}. Cross: steady rotation at the target; full line: no change; dashed: the cycle of "
        "stick-slip on the stiff drive. Shafts and collars move as in the string's lowest mode; what else a policy "
        "sees is as in steady rotation at the target, on the drive that it works with, for 20 s before; for the right "
        "panel the running deviation of the bit speed is ω*, as in full stick-slip, in place of 0. A negative twist "
        "drives the bit. Each point is the answer to a first sight of it."
    )
    return Picture(figure, caption)


def rates_on_plane(
    policy: Policy, arguments: Mapping[str, Any], typical: TypicalRig, pinned: Mapping[str, float]
) -> tuple[FloatArray, FloatArray, FloatArray, float]:
    """Twists (rad), bit speeds (rad/s), the rates there (rad/s^2), shape (speeds, twists), and the steady twist.

    `arguments` make the environment that the policy works in; `pinned` puts channels at other values.
    The policy first sees steady rotation for a while, so that its memory is that of steady rotation.
    """
    core = _begin(typical, "steady", arguments)
    steady = {name: float(value[0]) for name, value in core.sensors.values(core.observations).items()}
    steady_twist = float(core.episodes["state"][0, 0] + core.episodes["state"][0, 1])
    twists = steady_twist + np.linspace(-_WIDE, _WIDE, _POINTS)
    speeds = np.linspace(0.0, 2.5 * typical.speed_target, _POINTS)
    twist, speed = (grid.ravel() for grid in np.meshgrid(twists, speeds))
    share = _share_of_upper_shaft(core.rig)
    top = typical.speed_target
    seen = {name: np.full(twist.size, value) for name, value in {**steady, **pinned}.items()}
    moved = {
        "twist_12": (1.0 - share) * twist,
        "twist_23": share * twist,
        "bit_speed": speed,
        "collar_speed": top + share * (speed - top),
    }
    before = observation(core.sensors, seen)
    at = observation(core.sensors, seen | {name: value for name, value in moved.items() if name in seen})
    state: Any = None
    for _ in range(_BEFORE):
        _, state = policy.predict(before, state)
    actions, _ = policy.predict(at, state)
    rates = core.slew_limit * np.asarray(actions, dtype=float)[:, 0]
    return twists, speeds, rates.reshape(_POINTS, _POINTS), steady_twist


def stick_slip_cycle(typical: TypicalRig) -> tuple[FloatArray, FloatArray]:
    """Twist (rad) and bit speed (rad/s) over one cycle of stick-slip on the rig's own drive, a point a control step."""
    core = _begin(typical, "stick_slip", {})
    states = []
    for _ in range(_CYCLES):
        states.append(core.episodes["state"][0].copy())
        core.step(np.zeros((1, 1), dtype=np.float32))
    path = np.array(states)
    stuck = path[:, 2] < STUCK_SPEED
    breaks_loose = np.flatnonzero(stuck[:-1] & ~stuck[1:])
    path = path[breaks_loose[0] : breaks_loose[1] + 1]
    return path[:, 0] + path[:, 1], path[:, 2]


def _begin(typical: TypicalRig, start: str, arguments: Mapping[str, Any]) -> EpisodeBatch:
    """The rig alone at the beginning of an episode."""
    core = EpisodeBatch(1, **arguments)
    options: dict[str, Any] = {**STICKING, "start": start, "speed_target": typical.speed_target}
    options |= {name: getattr(typical.friction, name) for name in ("normal_force", "mu_s", "mu_k", "v_b")}
    core.reset(np.arange(1), first_uniforms(0, 1), options)
    return core


def observation(sensors: Sensors, values: Mapping[str, FloatArray]) -> np.ndarray:
    """What the sensors show of physical values by channel, each of shape (n,); shape (n, channels), float32."""
    columns = []
    for channel in sensors.channels:
        offset = values["speed_target"] if channel.offset == "target" else channel.offset
        columns.append((values[channel.name] - offset) / channel.scale)
    return np.clip(np.stack(columns, axis=1), -LIMIT, LIMIT).astype(np.float32)


def _share_of_upper_shaft(rig: Rig) -> float:
    """The part of the whole string's twist that lies between collars and motor under the same torque."""
    return rig.k_1 / (rig.k_1 + rig.k_2)


def _mark_steady(panel: Axes, twist: float, speed: float) -> None:
    panel.plot([twist], [speed], "+", color=DARK, ms=8.0, mew=1.4)
