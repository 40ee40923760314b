"""One rig in stick-slip (20 N, 2 rad/s): simulated seconds a second and error, against other solvers.

    python -m benchmarks.solvers
    python -m benchmarks.solvers --repeats 9 --json results/solvers.json

Everything runs on one core, in one run, sampled every 0.1 s. The error is the largest of the bit
speed over the first 20 s, against Radau with the kinks split by events (rtol 1e-11). The chapter's
way is timed over a few seconds of motion only: it is that slow. Compilation is not counted.
"""

from __future__ import annotations

import argparse
from collections.abc import Callable
from pathlib import Path
from typing import Any

import numpy as np
from scipy.integrate import odeint

from benchmarks.measure import median_seconds, print_table, write_json
from drillrig_env import Friction, Rig, simulate
from drillrig_env.batch import advance_batch
from drillrig_env.friction import FloatArray
from drillrig_env.model import state_equations
from drillrig_env.reference import radau, vode

RIG, FRICTION, SPEED = Rig(), Friction(20.0), 2.0
START = np.array([0.0, 0.0, 2.0, 2.0, 2.0, 0.5, 0.0])
JUDGED, DURATION, CHAPTER_DURATION = 20.0, 50.0, 4.0  # s


def times(duration: float) -> FloatArray:
    """Sample times every 0.1 s, s."""
    return 0.1 * np.arange(round(duration / 0.1) + 1, dtype=np.float64)


def compiled_rates() -> Callable[[FloatArray, FloatArray], None]:
    """The right-hand side (4-17) with (4-9), compiled, as the peers get it: rates(x, out)."""
    import numba

    p = RIG
    J_1, J_2, J_3, k_1, k_2, d_1, d_2 = p.J_1, p.J_2, p.J_3, p.k_1, p.k_2, p.d_1, p.d_2
    loss, gain, drop, back = p.eta**2 * p.C_m, p.eta * p.K_T, p.eta * p.T_f, p.eta * p.K_E
    L, R, k_p, k_i, omega_s = p.L, p.R, p.k_p, p.k_i, p.omega_s
    static, kinetic, v_b = 20.0 * p.r_1 * 0.5, 20.0 * p.r_1 * 0.306, 1.0

    @numba.njit(error_model="numpy")  # type: ignore[untyped-decorator,unused-ignore]
    def rates(x: FloatArray, out: FloatArray) -> None:
        a = abs(x[2])
        torque = static * x[2] / omega_s
        if a >= omega_s:
            torque = np.sign(x[2]) * (kinetic + (static - kinetic) * np.exp(-v_b * a))
        out[0] = x[2] - x[3]
        out[1] = x[3] - x[4]
        out[2] = (-d_1 * (x[2] - x[3]) - k_1 * x[0] - torque) / J_1
        out[3] = (d_1 * x[2] - (d_1 + d_2) * x[3] + d_2 * x[4] + k_1 * x[0] - k_2 * x[1]) / J_2
        out[4] = (k_2 * x[1] + d_2 * x[3] - (loss + d_2) * x[4] + gain * x[5] - drop) / J_3
        out[5] = (-R * x[5] - back * x[4] + k_p * (SPEED - x[4]) + k_i * x[6]) / L
        out[6] = SPEED - x[4]

    check = np.empty(7)
    rates(START, check)
    torque = float(FRICTION.torque(RIG, START[2]))
    np.testing.assert_allclose(check, state_equations(START, SPEED, torque, RIG), rtol=1e-12)
    return rates


def numbalsoda_solver(rates: Any, rtol: float) -> Callable[[float], FloatArray]:
    """LSODA of numbalsoda on the compiled right-hand side."""
    import numba
    from numba import carray  # type: ignore[attr-defined]
    from numbalsoda import lsoda, lsoda_sig

    @numba.cfunc(lsoda_sig)  # type: ignore[untyped-decorator,unused-ignore]
    def address(_t: float, x: Any, out: Any, _p: Any) -> None:
        rates(carray(x, 7), carray(out, 7))

    def solve(duration: float) -> FloatArray:
        states, success = lsoda(address.address, START, times(duration), rtol=rtol, atol=1e-3 * rtol, mxstep=10**7)
        if not success:
            raise RuntimeError("numbalsoda gave up")
        return np.asarray(states)

    return solve


def odeint_solver(rates: Any, rtol: float) -> Callable[[float], FloatArray]:
    """SciPy's odeint (LSODA) on the compiled right-hand side."""

    def right_hand_side(x: FloatArray, _t: float) -> FloatArray:
        out = np.empty(7)
        rates(x, out)
        return out

    return lambda duration: np.asarray(
        odeint(right_hand_side, START, times(duration), rtol=rtol, atol=1e-3 * rtol, mxstep=10**7)
    )


def vode_solver(with_jacobian: bool) -> Callable[[float], FloatArray]:
    """The chapter's VODE-BDF in Python, at rtol 1e-8."""
    return lambda duration: np.concatenate(
        [START[None], vode(RIG, FRICTION, SPEED, START, times(duration), rtol=1e-8, with_jacobian=with_jacobian)]
    )


def project(duration: float) -> FloatArray:
    """The fast stepper at its default setting."""
    states = advance_batch(RIG, FRICTION, START[None], SPEED, periods=round(duration / 0.1))
    return np.concatenate([START[None], states[0]])


def contenders() -> dict[str, tuple[Callable[[float], FloatArray], float]]:
    """Each solver and the motion (s) it is timed over; a missing peer is skipped with a hint."""
    rates = compiled_rates()
    found = {
        "DrillRig, default": (project, DURATION),
        "SciPy VODE-BDF, Python, rtol 1e-8 (the chapter's)": (vode_solver(False), CHAPTER_DURATION),
        "SciPy VODE-BDF, Python, with Jacobian, rtol 1e-8": (vode_solver(True), DURATION),
        "SciPy odeint, compiled, rtol 1e-8": (odeint_solver(rates, 1e-8), DURATION),
    }
    try:
        for rtol in (1e-4, 1e-6, 1e-8):
            found[f"numbalsoda LSODA, compiled, rtol {rtol:.0e}"] = (numbalsoda_solver(rates, rtol), DURATION)
    except ImportError:
        print("numbalsoda is not installed and is left out; install it with: pip install numbalsoda\n")
    return found


def main() -> None:
    """Measure all solvers and print the table."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--repeats", type=int, default=5, help="timings of which the median counts (default: 5)")
    parser.add_argument("--json", type=Path, default=Path("results/solvers.json"), help="where to write the figures")
    arguments = parser.parse_args()
    reference = radau(RIG, FRICTION, SPEED, START, times(JUDGED))[:, 2]
    results: dict[str, Any] = {}
    for name, (solve, duration) in contenders().items():
        judged = min(duration, JUDGED)
        bit_speed = solve(judged)[1:, 2]
        error = float(np.abs(bit_speed - reference[: len(bit_speed)]).max())
        repeats = 1 if solve is not project and duration < JUDGED else arguments.repeats
        seconds = median_seconds(lambda solve=solve, duration=duration: solve(duration), repeats)  # type: ignore[misc]
        results[name] = {"error": error, "rate": duration / seconds}
    fastest = results["DrillRig, default"]["rate"]
    for result in results.values():
        result["ratio"] = fastest / result["rate"]
    print_table(
        ["solver", "error, rad/s", "simulated s a second", "DrillRig is faster by"],
        [[name, f"{r['error']:.1e}", f"{r['rate']:,.0f}", f"{r['ratio']:,.1f} x"] for name, r in results.items()],
    )
    worst = accuracy()
    print(f"\nlargest error of any speed over the 30 stored runs (2 to 40 N, 0.3 to 9 rad/s): {worst:.1e} rad/s")
    write_json(arguments.json, {"solvers": results, "largest_error": worst})


def accuracy() -> float:
    """Largest error of any speed at the default setting over the stored reference runs of the tests, rad/s."""
    from tests.reference import arguments, stored

    return max(
        float(np.abs(simulate(sample_period=0.1, **arguments(*case)).state[:, 2:5] - speeds).max())
        for case, speeds in stored().items()
    )


if __name__ == "__main__":
    main()
