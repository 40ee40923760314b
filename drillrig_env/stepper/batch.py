"""The fast stepper over a batch of rigs: many frictions, states and speed references at once."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from drillrig_env.arrays import FloatArray, Quantity, Records
from drillrig_env.drive import Drive, DriveLike
from drillrig_env.friction import Friction, FrictionLike
from drillrig_env.jit.compiled import compiled
from drillrig_env.jit.threads import check_threads, over_slices
from drillrig_env.model import check_state
from drillrig_env.parameters import NOT_NEGATIVE, refuse
from drillrig_env.rig import Rig, RigLike
from drillrig_env.stepper.finite import check_finite
from drillrig_env.stepper.ladder import UNITS, from_equilibrium, to_states
from drillrig_env.stepper.limits import check_computable
from drillrig_env.stepper.propagator import advance
from drillrig_env.stepper.tables import TOLERANCE, step_tables
from drillrig_env.stepper.times import sample_count, step_of
from drillrig_env.stepper.workspace import workspace


def simulate_batch(
    rig: RigLike = None,
    friction: FrictionLike = None,
    initial_state: FloatArray | Sequence[float] | None = None,
    speed_reference: Quantity = 2.0,
    duration: float = 30.0,
    sample_period: float = 0.1,
    threads: int | None = None,
    tolerance: float = TOLERANCE,
    drive: DriveLike = None,
) -> FloatArray:
    """Simulate many rigs at once with the fast stepper; their states, shape (rigs, samples, 7).

    Runs go to `duration` and are sampled every `sample_period`.

    `friction`, `speed_reference` (rad/s) and `initial_state` ((7,) or (rigs, 7)) have one entry a rig,
    or one for all; the first sample is the start, times are in s. `threads`: default all cores; `rig`, `friction`,
    `tolerance` and `drive` as for `simulate`. Each rig comes out bit for bit as from there, whatever its company and
    the number of threads.

    >>> import numpy as np
    >>> simulate_batch(None, Friction(np.linspace(5, 30, 100)), speed_reference=3.0).shape
    (100, 301, 7)
    """
    rig, friction, drive = Rig.of(rig), Friction.of(friction), Drive.of(drive)
    check_computable(rig, drive)
    samples = sample_count("simulate_batch", duration, sample_period)
    if not NOT_NEGATIVE.holds(speed_reference):
        raise refuse("simulate_batch", "speed_reference", speed_reference, "rad/s", NOT_NEGATIVE)
    start = np.atleast_2d(check_state(rig, initial_state, drive))
    lengths = {friction.as_array().shape[0], np.size(speed_reference), start.shape[0]} - {1}
    if len(lengths) > 1:
        raise refuse("simulate_batch", "number of rigs", sorted(lengths), "", "the same for every argument, or one")
    start = np.broadcast_to(start, (max(lengths, default=1), 7))
    parts, step = step_of(rig, float(sample_period))
    states = advance_batch(
        rig,
        friction,
        start,
        speed_reference,
        period=step,
        periods=samples * parts,
        every=parts,
        threads=threads,
        tolerance=tolerance,
        where="simulate_batch",
        drive=drive,
    )
    return np.concatenate([start[:, None], states], axis=1)


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
    tolerance: float = TOLERANCE,
    where: str = "advance_batch",
    begin: float = 0.0,
    drive: Drive | None = None,
) -> FloatArray:
    """Advance rigs that share `rig` by a number of periods (s) of constant speed reference.

    `states` has shape (n, 7), `friction` and `speed_reference` (rad/s) one entry a rig or one for
    all. Returns the states after every `every`-th period, shape (n, periods // every, 7): bit for
    bit the same for a batch as for its rigs one at a time, and for any number of `threads`. `drive` takes the
    place of the rig's own. Raises `NotFiniteError` for a state that is no longer finite.
    """
    rigs = states.shape[0]
    tables = step_tables(rig, period, tolerance, drive)
    contacts = friction.contacts(rig, speed_reference, rigs)
    result = np.empty((rigs, periods // every, 7))

    def run(part: slice) -> None:
        _advance_rigs(
            np.ascontiguousarray(states[part], dtype=float),
            contacts[part],
            tables.ladders,
            workspace(),
            every,
            result[part],
        )

    over_slices(run, rigs, check_threads(threads), periods)
    times: FloatArray = begin + period * every * np.arange(1, periods // every + 1, dtype=float)
    check_finite(result, times, where)
    return result


@compiled
def _advance_rigs(
    states: FloatArray,
    contacts: Records,
    ladders: Records,
    works: Records,
    every: int,
    result: FloatArray,
) -> None:
    work, ladder = works[0], ladders[0]
    y = work.y
    for n in range(states.shape[0]):
        contact = contacts[n]
        from_equilibrium(states[n], contact, ladder, y)
        for sample in range(result.shape[1]):
            for _ in range(every):
                advance(y, contact, ladders, 0, work, False, UNITS)
            to_states(y, contact, ladder, result[n, sample])
