"""Beyond the chapter: laws of friction side by side, and what they make of critical speed and end of stick-slip."""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from drillrig_env.friction import Friction
from drillrig_env.friction.contact import LAWS
from drillrig_env.plots.own_rig import pressed
from drillrig_env.plots.style import BIT_SPEED, BLUE, GREEN, SPEED_REFERENCE, VERMILLION, Picture, new_figure
from drillrig_env.rig import Rig
from drillrig_env.scales import Scales
from drillrig_env.stability import critical_speed, end_of_stick_slip

_STYLES = dict(zip(LAWS, ((BLUE, "o"), (VERMILLION, "s"), (GREEN, "^")), strict=True))
_FORCES = np.array([6.0, 8.0, 10.0, 15.0, 20.0, 25.0, 30.0])  # N, on the chapter's rig


def laws_and_borders(rig: Rig) -> Picture:
    """The torque of every law at one normal force, and its borders over the normal force."""
    friction, scales = pressed(rig, 10.0), Scales.of(rig)
    figure = new_figure(2.9)
    curves, borders = figure.subplots(1, 2)
    speed = np.linspace(rig.omega_s, 4.0 * scales.speed, 400)
    said = []
    for law, (color, marker) in _STYLES.items():
        one = replace(friction, law=law)
        curves.plot(speed, one.torque(rig, speed), color=color, marker=marker, markevery=50, label=law)
        forces = _FORCES * scales.force
        pressed_so = replace(one, normal_force=forces)
        critical = np.asarray(critical_speed(rig, pressed_so))
        end = np.array([_end(rig, replace(one, normal_force=force)) for force in forces.tolist()])
        borders.plot(critical, forces, color=color, marker=marker)
        borders.plot(end, forces, color=color, marker=marker, ls="-.")
        at = int(np.flatnonzero(_FORCES == 10.0)[0])
        ends = f"{end[at]:.3f}" if np.isfinite(end[at]) else "an end that could not be followed, in"
        said.append(f"{law} {critical[at]:.3f} and {ends} rad/s")
    curves.set_xlabel(BIT_SPEED)
    curves.set_ylabel(r"friction torque $T_{r_1}$, N m")
    curves.set_ylim(0.0)
    borders.set_xlabel(SPEED_REFERENCE)
    borders.set_ylabel(r"normal force $N_1$, N")
    borders.set_xlim(0.0)
    figure.legend(loc="outside upper center", ncols=3)
    return Picture(
        figure,
        "Beyond the chapter: laws of friction with the same μ_s, μ_k and v_b, at left the torque at N_1 = "
        f"{friction.normal_force:.4g} N, at right the critical speed (solid) and the end of stick-slip (dash-dotted) "
        f"over the normal force. At {friction.normal_force:.4g} N they are: {', '.join(said)}.",
    )


def _end(rig: Rig, friction: Friction) -> float:
    """Speed (rad/s) at which stick-slip ends; NaN, a gap in the picture, where it cannot be followed there."""
    try:
        return float(end_of_stick_slip(rig, friction).speed)
    except ValueError:
        return np.nan
