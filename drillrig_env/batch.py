"""The fast stepper over a batch of rigs: many frictions, states and speed references at once."""

from __future__ import annotations

import numpy as np

from drillrig_env.compiled import compiled
from drillrig_env.friction import FloatArray, Friction, Quantity
from drillrig_env.ladder import STATE, ladder
from drillrig_env.propagator import WORKSPACE, advance
from drillrig_env.rig import Rig
from drillrig_env.threads import check_threads, over_slices


def advance_batch(
    rig: Rig,
    friction: Friction,
    states: FloatArray,
    speed_reference: Quantity,
    *,
    period: float = 0.1,
    periods: int = 1,
    every: int = 1,
    threads: int | None = 1,
) -> FloatArray:
    """Advance rigs that share `rig` by a number of periods (s) of constant speed reference.

    `states` has shape (n, 7), `friction` and `speed_reference` (rad/s) one entry a rig or one for
    all. Returns the states after every `every`-th period, shape (n, periods // every, 7): bit for
    bit the same for a batch as for its rigs one at a time, and for any number of `threads`.
    """
    rigs = states.shape[0]
    tables = ladder(rig, period)
    contact = friction.as_array(rigs)
    reference = np.ascontiguousarray(np.broadcast_to(np.asarray(speed_reference, dtype=float), rigs))
    result = np.empty((rigs, periods // every, 7))

    def run(part: slice) -> None:
        _advance_rigs(
            np.ascontiguousarray(states[part], dtype=float),
            reference[part],
            contact[part],
            rig.r_1,
            rig.omega_s,
            tables.rungs,
            tables.sampling,
            tables.shift,
            every,
            result[part],
        )

    over_slices(run, rigs, check_threads(threads))
    return result


@compiled
def _advance_rigs(states, reference, contact, r_1, omega_s, rungs, sampling, shift, every, result):  # type: ignore[no-untyped-def]
    work = np.zeros(1, dtype=WORKSPACE)[0]
    y = np.zeros(STATE)
    for n in range(states.shape[0]):
        speed = reference[n]
        normal_force, mu_s, mu_k, v_b = contact[n]
        static, kinetic = normal_force * r_1 * mu_s, normal_force * r_1 * mu_k
        for i in range(7):
            y[i] = states[n, i] - shift[0, i] - shift[1, i] * speed
        for sample in range(result.shape[1]):
            for _ in range(every):
                advance(y, speed, static, kinetic, v_b, omega_s, rungs, sampling, work, False)
            for i in range(7):
                result[n, sample, i] = y[i] + shift[0, i] + shift[1, i] * speed
