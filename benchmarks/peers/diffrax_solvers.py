"""diffrax: JAX's solvers, compiled by XLA in double precision, forwards only; a batch is their `vmap`.

The implicit Kvaerno pairs take their Jacobian from JAX's own differentiation; Tsit5 is explicit.
"""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

import numpy as np

from benchmarks.case import ONE_RIG, START, Rigs, array_rates
from benchmarks.peers.peer import BatchPeer, Library, Peer, Run, Setting, settings
from drillrig_env.arrays import FloatArray

LIBRARY = Library("diffrax", "diffrax", "diffrax")


def right_hand_side(_t: Any, x: Any, contact: Any) -> Any:
    """(4-17) with (4-9) in JAX; shapes (7,), (4,) to (7,)."""
    import jax.numpy as jnp

    return jnp.stack(array_rates(jnp, x, contact))


def solution(method: str, setting: Setting, times: FloatArray) -> Callable[[Any], Any]:
    """The states at all times as a function of one contact, to be transformed and compiled by JAX."""
    import diffrax
    import jax

    jax.config.update("jax_enable_x64", True)  # type: ignore[no-untyped-call,unused-ignore]
    jax.config.update("jax_platforms", "cpu")  # type: ignore[no-untyped-call,unused-ignore]
    import jax.numpy as jnp

    def solve(contact: Any) -> Any:
        return diffrax.diffeqsolve(
            diffrax.ODETerm(right_hand_side),
            getattr(diffrax, method)(),
            t0=float(times[0]),
            t1=float(times[-1]),
            dt0=None,
            y0=jnp.asarray(START),
            args=contact,
            saveat=diffrax.SaveAt(ts=jnp.asarray(times)),
            stepsize_controller=diffrax.PIDController(rtol=setting.rtol, atol=setting.atol),
            adjoint=diffrax.ForwardMode(),
            max_steps=10**9,
        ).ys

    return solve


def prepare(method: str) -> Callable[[Setting, FloatArray], Run]:
    """One rig with one method."""

    def prepare_one(setting: Setting, times: FloatArray) -> Run:
        import jax

        contact = ONE_RIG.contacts[0]
        program = jax.jit(solution(method, setting, times)).lower(contact).compile()
        return lambda: np.asarray(program(contact))

    return prepare_one


def prepare_batch(rigs: Rigs, setting: Setting, times: FloatArray, threads: int) -> Run:
    """Many rigs with Kvaerno5, all in step; XLA takes the threads that the process may use."""
    import jax

    contacts = rigs.contacts
    program = jax.jit(jax.vmap(solution("Kvaerno5", setting, times))).lower(contacts).compile()
    return lambda: np.asarray(program(contacts))


FORM = "JAX right-hand side, compiled whole by XLA"
PEERS = (
    Peer(LIBRARY, "Kvaerno3", FORM, settings(1e-4, 1e-5, 1e-6, 1e-7, 1e-8), prepare("Kvaerno3")),
    Peer(LIBRARY, "Kvaerno5", FORM, settings(1e-4, 1e-5, 1e-6, 1e-7, 1e-8, 1e-9), prepare("Kvaerno5")),
    Peer(LIBRARY, "Tsit5", FORM, settings(1e-4, 1e-6, 1e-8, 1e-10), prepare("Tsit5")),
)
BATCH_PEERS = (BatchPeer(LIBRARY, "vmap Kvaerno5, all cores", FORM, settings(1e-6), prepare_batch),)
