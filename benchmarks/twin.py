"""The records of the tutorial: a laboratory rig that is not the chapter's, as its logger would write them.

    python -m benchmarks.twin                  # writes docs/twin: three logger files, truth.toml and guess.toml
    python -m benchmarks.twin --beside my_rig  # how a calibration compares with the rig behind them; writes nothing

The rig and its friction are made up: discs, shafts and motor are 8 to 43 % off the chapter's, its inductance is seven
times as large, and its friction falls deeper and more slowly. Its logger samples at 50 Hz and writes semicolons and
decimal commas, speeds in rpm in steps of 0.1, a current in steps of 0.01 A and a voltage in steps of 0.05 V, each with
noise; four bad samples of the bit speed in every file, and half a second that is lost. guess.toml is what one would
work with who calibrates nothing: the chapter's rig with the gains that are set at the drive.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace
from math import pi
from pathlib import Path
from typing import Any

import numpy as np

from drillrig_env import Friction, Rig, simulate
from drillrig_env.calibrate.posterior import Posterior
from drillrig_env.calibrate.unknowns import values_of
from drillrig_env.command_line import Parser, command
from drillrig_env.files import check_writable, write_text
from drillrig_env.markdown import table
from drillrig_env.stability import critical_speed
from drillrig_env.toml import section_text

FOLDER = Path(__file__).parents[1] / "docs" / "twin"
"""Where the project ships them."""

RIG = replace(
    Rig(),
    J_1=0.041,
    J_2=0.0105,
    J_3=0.034,
    k_1=1.55,
    k_2=0.47,
    d_1=0.013,
    d_2=0.021,
    L=0.0062,
    R=0.41,
    K_T=0.144,
    K_E=0.0735,
    C_m=0.00024,
    T_f=0.165,
    k_p=2.2,
    k_i=1.4,
)
FRICTION = Friction(24.0, 0.43, 0.23, 0.7)
"""The rig of the twin, and its friction at the load of the records."""

SEED = 27
PERIOD, LOST, GLITCHES = 0.02, 0.5, 4  # s; s of each file that are missing; bad samples of a file
_RPM = 30.0 / pi

_COLUMNS: dict[str, tuple[str, float, float, float]] = {
    "bit_speed": ("Bit speed [rpm]", _RPM, 0.2, 0.1),
    "top_speed": ("Top speed [rpm]", _RPM, 0.2, 0.1),
    "current": ("Motor current [A]", 1.0, 0.02, 0.01),
    "voltage": ("Motor voltage [V]", 1.0, 0.05, 0.05),
    "speed_reference": ("Speed reference [rpm]", _RPM, 0.0, 0.01),
    "normal_force": ("WOB [N]", 1.0, 0.0, 0.1),
}
"""Of each signal: the column's name, its unit in SI units, and noise and step in that unit."""

_RUNS: dict[str, tuple[Any, float, float]] = {
    "steps": ([(0.0, 2.0), (10.0, 4.0), (20.0, 3.0), (30.0, 6.0)], 0.0, 40.0),
    "sweep": ([(0.5 * k, 7.0 - 4.6 * k / 120.0) for k in range(120)], 24.0, 60.0),
    "stick_slip": ([(0.0, 2.0)], 24.0, 30.0),
}
"""Of each file: speed reference (rad/s) over time (s), normal force (N), length (s)."""


def files() -> dict[str, str]:
    """The text of every file, by its name."""
    found = {f"{name}.csv": _logged(name, number) for number, name in enumerate(_RUNS)}
    head = "# The rig behind the records of this folder, and its friction: what nobody who has a real rig has.\n\n"
    truth = head + section_text(RIG, "rig") + "\n" + section_text(FRICTION, "friction")
    guess = f'[rig]\nbase = "chapter"\nk_p = {RIG.k_p}\nk_i = {RIG.k_i}\n'
    head = "# The chapter's rig with the gains that are set at this drive.\n\n"
    return {**found, "truth.toml": truth, "guess.toml": head + guess}


def beside_truth(posterior: Posterior) -> str:
    """A table of the parameters that a calibration looked for, and the critical speed, beside those of the rig."""
    truth, rows = values_of(RIG, FRICTION), []
    for name, (value, low, high) in posterior.intervals.items():
        held = "yes" if low <= truth[name] <= high else "no"
        rows.append([name, f"{truth[name]:.4g}", f"{value:.4g}", f"{low:.4g} to {high:.4g}", held])
    pressed = FRICTION.normal_force
    speeds = [
        float(critical_speed(rig, replace(friction, normal_force=pressed)))
        for rig, friction in ((RIG, FRICTION), (posterior.rig, posterior.friction))
    ]
    said = f"critical speed at {pressed:g} N: {speeds[0]:.3f} rad/s, by the calibration {speeds[1]:.3f}"
    return f"{table(['parameter', 'true', 'found', '90 % interval', 'holds it'], rows, 1)}\n{said}"


def _logged(name: str, number: int) -> str:
    """A run as the logger writes it."""
    reference, force, length = _RUNS[name]
    run = simulate(RIG, FRICTION, None, reference, length, PERIOD, normal_force=force)
    random = np.random.default_rng([SEED, number])
    columns = []
    for signal, (_, unit, noise, step) in _COLUMNS.items():
        values = unit * getattr(run, signal) + noise * random.standard_normal(len(run.time))
        if signal == "bit_speed":
            bad = random.choice(len(values), GLITCHES, replace=False)
            values[bad] += random.choice([-1.0, 1.0], GLITCHES) * random.uniform(80.0, 200.0, GLITCHES)
        columns.append(step * np.rint(values / step))
    begin = random.uniform(0.2, 0.8) * length
    kept = np.flatnonzero((run.time < begin) | (run.time >= begin + LOST))
    decimals = [2 if step < 0.1 else 1 for *_, step in _COLUMNS.values()]
    lines = [";".join(["Time [s]", *(heading for heading, *_ in _COLUMNS.values())])]
    for k in kept:
        cells = [f"{run.time[k]:.2f}", *(f"{c[k]:.{d}f}" for c, d in zip(columns, decimals, strict=True))]
        lines.append(";".join(cells).replace("-0.0;", "0.0;").replace(".", ","))
    return "\n".join(lines) + "\n"


@command
def main(arguments: Sequence[str] | None = None) -> int:
    """Write the folder."""
    parser = Parser(prog="python -m benchmarks.twin", description=__doc__)
    parser.add_argument("--output", type=Path, default=FOLDER, metavar="DIR", help="default: docs/twin")
    parser.add_argument("--beside", type=Path, metavar="DIR", help="the folder of a calibration to compare")
    chosen = parser.parse_args(arguments)
    if chosen.beside is not None:
        try:
            print(beside_truth(Posterior.from_folder(chosen.beside)))
        except (ValueError, FileNotFoundError) as error:
            parser.error(error)
        return 0
    check_writable(chosen.output)
    for name, text in files().items():
        write_text(chosen.output / name, text)
        print(chosen.output / name)
    return 0


if __name__ == "__main__":
    raise SystemExit(main())
