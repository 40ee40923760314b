"""Figures 4.2 to 4.7: the numerical curves of the time responses that the chapter sets beside its experiments."""

from __future__ import annotations

from math import pi

import numpy as np

from drillrig_env.model import frictionless_state
from drillrig_env.plots.own_rig import only_for_the_chapters, pressed
from drillrig_env.plots.style import (
    BIT_SPEED,
    BLUE,
    DARK,
    GREEN,
    GREY,
    PURPLE,
    TIME,
    VERMILLION,
    Picture,
    new_figure,
)
from drillrig_env.rig import Rig
from drillrig_env.scales import Scales
from drillrig_env.simulation import simulate

_COLLAR_SPEED = r"$\dot{\theta}_2$, rad/s"
_CORRELATED = 10.0  # s; P_C (4-10) is taken over the first 10 s
_RPM = 2.0 * pi / 60.0  # rad/s
_PERIOD = 0.005  # s between samples: a curve without corners


def start_from_rest(speed_reference: float, rig: Rig) -> Picture:
    """Figures 4.2 and 4.3: both discs after a start from rest, the pin lifted."""
    force, scales = 0.0, Scales.of(rig)
    time, correlated = scales.time, _CORRELATED * scales.time
    speed_reference *= scales.speed
    run = simulate(
        rig,
        pressed(rig, force),
        speed_reference=speed_reference,
        duration=30.0 * time,
        sample_period=_PERIOD * time,
    )
    figure = new_figure(3.6)
    panels = figure.subplots(2, 1, sharex=True, sharey=True)
    for axes, signal, title in zip(
        panels, (run.bit_speed, run.collar_speed), ("(a) disc 1", "(b) disc 2"), strict=True
    ):
        axes.axvspan(0.0, correlated, color="0.93", lw=0.0)
        axes.axhline(speed_reference, color=GREY, ls=":", lw=1.0)
        axes.plot(run.time, signal, color=DARK, ls="--")
        axes.set_title(title)
    panels[0].set_ylabel(r"$\dot{\theta}_1$, rad/s")
    panels[1].set_ylabel(_COLLAR_SPEED)
    panels[1].set_xlabel(TIME)
    panels[1].set_xlim(0.0, run.time[-1])
    panels[0].set_ylim(bottom=0.0)
    return Picture(
        figure,
        f"Speeds of (a) disc 1 and (b) disc 2 after a start from rest at ω_ref = {speed_reference:.4g} rad/s "
        f"({speed_reference / _RPM:.0f} rpm, dotted line): the numerical curves, dashed as in the chapter. It "
        f"prints no normal force here; N_1 = {force:g} N is chosen, since stick-slip has its own figure 4.4. "
        f"Grey: the first {correlated:.3g} s, over which P_C of table 4.2 is taken.",
    )


def stick_slip(rig: Rig) -> Picture:
    """Figure 4.4: stick-slip, whole and zoomed."""
    scales = Scales.of(rig)
    speed_reference, force, time = 3.14 * scales.speed, 25.0 * scales.force, scales.time
    zoom = (40.0 * time, 48.0 * time)
    run = simulate(
        rig,
        pressed(rig, 25.0),
        speed_reference=speed_reference,
        duration=60.0 * time,
        sample_period=_PERIOD * time,
    )
    stuck = np.abs(run.bit_speed) < run.rig.omega_s
    figure = new_figure(3.9)
    whole, zoomed = figure.subplots(2, 1)
    whole.axvspan(*zoom, color="0.9", lw=0.0)
    for axes in (whole, zoomed):
        axes.axhline(speed_reference, color=GREY, ls=":", lw=1.0)
        axes.plot(run.time, run.bit_speed, color=DARK, ls="--", lw=1.0)
        axes.set_ylabel(r"$\dot{\theta}_1$, rad/s")
    zoomed.plot(run.time, np.where(stuck, run.bit_speed, np.nan), color=VERMILLION, lw=3.0, label="stuck")
    zoomed.legend(loc="lower right", bbox_to_anchor=(1.0, 1.0), borderaxespad=0.0)
    whole.set_xlim(0.0, run.time[-1])
    zoomed.set_xlim(*zoom)
    whole.set_title("(a) stick-slip")
    zoomed.set_title("(b) zoomed")
    zoomed.set_xlabel(TIME)
    return Picture(
        figure,
        f"Speed of disc 1 with stick-slip at ω_ref = {speed_reference:.4g} rad/s ({speed_reference / _RPM:.0f} rpm, "
        f"dotted line), N_1 = {force:.4g} N and T_r2 = {run.rig.T_r2:g} N m, from rest with the pin on the disc: the "
        f"numerical curve, (a) whole and (b) zoomed into the grey band.",
    )


def motor_oscillations(rig: Rig) -> Picture:
    """Figure 4.5: free oscillations of the motor's speed after a step of the reference."""
    scales = Scales.of(rig)
    time = scales.time
    figure = new_figure(3.9)
    whole, zoomed = figure.subplots(2, 1)
    styles = zip((30, 40, 50, 70), (BLUE, VERMILLION, GREEN, PURPLE), ("-", "--", "-.", ":"), strict=True)
    for rpm, color, style in styles:
        speed = rpm * _RPM * scales.speed
        run = simulate(
            rig, pressed(rig, 0.0), speed_reference=speed, duration=20.0 * time, sample_period=_PERIOD * time
        )
        turns = rpm * scales.speed
        label = f"{turns:.0f}" if turns >= 10.0 else f"{turns:.2g}"
        label += f" rpm ({speed:.3g} rad/s)"
        whole.plot(run.time, run.top_speed, color=color, ls=style, lw=1.3, label=label)
        late = run.time >= 5.0 * time
        zoomed.plot(run.time[late], (run.top_speed - run.speed_reference)[late], color=color, ls=style, lw=1.3)
    whole.set_ylabel(r"motor speed $\dot{\theta}_3$, rad/s")
    zoomed.set_ylabel(r"$\dot{\theta}_3 - \omega_{ref}$, rad/s")
    zoomed.set_xlabel(TIME)
    zoomed.set_xlim(5.0 * time, 20.0 * time)
    whole.set_xlim(0.0, 20.0 * time)
    whole.set_ylim(0.0, 8.0 if rig == Rig() else None)
    whole.set_title("(a) speed of the motor, behind the gear")
    zoomed.set_title("(b) its distance from the reference, enlarged")
    figure.legend(loc="outside upper center", ncols=4, columnspacing=1.2, handlelength=2.6)
    return Picture(
        figure,
        "Free transient oscillations of the motor's speed after a step of the reference from 0 to the four references "
        "of table 4.2, from rest, N_1 = 0 N: the numerical curves."
        + only_for_the_chapters(
            rig,
            " The drive itself settles within 0.1 s; what is left is the string's oscillation, on the integrator's "
            "slow approach. The chapter notes that the model misses the measured amplitude and nearly has its "
            "frequency.",
        ),
    )


def load_put_on_and_removed(rig: Rig) -> Picture:
    """Figure 4.6: the numerical counterpart of the experiment, stick-slip while the pin presses."""
    scales = Scales.of(rig)
    time, speed_reference, force = scales.time, 3.0 * scales.speed, 25.0 * scales.force
    on, off = 8.0 * time, 46.0 * time
    run = simulate(
        rig,
        scales.friction,
        speed_reference=speed_reference,
        normal_force=[(0.0, 0.0), (on, force), (off, 0.0)],
        duration=70.0 * time,
        sample_period=_PERIOD * time,
    )
    figure = new_figure(4.6)
    panels = figure.subplots(3, 1, sharex=True)
    signals = (run.bit_speed, run.collar_speed, run.top_speed)
    names = (r"$\dot{\theta}_1$, rad/s", _COLLAR_SPEED, r"$\dot{\theta}_3$, rad/s")
    for axes, signal, name, title in zip(
        panels, signals, names, ("disc 1", "disc 2", "motor (enlarged; the first seconds lie below)"), strict=True
    ):
        axes.axvspan(on, off, color="0.92", lw=0.0)
        axes.axhline(speed_reference, color=GREY, ls=":", lw=1.0)
        axes.plot(run.time, signal, color=BLUE)
        axes.set_ylabel(name)
        axes.set_title(title)
    late = run.top_speed[run.time > 5.0 * time]
    panels[2].set_ylim(
        *((2.88, 3.08) if rig == Rig() else (late.min() - 0.01 * scales.speed, late.max() + 0.01 * scales.speed))
    )
    panels[2].set_xlim(0.0, run.time[-1])
    panels[2].set_xlabel(TIME)
    sticking = (run.time > 20.0 * time) & (run.time < off)
    return Picture(
        figure,
        f"Numerical counterpart of the experiment: speeds of disc 1, disc 2 and motor at ω_ref = {speed_reference:.4g} "
        f"rad/s (dotted), from rest; N_1 = {force:.4g} N (chosen; not printed) from {on:.4g} s to {off:.4g} s (grey), "
        f"else 0 N. The mean of the motor's speed from {20.0 * time:.4g} s to {off:.4g} s is "
        f"{run.top_speed[sticking].mean():.3f} rad/s: the integrator holds it at the reference."
        + only_for_the_chapters(
            rig, " The experiment's lies slightly below, which, as the chapter says, the model does not show."
        ),
    )


def speed_and_current(rig: Rig) -> Picture:
    """Figure 4.7: bit speed and armature current when the normal force comes on."""
    scales = Scales.of(rig)
    time, speed_reference, force = scales.time, 3.0 * scales.speed, 25.0 * scales.force
    on = 50.0 * time
    run = simulate(
        rig,
        scales.friction,
        initial_state=frictionless_state(rig, speed_reference),
        speed_reference=speed_reference,
        normal_force=[(0.0, 0.0), (on, force)],
        duration=100.0 * time,
        sample_period=_PERIOD * time,
    )
    figure = new_figure(3.6)
    panels = figure.subplots(2, 1, sharex=True)
    panels[0].plot(run.time, run.bit_speed, color=BLUE)
    panels[0].axhline(speed_reference, color=GREY, ls=":", lw=1.0)
    panels[0].set_ylabel(BIT_SPEED)
    panels[1].plot(run.time, run.current, color=VERMILLION)
    panels[1].set_ylabel(r"armature current $i$, A")
    panels[1].set_xlabel(TIME)
    panels[1].set_xlim(0.0, run.time[-1])
    for axes in panels:
        axes.axvline(on, color=DARK, ls="--", lw=0.9)
    for x, text in ((0.5 * on, "$N_1$ = 0 N"), (on + 0.5 * (run.time[-1] - on), f"$N_1$ = {force:.4g} N")):
        panels[0].annotate(text, (x, 1.02), xycoords=("data", "axes fraction"), ha="center", va="bottom", fontsize=9)
    return Picture(
        figure,
        f"Speed of disc 1 and armature current at ω_ref = {speed_reference:.4g} rad/s (dotted); N_1 = 0 N until "
        f"{on:.4g} s and {force:.4g} N from then on. The run begins in steady rotation (chosen), which keeps the "
        "current's peak of a start from rest out of the picture."
        + only_for_the_chapters(rig, " The load step sets off stick-slip, and the current swings with it."),
    )
