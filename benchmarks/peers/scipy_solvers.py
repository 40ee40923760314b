"""SciPy's solvers: VODE as the chapter uses it, and all of them with what they take to go faster.

The chapter's form is `drillrig_env.reference.vode`: the right-hand side in Python, functional iteration
(SciPy's default for VODE). The others call a right-hand side that is compiled by Numba, straight, with no
Python between. A Jacobian, compiled as well, goes to those that gain from it; VODE makes its own by
differences, with which it is faster here (SciPy 1.17 reads a user's one transposed).
"""

from __future__ import annotations

from collections.abc import Callable
from typing import Literal

import numba
import numpy as np
from scipy.integrate import ode, odeint, solve_ivp

from benchmarks.case import ONE_RIG, RIG, START, compiled_jacobian, compiled_rates
from benchmarks.peers.peer import Library, Peer, Run, Setting, settings
from drillrig_env import Friction
from drillrig_env.arrays import FloatArray
from drillrig_env.reference import vode

LIBRARY = Library("SciPy", "scipy", "scipy")
STEPS = 10_000_000  # more than any run takes between two samples
Compiled = Callable[[float, FloatArray], FloatArray]


def compiled_pair() -> tuple[Compiled, Compiled]:
    """Right-hand side and Jacobian as functions of time and state, in machine code."""
    rates, slopes, contact = compiled_rates(), compiled_jacobian(), ONE_RIG.contacts[0]

    @numba.njit(error_model="numpy")
    def right_hand_side(_t: float, x: FloatArray) -> FloatArray:
        out = np.empty(7)
        rates(x, contact, out)
        return out

    @numba.njit(error_model="numpy")
    def jacobian(_t: float, x: FloatArray) -> FloatArray:
        out = np.empty((7, 7))
        slopes(x, contact, out)
        return out

    right_hand_side(0.0, START)
    jacobian(0.0, START)
    return right_hand_side, jacobian


def prepare_chapter(setting: Setting, times: FloatArray) -> Run:
    """VODE-BDF with Python and functional iteration."""
    friction, speed = Friction(float(ONE_RIG.normal_force[0])), float(ONE_RIG.speed_reference[0])
    return lambda: np.concatenate(
        [START[None], vode(RIG, friction, speed, START, times, rtol=setting.rtol, with_jacobian=False)]
    )


def prepare_vode(setting: Setting, times: FloatArray) -> Run:
    """VODE-BDF with Newton's iteration."""
    right_hand_side, _ = compiled_pair()

    def run() -> FloatArray:
        solver = ode(right_hand_side).set_integrator(
            "vode", method="bdf", rtol=setting.rtol, atol=setting.atol, with_jacobian=True, nsteps=STEPS
        )
        solver.set_initial_value(START, times[0])
        states = [START, *(solver.integrate(time) for time in times[1:])]
        if not solver.successful():
            raise RuntimeError(f"vode: gave up at t = {solver.t:g} s")
        return np.array(states)

    return run


def prepare_odeint(setting: Setting, times: FloatArray) -> Run:
    """LSODA behind `odeint`."""
    right_hand_side, jacobian = compiled_pair()

    def run() -> FloatArray:
        states, report = odeint(
            right_hand_side,
            START,
            times,
            Dfun=jacobian,
            tfirst=True,
            rtol=setting.rtol,
            atol=setting.atol,
            mxstep=STEPS,
            full_output=True,
        )
        if "successful" not in report["message"]:
            raise RuntimeError(f"odeint: {report['message']}")
        return np.asarray(states)

    return run


def prepare_solve_ivp(method: Literal["LSODA", "Radau"]) -> Callable[[Setting, FloatArray], Run]:
    """A method behind `solve_ivp`."""

    def prepare(setting: Setting, times: FloatArray) -> Run:
        right_hand_side, jacobian = compiled_pair()
        span, rtol, atol = (times[0], times[-1]), setting.rtol, setting.atol

        def run() -> FloatArray:
            found = solve_ivp(right_hand_side, span, START, method, times, jac=jacobian, rtol=rtol, atol=atol)
            if not found.success:
                raise RuntimeError(f"{method}: {found.message}")
            return np.asarray(found.y).T

        return run

    return prepare


COMPILED = "compiled right-hand side"
FINE = settings(1e-4, 1e-5, 1e-6, 1e-7, 1e-8, 5e-9, 1e-9)
CHAPTER = Peer(
    LIBRARY,
    "VODE-BDF, the chapter's form",
    "Python right-hand side, functional iteration",
    settings(1e-4, 1e-6, 1e-8, 3e-9, 1e-9),
    prepare_chapter,
)
PEERS = (
    CHAPTER,
    Peer(
        LIBRARY,
        "VODE-BDF, with_jacobian",
        f"{COMPILED}, Newton's iteration",
        (*FINE, Setting(1e-8, 1e-9), Setting(5e-9, 5e-10)),
        prepare_vode,
    ),
    Peer(
        LIBRARY,
        "odeint (LSODA)",
        f"{COMPILED} and Jacobian",
        (*FINE, Setting(1e-8, 1e-9), Setting(5e-9, 5e-9)),
        prepare_odeint,
    ),
    Peer(LIBRARY, "solve_ivp LSODA", f"{COMPILED} and Jacobian", FINE, prepare_solve_ivp("LSODA")),
    Peer(
        LIBRARY,
        "solve_ivp Radau",
        f"{COMPILED} and Jacobian",
        settings(1e-3, 1e-4, 1e-5, 1e-6, 1e-7),
        prepare_solve_ivp("Radau"),
    ),
)
