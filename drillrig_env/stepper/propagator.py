"""The fast exact stepper: one rig, one period of held speed reference, in compiled code.

Steps go down and up a ladder of halved lengths. A step is solved with the piece of the law that holds
where it begins (`drillrig_env.stepper.collocation`), and kept if no node leaves that piece. Otherwise it tells
where about it meets the kink, such as that at |x_3| = omega_s; shorter steps lead up to there, and a `fine` one leads
across, exactly (`drillrig_env.stepper.kinks`). What even that cannot do, such as a bit that shoots through the stick
zone, is left to ever shorter steps, the last ones below a picosecond. Where not even these are solved, or too many
would be needed, the states become NaN: no number is better than a wrong one. A state that overflows ends as infinite.

A rig may have several modes (`drillrig_env.stepper.modes`). A step that leaves its mode is treated as one that meets a
kink: shorter ones lead up to there, and a `fine` one leads across (`drillrig_env.stepper.switching`).
"""

from __future__ import annotations

from math import inf, nan

from drillrig_env.arrays import FloatArray, Record, Records
from drillrig_env.friction.law import zone_of
from drillrig_env.jit.compiled import compiled, inlined
from drillrig_env.stepper.caution import caution_for
from drillrig_env.stepper.collocation import evaluate, solve_nodes, take_step
from drillrig_env.stepper.edges import way_out
from drillrig_env.stepper.ladder import DEPTH, RUNGS, SAMPLED_RUNGS, SAMPLES, UNITS, rows_of, table_of
from drillrig_env.stepper.switching import enter, step_across, to_own_mode
from drillrig_env.stepper.turning import begin_turning

_SAMPLE_UNITS = UNITS // SAMPLES
_PER_UNIT = 1 << DEPTH
"""Shortest steps in a unit."""

_STICK_RUNG, _KINK_RUNG = 1, SAMPLED_RUNGS
"""The longest steps that are taken in stick, and across kinks (`fine` ones), in rungs below the first one."""

_LARGEST = 1e100
"""A state beyond this has overflowed."""

_MOST_STEPS = 1 << 20
"""Most steps of a period, tried ones counted."""


@compiled
def advance(y: FloatArray, contact: Record, ladders: Records, rig: int, work: Record, sampled: bool, stop: int) -> None:
    """Advance one rig over one period of held input, or its first `stop` of UNITS units, in place.

    y             shape (8,): the 7 states less the frictionless equilibrium, and a pad
    contact       a CONTACT record: the friction and the speed reference
    ladders, rig  those of a `Tables`, and the place of the rig among them
    work          a WORKSPACE record; where `sampled` is true, its SAMPLES samples of bit speed
                  (rad/s) and string torque (N m) are taken at equal distances, the last at the end
    """
    mode, has_modes, angle = rig, ladders[rig].has_modes, contact.angle
    work.speed_reference = contact.speed_reference
    work.caution, work.fast_gain = caution_for(contact, ladders[rig]), 0.0
    if has_modes:
        mode = to_own_mode(y, rig, contact, ladders, work)
    ladder = ladders[mode]
    first, fine_from = ladder.first, ladder.fine_from
    position, rung, end, end_of_period, tries = 0, first, stop * _PER_UNIT, UNITS * _PER_UNIT, 0
    kink = end_of_period
    while position < end:
        zone = zone_of(y[2] + contact.speed_reference, contact.omega_s, contact.knee)
        if zone == 0:
            rung = rung if rung > first + _STICK_RUNG else first + _STICK_RUNG
        size = end_of_period >> rung
        # `size` is a power of two: this is position % size, in a tenth of the time.
        off_grid = position & (size - 1) != 0
        if off_grid or position + size > end or (rung < first + _KINK_RUNG and position + size > kink):
            rung += 1
            continue
        tries += 1
        if contact.tilt > 0.0:
            work.length = contact.period * (float(size) / float(end_of_period))
            work.elapsed = contact.period * (float(position) / float(end_of_period))
            begin_turning(y, contact, work)
        reach, new = solve_nodes(y, zone, contact, ladder, rung, work), mode
        if has_modes and reach == 1.0 and rung < RUNGS - 1:
            reach, new = way_out(y, mode, ladders, contact, rung, work, 1.0)
        if reach == 1.0:
            if sampled and rung < SAMPLED_RUNGS:
                _sample_step(y, contact.speed_reference, ladder, rung, work, position // (_SAMPLE_UNITS * _PER_UNIT))
            take_step(y, table_of(ladder, rung), work)
            climb = 1
            if has_modes and rung == RUNGS - 1:
                new = to_own_mode(y, mode, contact, ladders, work)
        else:
            new = step_across(y, zone, mode, new, ladders, contact, rung, work, reach) if rung >= fine_from else -1
            climb = rung
        if new < 0:
            if rung == RUNGS - 1 or tries > _MOST_STEPS:
                _lose(y, work)
                return
            if reach > 0.0:
                kink = position + int(reach * size)
            rung += 1
            continue
        if new != mode:
            mode, ladder = new, ladders[new]
            first, fine_from = ladder.first, ladder.fine_from
        position += size
        if sampled and rung >= SAMPLED_RUNGS and position % (_SAMPLE_UNITS * _PER_UNIT) == 0:
            _sample_state(y, contact.speed_reference, ladder, work, position // (_SAMPLE_UNITS * _PER_UNIT) - 1)
        rung = rung - climb if rung - climb > first else first
        if position > kink:
            kink = end_of_period
    if mode != rig:
        enter(y, mode, rig, contact, ladders, work)
    contact.angle = angle


@inlined
def _lose(y: FloatArray, work: Record) -> None:
    """Mark a rig whose step is not solved: all states NaN; infinite where one has overflowed."""
    overflowed = False
    for i in range(7):
        overflowed |= not abs(y[i]) <= _LARGEST
    for i in range(7):
        y[i] = inf if overflowed else nan
    for k in range(SAMPLES):
        work.speed_samples[k] = work.torque_samples[k] = y[2]


@inlined
def _sample_step(y: FloatArray, speed_reference: float, ladder: Record, rung: int, work: Record, first: int) -> None:
    """Samples inside a solved step that is about to be taken, as entries `first` and on.

    SAMPLES entries are worked out, whatever the length of the step: those past its end mean nothing and are written
    over by the steps after it, and one width for all steps is compiled in a fraction of the time.
    """
    table, speeds, torques, rows = ladder.sampling, work.speed_samples, work.torque_samples, rows_of(rung)
    evaluate(y, work, table.speed_from_state, table.speed_from_torque, rows, speed_reference, speeds, first, SAMPLES)
    at_rest = ladder.torque_at_rest + ladder.torque_per_speed * speed_reference
    evaluate(y, work, table.torque_from_state, table.torque_from_torque, rows, at_rest, torques, first, SAMPLES)


@inlined
def _sample_state(y: FloatArray, speed_reference: float, ladder: Record, work: Record, index: int) -> None:
    """The sample of a state that lies on the grid, as entry `index`."""
    torque = ladder.torque_at_rest + ladder.torque_per_speed * speed_reference
    for k in range(7):
        torque += y[k] * ladder.torque_row[k]
    work.speed_samples[index], work.torque_samples[index] = y[2] + speed_reference, torque
