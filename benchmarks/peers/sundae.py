"""CVODE of SUNDIALS through scikit-sundae: BDF, dense linear algebra, right-hand side and Jacobian compiled.

The functions of the form `f(t, y, yp)` write in place and are Numba's own, so that no Python stands between.
"""

from __future__ import annotations

import numba
import numpy as np

from benchmarks.case import ONE_RIG, START, compiled_jacobian, compiled_rates
from benchmarks.peers.peer import Library, Peer, Run, Setting, settings
from drillrig_env.arrays import FloatArray

LIBRARY = Library("scikit-sundae", "sksundae", "scikit-sundae")


def prepare(setting: Setting, times: FloatArray) -> Run:
    """CVODE with BDF."""
    from sksundae.cvode import CVODE

    rates, slopes, contact = compiled_rates(), compiled_jacobian(), ONE_RIG.contacts[0]

    @numba.njit(error_model="numpy")
    def right_hand_side(_t: float, y: FloatArray, yp: FloatArray) -> None:
        rates(y, contact, yp)

    @numba.njit(error_model="numpy")
    def jacobian(_t: float, y: FloatArray, _yp: FloatArray, out: FloatArray) -> None:
        slopes(y, contact, out)

    solver = CVODE(
        right_hand_side,
        method="BDF",
        linsolver="dense",
        jacfn=jacobian,
        rtol=setting.rtol,
        atol=setting.atol,
        max_num_steps=10_000_000,
    )

    def run(times: FloatArray) -> FloatArray:
        found = solver.solve(times, START)
        if not found.success:
            raise RuntimeError(f"CVODE: {found.message}")
        return np.asarray(found.y)

    run(0.01 * times[:2])
    return lambda: run(times)


PEERS = (
    Peer(
        LIBRARY,
        "CVODE-BDF",
        "compiled right-hand side and Jacobian",
        (*settings(1e-4, 1e-5, 1e-6, 1e-7, 1e-8, 1e-9), Setting(5e-9, 5e-10)),
        prepare,
    ),
)
