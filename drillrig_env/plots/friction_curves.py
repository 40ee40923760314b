"""Figures 4.1 and 4.8: the friction laws, and where their slope lets steady rotation be stable."""

from __future__ import annotations

import numpy as np

from drillrig_env.plots.own_rig import only_for_the_chapters, pressed, scale
from drillrig_env.plots.style import (
    BIT_SPEED,
    BLUE,
    DARK,
    GREY,
    Picture,
    mark,
    name_line_styles,
    new_figure,
    plot_stability,
)
from drillrig_env.rig import Rig
from drillrig_env.scales import Scales
from drillrig_env.stability import critical_slope, critical_speed

_TORQUE = r"friction torque $T_{r_1}$, N m"


def friction_laws(rig: Rig) -> Picture:
    """Figure 4.1: the discontinuous law (4-7) and the adopted one (4-9)."""
    friction = pressed(rig, 10.0)
    figure = new_figure(2.7)
    discontinuous, adopted = figure.subplots(1, 2, sharex=True, sharey=True)

    speed = np.linspace(0.0, 4.0 * Scales.of(rig).speed, 401)
    torque = np.asarray(friction.torque_discontinuous(rig, speed))
    discontinuous.plot(speed, torque, color=BLUE)
    discontinuous.plot(-speed, -torque, color=BLUE)
    discontinuous.plot([0, 0], [-torque[0], torque[0]], color=GREY, ls=":", lw=0.9)
    discontinuous.plot(0, torque[0], "o", color=BLUE)
    discontinuous.plot(0, -torque[0], "o", color=BLUE, mfc="white")
    discontinuous.set_title("(a) discontinuous, (4-7)")

    zone = np.linspace(-2.0 * rig.omega_s, 2.0 * rig.omega_s, 601)
    speed = np.unique(np.concatenate([-speed, zone, speed]))
    adopted.plot(speed, friction.torque(rig, speed), color=BLUE)
    adopted.set_title("(b) adopted, (4-9)")
    inset = adopted.inset_axes((0.65, 0.15, 0.34, 0.34))
    inset.plot(zone, friction.torque(rig, zone), color=BLUE)
    for edge in (-rig.omega_s, rig.omega_s):
        inset.axvline(edge, color=GREY, ls=":", lw=0.9)
    inset.set_xticks([-rig.omega_s, 0.0, rig.omega_s], [r"$-\omega_s$", "0", r"$\omega_s$"])
    inset.set_yticks([0.0, torque[0]], ["0", f"{torque[0]:.2f}" if 0.01 < torque[0] < 10.0 else f"{torque[0]:.3g}"])
    inset.set_title("the stick zone", fontsize=8, loc="center")

    for axes in (discontinuous, adopted):
        axes.set_xlabel(BIT_SPEED)
    discontinuous.set_ylabel(_TORQUE)
    return Picture(
        figure,
        "Friction torque on disc 1 over its speed: (a) the discontinuous law (4-7), with sign(0) = 1 (4-8), and "
        f"(b) the adopted law (4-9), a straight line for speeds below ω_s = {rig.omega_s:g} rad/s. "
        f"N_1 = {friction.normal_force:.4g} N, r_1 = {rig.r_1:g} m, μ_s = {friction.mu_s:g}, μ_k = {friction.mu_k:g}, "
        f"v_b = {friction.v_b:.4g} s/rad.",
    )


def stability_on_the_friction_curve(rig: Rig) -> Picture:
    """Figure 4.8: the friction torque, solid where steady rotation at that speed is stable."""
    slope, fastest = critical_slope(rig), 5.0 * scale(rig, 20.0)
    figure = new_figure(2.8)
    borders = {}
    panels = figure.subplots(1, 2, sharex=True)
    for axes, letter, force in zip(panels, "ab", (10.0, 20.0), strict=True):
        friction = pressed(rig, force)
        border = borders[f"{friction.normal_force:.4g}"] = float(critical_speed(rig, friction))
        speed = np.sort(np.append(np.linspace(rig.omega_s, fastest, 400), border))
        torque = np.asarray(friction.torque(rig, speed))
        plot_stability(axes, speed, torque, speed >= border)
        at_border = float(friction.torque(rig, border))
        reach = 1.1 * np.array([-1.0, 1.0]) * fastest / 5.0
        axes.plot(border + reach, at_border + slope * reach, color=DARK, ls="-.", lw=0.9, label="critical slope")
        axes.vlines(border, 0.0, at_border, color=GREY, ls=":", lw=0.9)
        mark(axes, border, at_border, rf"$\omega_c$ = {border:.3f} rad/s", (8, 10))
        axes.set_ylim(0.0, 1.08 * torque[0])
        axes.set_xlim(0.0, fastest)
        axes.set_title(f"({letter}) $N_1$ = {friction.normal_force:.4g} N")
        axes.set_xlabel(BIT_SPEED)
    panels[0].set_ylabel(_TORQUE)
    name_line_styles(panels[0], "lower right")
    speeds = " and ".join(f"{border:.3f} rad/s at {force} N" for force, border in borders.items())
    return Picture(
        figure,
        "Local stability by the Hurwitz criterion, on the friction curve: steady rotation is stable (solid) where the "
        f"slope of friction lies above ΔT_r,min = {slope:.4f} N m s/rad (4-25), and unstable (dashed) where friction "
        f"falls faster. The border is the critical speed ω_c: {speeds}"
        + only_for_the_chapters(rig, " (the chapter prints 1.994 and 2.689 rad/s)")
        + ".",
    )
