"""A field string as three lumps against one of many: how far period and peak of its stick-slip are off.

    python -m benchmarks.string_lumps
    python -m benchmarks.string_lumps --viscosity 0.03

The string is that of `Rig.preset("field_2500m")`: 2,300 m of drill pipe, 200 m of collars, a top drive with a stiff
speed loop. Three lumps are `Rig.from_string`, as the simulator runs it; many are a chain of equal pieces of pipe and of
collars, each with half of its inertia at either end, and half of what the mud in a hole of 215.9 mm takes from it,
integrated by SciPy's Radau (rtol 1e-6) with the same friction at the lowest one. Peak is the highest bit speed, period
the mean time from one breaking loose to the next, both over the second half of the run.
"""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
from scipy.integrate import solve_ivp

from benchmarks.measure import print_table
from drillrig_env import Friction, Rig, simulate
from drillrig_env.allowed import NOT_NEGATIVE, POSITIVE, Allowed
from drillrig_env.arrays import FloatArray
from drillrig_env.command_line import Parser, command
from drillrig_env.flags import of_kind
from drillrig_env.lumps import LOSS_TIME, STEEL, Mud, Tube
from drillrig_env.model import jacobian

PIPE, COLLARS, TOP = Tube(2300.0, 0.127, 0.1086), Tube(200.0, 0.1715, 0.0714), 2900.0  # m and kg m^2
FRICTION = Friction(18000.0, 0.5, 0.3, 0.2)  # 9,000 to 5,400 N m at r_1 = 1 m
HOLE = 0.2159  # m, 8 1/2 inches
DURATION, SAMPLE = 60.0, 0.005  # s
_SHARE_OF_COLLARS = 0.08
_LOOSE = 0.5  # rad/s, above which the bit has broken loose


class Chain:
    """A string of `lumps` discs in mud of a viscosity (Pa s): the lowest is the bit, the highest the top drive."""

    def __init__(self, lumps: int, friction: Friction, viscosity: float = 0.0) -> None:
        mud = Mud(viscosity, HOLE)
        self.rig = Rig.from_string(PIPE, COLLARS, TOP, k_p=38e3, k_i=100e3, mud=mud)
        self.friction, self.lumps = friction, lumps
        collars = max(1, round(_SHARE_OF_COLLARS * (lumps - 1)))
        tubes = [COLLARS] * collars + [PIPE] * (lumps - 1 - collars)
        counts = [collars] * collars + [lumps - 1 - collars] * (lumps - 1 - collars)
        inertias = np.array([tube.inertia(STEEL["density"]) / n for tube, n in zip(tubes, counts, strict=True)])
        self.k = np.array([tube.stiffness(STEEL["shear_modulus"]) * n for tube, n in zip(tubes, counts, strict=True)])
        drags = np.array([mud.drag(tube) / n for tube, n in zip(tubes, counts, strict=True)])
        self.J, self.C = _at_the_ends(inertias), _at_the_ends(drags)
        self.J[-1] += TOP

    @property
    def matrix(self) -> FloatArray:
        """The linear part, of twists, speeds, current and integral of the speed error."""
        n, rig = self.lumps, self.rig
        A = np.zeros((2 * n + 1, 2 * n + 1))
        for i in range(n - 1):
            A[i, n - 1 + i], A[i, n + i] = 1.0, -1.0
            torque = np.zeros(2 * n + 1)
            torque[i] = self.k[i]
            torque[n - 1 + i], torque[n + i] = self.k[i] * LOSS_TIME, -self.k[i] * LOSS_TIME
            A[n - 1 + i] -= torque / self.J[i]
            A[n + i] += torque / self.J[i + 1]
            A[n - 1 + i, n - 1 + i] -= self.C[i] / self.J[i]
        top, current, integral = 2 * n - 2, 2 * n - 1, 2 * n
        A[top, top] -= self.C[-1] / self.J[-1]
        A[top, current] += rig.K_T / self.J[-1]
        A[current, current], A[current, top], A[current, integral] = -rig.R / rig.L, -rig.k_p / rig.L, rig.k_i / rig.L
        A[integral, top] = -1.0
        return A

    def bit_speed(self, speed_reference: float, times: FloatArray) -> FloatArray:
        """Bit speed (rad/s) at some times (s) from rest, at a speed reference (rad/s)."""
        n, rig, A = self.lumps, self.rig, self.matrix
        constant = np.zeros(2 * n + 1)
        constant[2 * n - 1], constant[2 * n] = rig.k_p * speed_reference / rig.L, speed_reference

        def rates(_: float, x: FloatArray) -> FloatArray:
            found = A @ x + constant
            found[n - 1] -= self.friction.torque(rig, x[n - 1]) / self.J[0]
            return np.asarray(found)

        def derivative(_: float, x: FloatArray) -> FloatArray:
            found = A.copy()
            found[n - 1, n - 1] -= self.friction.slope(rig, x[n - 1]) / self.J[0]
            return found

        span = (0.0, float(times[-1]))
        run = solve_ivp(
            rates, span, np.zeros(2 * n + 1), "Radau", times, jac=derivative, rtol=1e-6, atol=1e-6, max_step=0.05
        )
        if not run.success:
            raise RuntimeError(f"{n} lumps: {run.message}")
        return np.asarray(run.y[n - 1])


def _at_the_ends(pieces: FloatArray) -> FloatArray:
    """What pieces in a row bring to the points between them and at either end: half of each."""
    return np.asarray((np.append(pieces, 0.0) + np.append(0.0, pieces)) / 2.0)


def period_and_peak(times: FloatArray, speed: FloatArray) -> tuple[float, float]:
    """Period (s) and highest bit speed (rad/s) over the second half of a run. `ValueError` where it does not stick."""
    late = times >= times[-1] / 2.0
    times, speed = times[late], speed[late]
    loose = times[1:][(speed[:-1] < _LOOSE) & (speed[1:] >= _LOOSE)]
    if len(loose) < 2:
        raise ValueError("the string does not stick and slip at this speed; allowed: a slower one")
    return float(np.diff(loose).mean()), float(speed.max())


@command
def main(arguments: Sequence[str] | None = None) -> None:
    """Run both and print how far they are apart."""
    parser = Parser(prog="python -m benchmarks.string_lumps", description=__doc__)
    add = parser.add_argument
    add("--lumps", type=of_kind(Allowed(4, 400, whole=True)), default=80, help="of the fine string (default: 80)")
    add("--speed-reference", type=of_kind(POSITIVE, "rad/s"), default=8.0, help="rad/s (default: 8)")
    add("--viscosity", type=of_kind(NOT_NEGATIVE, "Pa s"), default=0.0, help="of the mud, Pa s (default: no mud)")
    chosen = parser.parse_args(arguments)
    times = np.arange(0.0, DURATION + SAMPLE / 2.0, SAMPLE)
    try:
        chain = Chain(chosen.lumps, FRICTION, chosen.viscosity)
        run = simulate(chain.rig, FRICTION, np.zeros(7), chosen.speed_reference, DURATION, SAMPLE)
        coarse = period_and_peak(run.time, run.bit_speed)
        fine = period_and_peak(times, chain.bit_speed(chosen.speed_reference, times))
    except ValueError as error:
        parser.error(error)
    rows = [
        (name, f"{three:.3f} {unit}", f"{many:.3f} {unit}", f"{three / many - 1.0:+.1%}")
        for name, unit, three, many in zip(("period", "peak of the bit"), ("s", "rad/s"), coarse, fine, strict=True)
    ]
    matrices = (jacobian(chain.rig), chain.matrix, Chain(2 * chosen.lumps, FRICTION, chosen.viscosity).matrix)
    three, many, twice = (lowest_mode(matrix) for matrix in matrices)
    for name, unit, one, other in zip(("lowest mode", "its damping"), ("rad/s", "1/s"), three, many, strict=True):
        rows.append((name, f"{one:.4f} {unit}", f"{other:.4f} {unit}", f"{one / other - 1.0:+.1%}"))
    print_table(("", "three lumps", f"{chosen.lumps} lumps", "off by"), rows)
    print(f"the lowest mode of {2 * chosen.lumps} lumps: {twice[0]:.4f} rad/s")


def lowest_mode(matrix: FloatArray) -> tuple[float, float]:
    """Lowest frequency (rad/s) at which string and drive swing, and the rate (1/s) at which that dies."""
    modes = np.linalg.eigvals(matrix)
    swinging = modes[modes.imag > np.abs(modes.real)]
    lowest = swinging[np.argmin(swinging.imag)]
    return float(lowest.imag), -float(lowest.real)


if __name__ == "__main__":
    raise SystemExit(main())
