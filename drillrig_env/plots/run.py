"""A simulated run as a picture: the speeds of bit and drive, and the torques at both ends of the string."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path

import numpy as np

from drillrig_env.plots.style import (
    BLUE,
    DARK,
    GREY,
    TIME,
    VERMILLION,
    Picture,
    add_caption,
    look,
    new_figure,
    save,
)
from drillrig_env.simulation import Simulation
from drillrig_env.stability import critical_speed


def draw_run(run: Simulation) -> Picture:
    """The picture of a run, with a caption that names its inputs."""
    with look():
        figure = new_figure(3.9)
        speeds, torques = figure.subplots(2, 1, sharex=True, height_ratios=(1.5, 1.0))
        speeds.plot(run.time, run.bit_speed, color=BLUE, label="bit")
        speeds.plot(run.time, run.top_speed, color=VERMILLION, ls="--", label="top drive")
        speeds.step(run.time, run.speed_reference, where="post", color=GREY, ls=":", label="reference")
        speeds.set_ylabel("speed, rad/s")
        torques.plot(run.time, run.torque_into_string, color=VERMILLION, ls="--", label="into the string")
        torques.plot(run.time, run.friction_torque, color=DARK, lw=0.8, label="friction on the bit")
        torques.set_ylabel("torque, N m")
        torques.set_xlabel(TIME)
        torques.set_xlim(run.time[0], run.time[-1])
        for axes in (speeds, torques):
            axes.legend(loc="lower right", bbox_to_anchor=(1.0, 1.0), borderaxespad=0.0, ncols=3)
        picture = Picture(figure, _caption(run))
        add_caption(picture)
    return picture


def save_run(run: Simulation, path: Path) -> None:
    """Draw a run into a file; its ending, such as .png, .svg or .pdf, says in which format."""
    picture = draw_run(run)
    with look():
        save(picture, path.parent, path.stem, [path.suffix[1:]])


def _caption(run: Simulation) -> str:
    pressed = replace(run.friction, normal_force=float(run.normal_force[-1]))
    try:
        border = f"critical speed ω_c = {float(critical_speed(run.rig, pressed)):.3f} rad/s"
    except ValueError:  # a drive that shakes by itself, but in windows of speed
        border = "no one critical speed"
    return (
        f"A run with ω_ref = {_span(run.speed_reference)} rad/s and N_1 = {_span(run.normal_force)} N, mu_s = "
        f"{run.friction.mu_s:g}, mu_k = {run.friction.mu_k:g}; {border} at N_1 = "
        f"{pressed.normal_force:.4g} N."
    )


def _span(values: np.ndarray) -> str:
    low, high = float(values.min()), float(values.max())
    return f"{low:.4g}" if low == high else f"{low:.4g} to {high:.4g}"
