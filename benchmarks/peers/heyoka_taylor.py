"""heyoka: adaptive Taylor series, one compiled integrator for each piece of (4-9), ended by events at its edges.

Each piece is smooth, so the kinks cost no accuracy. In stick the integrator must step as fast as the stick
zone is stiff. `fast_math` is on and compact mode off, since both ways it was found to be faster. heyoka's stores
of compiled code, on disk and in memory, are left out, so that the time of compiling is seen. Tolerances above
1e-5 are left out: at 1e-4 a kink was missed.
"""

from __future__ import annotations

from typing import Any

import numpy as np

from benchmarks.case import ONE_RIG, RIG, START, slip_torque, stick_torque
from benchmarks.peers.peer import Library, Peer, Run, Setting
from drillrig_env.arrays import FloatArray
from drillrig_env.friction.law import zone_of
from drillrig_env.model import state_equations

LIBRARY = Library("heyoka", "heyoka", "heyoka")
EDGES = {0: (-1, 1), 1: (1,), -1: (-1,)}
"""The edges of each piece, as multiples of omega_s: 0 stick, 1 slip forwards, -1 slip backwards."""


def equations(piece: int) -> list[tuple[Any, Any]]:
    """(4-17) with one piece of (4-9) as heyoka's symbols: each state and its rate."""
    import heyoka

    x, contact = heyoka.make_vars(*(f"x_{i}" for i in range(1, 8))), ONE_RIG.contacts[0].tolist()
    torque = slip_torque(heyoka.exp, piece, x[2], contact) if piece else stick_torque(x[2], contact)
    return list(zip(x, state_equations(x, contact[3], torque, RIG), strict=True))


def integrator(piece: int, tolerance: float) -> Any:
    """The integrator of one piece; its terminal events are the edges of the piece, crossed outwards."""
    import heyoka

    rates = equations(piece)
    x_3 = rates[2][0]
    outwards = {1: heyoka.event_direction.positive, -1: heyoka.event_direction.negative}
    events = [
        heyoka.t_event(x_3 - side * RIG.omega_s, direction=outwards[side if piece == 0 else -side])
        for side in EDGES[piece]
    ]
    return heyoka.taylor_adaptive(rates, START.tolist(), tol=tolerance, t_events=events, fast_math=True)


def prepare(setting: Setting, times: FloatArray) -> Run:
    """The Taylor integrators of all three pieces, compiled anew."""
    import heyoka

    heyoka.llvm_state.set_diskcache_enabled(False)
    heyoka.llvm_state.clear_memcache()
    pieces = {piece: integrator(piece, setting.rtol) for piece in EDGES}
    return lambda: follow(pieces, times)


def follow(pieces: dict[int, Any], times: FloatArray) -> FloatArray:
    """The motion through one piece after the other."""
    states = np.empty((len(times), 7))
    states[0] = x = START
    piece, time, done = zone_of(float(START[2]), RIG.omega_s, np.inf), float(times[0]), 1
    while done < len(times):
        solver = pieces[piece]
        solver.time, solver.state[:] = time, x
        solver.reset_cooldowns()
        outcome, *_, sampled = solver.propagate_grid(np.concatenate([[time], times[done:]]))
        states[done : done + len(sampled) - 1] = sampled[1:]
        done += len(sampled) - 1
        if done < len(times):
            edge = EDGES[piece][-int(outcome) - 1]  # a terminal event without a callback is told as -1 - its number
            time, x = solver.time, solver.state.copy()
            x[2] = edge * RIG.omega_s
            piece = edge if piece == 0 else 0
    return states


PEERS = (
    Peer(
        LIBRARY,
        "Taylor with events",
        "symbols, compiled for each piece of the law",
        tuple(Setting(tolerance, tolerance) for tolerance in (1e-5, 1e-6, 1e-8, 1e-10, 1e-12)),
        prepare,
    ),
)
