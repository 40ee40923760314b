"""Figures 4.12 and 4.13, the bifurcation diagrams; and, beyond the chapter, the bistable region."""

from __future__ import annotations

from typing import Any

import numpy as np
from matplotlib.axes import Axes

from drillrig_env.model import STATE_NAMES, minimum_speed, steady_state
from drillrig_env.plots.own_rig import only_for_the_chapters, pressed, rounded, scale
from drillrig_env.plots.style import (
    BIT_SPEED,
    BLUE,
    DARK,
    GREEN,
    SPEED_REFERENCE,
    TWIST,
    VERMILLION,
    Picture,
    mark,
    name_line_styles,
    new_figure,
    plot_stability,
)
from drillrig_env.rig import Rig
from drillrig_env.scales import Scales
from drillrig_env.stability import (
    Diagram,
    PeriodicOrbit,
    bifurcation_diagram,
    critical_speed,
    fold_speed,
    hopf_and_fold_curves,
    stick_slip_orbit,
)

_ON_P1 = (1.0, 1.8, 2.6)  # rad/s; where figure 4.12 takes its points 1, 2 and 3 on the chapter's rig
_BIT = STATE_NAMES.index("bit_speed")
_TWIST = STATE_NAMES.index("twist_12")


def diagram_with_orbits(rig: Rig) -> Picture:
    """Figure 4.12: the diagram at 10 N, and three orbits of p1 in the phase plane."""
    friction, reach = pressed(rig, 10.0), scale(rig, 10.0)
    on_p1 = [rounded(speed * reach) for speed in _ON_P1]
    diagram = bifurcation_diagram(rig, friction, points=180, speeds=(0.005 * reach, 4.0 * reach))
    figure = new_figure(5.4)
    panels: dict[str, Any] = figure.subplot_mosaic([["diagram"] * 3, ["0", "1", "2"]], height_ratios=(1.55, 1.0))
    _draw_diagram(panels["diagram"], diagram, 4.0 * reach)
    for index in (1, 2):
        panels[str(index)].sharey(panels["0"])
        panels[str(index)].sharex(panels["0"])
    for index, speed in enumerate(on_p1):
        orbit = stick_slip_orbit(rig, friction, speed)
        peak = float(np.max(orbit.highest[0]))
        mark(panels["diagram"], speed, peak, f"{index + 1}", (-3, 5), ha="right", weight="bold")
        _draw_orbit(panels[str(index)], orbit, index + 1)
    panels["0"].set_ylabel(BIT_SPEED)
    points = ", ".join(f"{speed:g}" for speed in on_p1)
    return Picture(
        figure,
        f"{_described(diagram)} Below: the points 1, 2 and 3 on p1, at {points} rad/s (chosen), as orbits with "
        "stick-slip in the phase plane; the flat part at zero speed is the stick phase, the cross is steady rotation.",
    )


def diagram_at_a_larger_force(rig: Rig) -> Picture:
    """Figure 4.13: the diagram at 20 N."""
    reach = scale(rig, 20.0)
    diagram = bifurcation_diagram(rig, pressed(rig, 20.0), points=180, speeds=(0.005 * reach, 6.0 * reach))
    figure = new_figure(3.6)
    _draw_diagram(figure.subplots(), diagram, 6.0 * reach)
    lighter = pressed(rig, 10.0)
    narrower = float(fold_speed(diagram.rig, lighter)) - float(critical_speed(diagram.rig, lighter))
    return Picture(
        figure,
        f"{_described(diagram)} The range of bistability, {diagram.special['fold'] - diagram.special['H2']:.3f} rad/s, "
        f"stands beside {narrower:.3f} rad/s at {lighter.normal_force:.4g} N, in figure 4.12.",
    )


def _draw_diagram(axes: Axes, diagram: Diagram, fastest: float) -> None:
    """Equilibria, and the extremes of the bit speed on p1 and p2, with every branch and special point named."""
    hopf, fold = diagram.special["H2"], diagram.special["fold"]
    speed = diagram.equilibria["speed_reference"]
    axes.axvspan(hopf, fold, color="0.93", lw=0.0)
    plot_stability(axes, speed, diagram.equilibria["state"][:, _BIT], speed >= hopf)
    for branch in (diagram.p1, diagram.p2):
        points = branch.points
        for extreme in ("lowest_bit_speed", "highest_bit_speed"):
            plot_stability(axes, points["speed_reference"], points[extreme], points["stable"])
    top = float(diagram.p1.points["highest_bit_speed"].max())
    grazing = diagram.p2.points[-1]
    axes.plot([fold, fold], [grazing["lowest_bit_speed"], grazing["highest_bit_speed"]], "o", color=DARK, ms=4.0)
    axes.annotate("fold", (fold, float(grazing["highest_bit_speed"])), (6, 0), textcoords="offset points")
    mark(axes, diagram.special["H1"], 0.0, "$H_1$", (-2, 6), ha="right")
    mark(axes, hopf, hopf, "$H_2$", (-2, 6), ha="right")
    middle = diagram.p2.points[int(0.6 * len(diagram.p2.points))]
    _name(axes, "$e_1$", (0.55 * hopf, 0.55 * hopf), (8, -10))
    _name(axes, "$e_2$", (0.5 * (fold + fastest), 0.5 * (fold + fastest)), (8, -10))
    _name(axes, "$p_1$", (0.3 * hopf, float(_peak(diagram, 0.3 * hopf))), (-10, 8))
    _name(axes, "$p_1$", (0.55 * hopf, 0.0), (0, 5))
    _name(axes, "$p_2$", (float(middle["speed_reference"]), float(middle["highest_bit_speed"])), (8, -10))
    _name(axes, "$p_2$", (float(middle["speed_reference"]), float(middle["lowest_bit_speed"])), (8, 5))
    axes.text(0.5 * (hopf + fold), 1.07 * top, "bistable", ha="center", style="italic")
    axes.set_xlim(-0.05 * fastest, fastest)
    axes.set_ylim(-0.04 * top, 1.18 * top)
    axes.set_xlabel(SPEED_REFERENCE)
    axes.set_ylabel(BIT_SPEED)
    name_line_styles(axes, "upper left")


def _peak(diagram: Diagram, speed: float) -> float:
    points = diagram.p1.points
    return float(np.interp(speed, points["speed_reference"], points["highest_bit_speed"]))


def _name(axes: Axes, text: str, at: tuple[float, float], offset: tuple[float, float]) -> None:
    axes.annotate(text, at, offset, textcoords="offset points", fontsize=10)


def _draw_orbit(axes: Axes, orbit: PeriodicOrbit, number: int) -> None:
    _, states = orbit.trajectory(1000)
    axes.plot(states[:, _TWIST], states[:, _BIT], color=BLUE, lw=1.4)
    balance = steady_state(orbit.rig, orbit.friction, orbit.speed_reference)
    axes.plot(balance[_TWIST], balance[_BIT], "+", color=DARK, ms=7.0)
    axes.set_title(rf"{number}: $\omega_{{ref}}$ = {orbit.speed_reference:g} rad/s")
    axes.set_xlabel(TWIST)


def _described(diagram: Diagram) -> str:
    still = float(minimum_speed(diagram.rig, diagram.friction))
    hopf, fold = diagram.hopf[-1], diagram.special["fold"]
    return (
        f"Bifurcation diagram in ω_ref, N_1 = {diagram.friction.normal_force:.4g} N and T_r2 = {diagram.rig.T_r2:g} "
        "N m: equilibria e1, e2, and highest and lowest bit speed of the periodic branches p1, p2; stable solid, "
        f"unstable dashed. H2, {hopf.criticality}, is at {hopf.speed_reference:.3f} rad/s and the fold, where p1 and "
        f"p2 meet, at {fold:.3f} rad/s; between them (grey) steady rotation and stick-slip are both stable. H1 lies at "
        f"ω_s = {diagram.special['H1']:g} rad/s: the chapter's ω_min ({still:.3f} rad/s) belongs to a drive without "
        "integrator."
    )


def bistable_region(rig: Rig) -> Picture:
    """Beyond the chapter: where stick-slip and steady rotation are both stable, over (omega_ref, N_1)."""
    scales = Scales.of(rig)
    heaviest, decay = 40.0 * scales.force, f"{scales.friction.v_b:.4g}"
    curves = hopf_and_fold_curves(rig, pressed(rig, 10.0), np.linspace(0.0, heaviest, 1601)[1:])
    exists = np.isfinite(curves["end_of_stick_slip"])
    border, fold, forces = (curves[name][exists] for name in ("critical_speed", "end_of_stick_slip", "normal_force"))
    reach = scale(rig, 33.0)
    figure = new_figure(3.9)
    axes = figure.subplots()
    axes.fill_betweenx(forces, 0.0, border, color=VERMILLION, alpha=0.14, lw=0.0)
    axes.fill_betweenx(forces, border, fold, facecolor=GREEN, alpha=0.14, hatch="//", edgecolor="0.6", lw=0.0)
    axes.plot(border, forces, color=DARK, lw=1.6, label=r"critical speed $\omega_c$ ($H_2$)")
    axes.plot(fold, forces, color=DARK, lw=1.6, ls="-.", label="fold: stick-slip ends")
    if rig == Rig():
        _mark_the_chapters_runs(axes)
    axes.text(0.4 * reach, 0.825 * heaviest, "stick-slip only", fontsize=9)
    axes.text(
        4.4 * reach,
        0.825 * heaviest,
        "bistable",
        fontsize=9,
        ha="center",
        bbox={"fc": "white", "ec": "none", "alpha": 0.8},
    )
    axes.text(5.6 * reach, 0.3 * heaviest, "steady rotation only", fontsize=9)
    axes.set_xlim(0.0, 8.0 * reach)
    axes.set_ylim(0.0, heaviest)
    axes.set_xlabel(SPEED_REFERENCE)
    axes.set_ylabel(r"normal force $N_1$, N")
    figure.legend(loc="outside upper center", ncols=2)
    return Picture(
        figure,
        "Beyond the chapter: the bistable region over speed reference and normal force, from the critical speed (the "
        "curve of figure 4.11) to the fold (the end of p1 in figures 4.12 and 4.13). Inside it, both stick-slip and "
        "steady rotation are stable, and the run decides: to free a sticking rig for certain, the speed must pass the "
        "fold."
        + only_for_the_chapters(rig, " Marked are the chapter's own runs, by figure.")
        + (
            only_for_the_chapters(rig, " μ_s, μ_k and v_b of table 4.1.")
            or f" μ_s, μ_k of table 4.1, v_b = {decay} s/rad."
        ),
    )


def _mark_the_chapters_runs(axes: Axes) -> None:
    """The runs of the chapter's figures, and whether they vibrate."""
    axes.plot([2.0, 3.0, 3.14], [20.0, 25.0, 25.0], "^", color=DARK, label="the chapter's run vibrates")
    axes.plot(4.0, 20.0, "s", color=DARK, mfc="white", label="the chapter's run does not")
    for x, y, text, offset in (
        (2.0, 20.0, "4.11", (-6, -3)),
        (3.0, 25.0, "4.7", (-6, -3)),
        (3.14, 25.0, "4.4", (6, -3)),
        (4.0, 20.0, "4.11", (6, -3)),
    ):
        axes.annotate(text, (x, y), offset, textcoords="offset points", ha="right" if offset[0] < 0 else "left")
