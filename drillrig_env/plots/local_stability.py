"""Figures 4.9 to 4.11: equilibria, the eigenvalues that cross the axis, and the torsional vibration map."""

from __future__ import annotations

from typing import Any

import numpy as np
import numpy.typing as npt
from matplotlib.axes import Axes

from drillrig_env.arrays import FloatArray
from drillrig_env.friction import Friction
from drillrig_env.model import STATE_NAMES, minimum_speed
from drillrig_env.plots.own_rig import only_for_the_chapters, pressed, rounded, scale
from drillrig_env.plots.style import (
    BIT_SPEED,
    BLUE,
    DARK,
    GREY,
    SPEED_REFERENCE,
    STABLE,
    TIME,
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
from drillrig_env.simulation import simulate
from drillrig_env.stability import (
    critical_speed,
    eigenvalues,
    end_of_stick_slip,
    equilibria,
    hopf_and_fold_curves,
    hopf_points,
)

_CUT = (2.625, 2.712)  # rad/s; the part of the imaginary axis that figure 4.10 shows
_DIGIT = 0.012  # share of the axis that figure 4.10 takes for a digit
_SHOWN = ((BIT_SPEED, "bit_speed"), (TWIST, "twist_12"), (r"current $i$, A", "current"))


def equilibrium_branches(rig: Rig) -> Picture:
    """Figure 4.9: bit speed, twist and current of steady rotation (4-16), and the still branch below omega_min."""
    fastest = 5.0 * scale(rig, 20.0)
    figure = new_figure(5.0)
    panels = figure.subplots(3, 2, sharex=True, sharey="row")
    told = []
    for column, (letter, force) in enumerate(zip("ab", (10.0, 20.0), strict=True)):
        friction = pressed(rig, force)
        still, border = float(minimum_speed(rig, friction)), float(critical_speed(rig, friction))
        points = equilibria(rig, friction, np.sort(np.append(np.linspace(still, fastest, 300), border)))
        speed = points["speed_reference"]
        for axes, (label, name) in zip(panels[:, column], _SHOWN, strict=True):
            value = points["state"][:, STATE_NAMES.index(name)]
            plot_stability(axes, speed, value, speed >= border)
            axes.axvline(still, color=GREY, ls=":", lw=0.9)
            text = rf"$\omega_c$ = {border:.3f} rad/s" if name == "bit_speed" else r"$\omega_c$"
            at_border = float(np.interp(border, speed, value))
            mark(axes, border, at_border, text, (6, 6) if name == "current" else (6, -11))
            if column == 0:
                axes.set_ylabel(label)
        panels[0, column].plot([0.0, still], [0.0, 0.0], **{**STABLE, "lw": 3.0}, solid_capstyle="butt")
        panels[0, column].annotate(
            rf"$\omega_{{min}}$ = {still:.3f} rad/s",
            (still, 0.92 * fastest),
            (4, 0),
            textcoords="offset points",
        )
        panels[0, column].set_title(f"({letter}) $N_1$ = {friction.normal_force:.4g} N")
        panels[2, column].set_xlabel(SPEED_REFERENCE)
        told.append(f"{still:.4f} rad/s at {friction.normal_force:.4g} N")
    panels[0, 0].set_xlim(0.0, fastest)
    name_line_styles(panels[1, 0], "lower right")
    return Picture(
        figure,
        "Equilibrium branch (4-16) over the speed reference: speed of all discs, twist between disc 1 and disc 2 and "
        f"armature current. Below ω_min of (4-15), {' and '.join(told)}, a rig without integrator stands still (thick "
        "line). With it, the 7-state model winds up and always breaks away, and steady rotation goes on below ω_min.",
    )


def eigenvalue_crossing(rig: Rig) -> Picture:
    """Figure 4.10: the conjugate pair of the Jacobian (4-19) that crosses the imaginary axis at omega_c."""
    friction = pressed(rig, 10.0)
    hopf = hopf_points(rig, friction)[-1]
    border = hopf.speed_reference
    reach = scale(rig, 10.0)
    marks = [rounded(reach * value) for value in (0.5, 0.75, 1.0, 1.25)]
    marks += [border, *(rounded(reach * value) for value in (2.5, 3.0, 4.0, 5.0))]
    speed = np.sort(np.append(np.linspace(0.45 * reach, 5.0 * reach, 300), border))
    pair = np.array([_string_mode(rig, friction, float(value), hopf.frequency) for value in speed])
    figure = new_figure(3.9)
    panels = figure.subplots(2, 1, sharex=True)
    for axes, sign in zip(panels, (1.0, -1.0), strict=True):
        plot_stability(axes, pair.real, sign * pair.imag, speed >= border)
        axes.axvline(0.0, color=DARK, lw=0.9)
        last = np.inf
        for value in marks:
            at = _string_mode(rig, friction, value, hopf.frequency)
            text = rf"$\omega_c$ = {value:.3f}" if value == border else f"{value:g}"
            if abs(at.real - last) < _DIGIT * len(text) * np.ptp(pair.real) and value != border:
                text = ""  # it would be written over the one before
            last = at.real
            offset, side = ((5.0, 6.0 * sign), "left") if value == border else ((0.0, 6.0 * sign), "center")
            mark(axes, at.real, sign * at.imag, text, offset, ha=side, va="bottom" if sign > 0 else "top")
        axes.set_ylabel(r"Im $\lambda$, rad/s")
        low, high = sorted(sign * value for value in (_CUT if rig == Rig() else _around(pair.imag)))
        axes.set_ylim(low, high)
    panels[1].set_xlabel(r"Re $\lambda$, 1/s")
    name_line_styles(panels[0], "lower left")
    return Picture(
        figure,
        f"The conjugate pair of eigenvalues of the Jacobian (4-19) that crosses the imaginary axis, N_1 = "
        f"{friction.normal_force:.4g} N; numbers are ω* in rad/s. At ω_c = {border:.4f} rad/s the pair is "
        f"±{hopf.frequency:.4f}i rad/s, and its real part falls by {-hopf.crossing_speed:.3f} 1/s per rad/s of ω*: "
        "not zero, as a Hopf bifurcation asks. The imaginary axis is cut between the two halves.",
    )


def _around(values: FloatArray) -> tuple[float, float]:
    """Limits with some room about values."""
    room = 0.2 * float(np.ptp(values)) + 1e-3 * float(np.abs(values).max())
    return float(values.min()) - room, float(values.max()) + room


def _string_mode(rig: Rig, friction: Friction, speed: float, frequency: float) -> complex:
    """The upper eigenvalue of the string's slow mode: the one whose imaginary part is nearest to `frequency`."""
    values = eigenvalues(rig, friction, speed)
    return complex(values[np.argmin(np.abs(values.imag - frequency))])


def torsional_vibration_map(rig: Rig) -> Picture:
    """Figure 4.11: the critical speed over (omega_ref, N_1), and a time response from either side of it."""
    reach, scales, friction = scale(rig, 20.0), Scales.of(rig), pressed(rig, 20.0)
    force, on = 20.0 * scales.force, 50.0 * scales.time
    below, above = rounded(2.0 * reach), rounded(4.0 * reach)
    figure = new_figure(3.3)
    panels: dict[str, Any] = figure.subplot_mosaic([["map", "upper"], ["map", "lower"]], width_ratios=(1.0, 1.15))
    heaviest = 40.0 * scales.force
    curves = hopf_and_fold_curves(rig, friction, np.linspace(0.0, heaviest, 1601)[1:])
    vibrates = curves["critical_speed"] > 0.0
    border, forces = curves["critical_speed"][vibrates], curves["normal_force"][vibrates]
    _draw_zones(panels["map"], border, forces, reach, heaviest)
    for axes, speed, marker in ((panels["upper"], below, "^"), (panels["lower"], above, "s")):
        run = simulate(
            rig,
            friction,
            speed_reference=speed,
            normal_force=[(0.0, 0.0), (on, force)],
            duration=100.0 * scales.time,
            sample_period=0.01 * scales.time,
        )
        axes.plot(run.time, run.bit_speed, color=BLUE, lw=0.9)
        axes.axvline(on, color=DARK, ls="--", lw=0.9)
        axes.set_ylabel(r"$\dot{\theta}_1$, rad/s")
        axes.set_xlim(0.0, run.time[-1])
        axes.set_ylim(-0.05 * run.bit_speed.max(), 1.08 * run.bit_speed.max())
        axes.set_title(rf"$\omega_{{ref}}$ = {speed:g} rad/s")
        axes.plot(0.97, 1.07, marker, color=DARK, transform=axes.transAxes, clip_on=False)
        panels["map"].plot(speed, force, marker, color=DARK, clip_on=False)
    panels["lower"].set_xlabel(TIME)
    panels["upper"].set_title(rf"(b) $\omega_{{ref}}$ = {below:g} rad/s")
    end = float(end_of_stick_slip(rig, friction).speed)
    return Picture(
        figure,
        "(a) Torsional vibration map by the Hurwitz criterion: left of the curve of critical speeds the rig vibrates, "
        f"right of it steady rotation is stable. (b) Speed of disc 1 at the two points marked in (a), from rest, "
        f"N_1 = 0 N until {on:.4g} s and {force:.4g} N from then on"
        + only_for_the_chapters(
            rig,
            ": it vibrates at 2 rad/s and does not at 4 rad/s, where a larger disturbance could still bring stick-slip",
        )
        + f"; the fold, above which there is no stick-slip, is at {end:.3f} rad/s: see the picture of the bistable "
        "region.",
    )


def _draw_zones(axes: Axes, border: FloatArray, forces: npt.NDArray[np.float64], reach: float, heaviest: float) -> None:
    axes.fill_betweenx(forces, 0.0, border, color=VERMILLION, alpha=0.14, lw=0.0)
    axes.plot(border, forces, color=DARK, lw=1.6)
    axes.text(0.27 * reach, 0.775 * heaviest, "torsional\nvibrations", ha="left")
    axes.text(3.2 * reach, 0.2 * heaviest, "no vibration:\nstable\nequilibria", ha="left")
    axes.set_xlim(0.0, 5.0 * reach)
    axes.set_ylim(0.0, heaviest)
    axes.set_xlabel(SPEED_REFERENCE)
    axes.set_ylabel(r"normal force $N_1$, N")
    axes.set_title("(a) map")
