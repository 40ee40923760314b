"""What a minute of its records tells of each rig of a fleet: rigs and frictions to design for."""

from __future__ import annotations

import time
from collections.abc import Sequence
from dataclasses import dataclass, replace
from math import log, sqrt

import numpy as np

from baselines.calibrated import LQGCalibrated
from benchmarks.calibration import Kind, logged
from drillrig_env import Fleet, Friction, Rig
from drillrig_env.calibrate.beside import beside
from drillrig_env.calibrate.calibration import calibrate
from drillrig_env.calibrate.misfit import misfits
from drillrig_env.calibrate.records import Record
from drillrig_env.calibrate.unknowns import OF_FRICTION, OF_RIGS, values_of
from drillrig_env.env.registration import UNKNOWN
from drillrig_env.evaluation.suites import Suite
from drillrig_env.fleet import GROUPS

LOAD, PERIOD, LENGTH = 20.0, 0.02, 60.0  # N, s, s
CHANNELS = ("top_speed", "current", "voltage")

KNOWN = {name: log(factor) / sqrt(3.0) for group, factor in UNKNOWN.items() for name in GROUPS[group]}
"""Standard deviations of the parameters' logarithms, as the suite draws them."""

_FRICTION = Friction(LOAD)
NOMINAL = values_of(Rig(), _FRICTION)
"""The nominal rig's parameters by name."""

_FREE, _SLOW = [(0.0, 2.0), (4.0, 5.0), (8.0, 3.0)], [(40.0, 1.5), (47.0, 2.5), (54.0, 1.2)]  # s, rad/s
_REFERENCE = [*_FREE, *((12.0 + 0.5 * k, 6.0 - 4.0 * k / 56.0) for k in range(56)), *_SLOW]
_LOADS = [(0.0, 0.0), (12.0, LOAD)]  # s, N


@dataclass(frozen=True)
class Found:
    """What a rig's record told: its parameters by name, or why the nominal ones stay; and the processor's time, s."""

    values: dict[str, float]
    failed: str
    seconds: float


def kinds_of(judged: Suite) -> list[Kind]:
    """The rigs of a suite with their frictions, at the records' load."""
    fleet = judged.scenario.rigs
    assert fleet is not None
    members = fleet.members()
    mu_k, fall, v_b = members.friction.T * [[NOMINAL[name]] for name in OF_FRICTION]
    return [
        Kind(rig, Friction(LOAD, *(float(one[k]) for one in (mu_k + fall, mu_k, v_b))))
        for k, rig in enumerate(members.rigs)
    ]


def record_of(kind: Kind, seed: int, number: int) -> Record:
    """The minute of a rig, as its logger writes it."""
    random = np.random.default_rng([seed, number, 9])
    early = PERIOD * random.uniform()  # the reference does not jump at samples
    reference = [(max(0.0, begin - early), speed) for begin, speed in _REFERENCE]
    return logged(kind, f"rig {number}", reference, _LOADS, LENGTH, random, period=PERIOD, channels=CHANNELS)


def found_of(seed: int, rig: tuple[int, Kind]) -> Found:
    """What the record of a rig, given with its number, tells."""
    number, kind = rig
    begin = time.process_time()
    try:
        values, failed = fitted(record_of(kind, seed, number)), ""
        LQGCalibrated("surface", found=fleet_of([Found(values, failed, 0.0)]))
    except (ValueError, ArithmeticError) as error:
        values, failed = {}, f"{type(error).__name__}: {error}"
    return Found(values, failed, time.process_time() - begin)


def fitted(record: Record) -> dict[str, float]:
    """The parameters by name that fit a record best. `ValueError` where they do not follow it."""
    fix = {"k_p": None, "k_i": None}
    found = calibrate([record], Rig(), _FRICTION, fix=fix, weigh=KNOWN, starts=1)
    if told := misfits(found, beside(found)):
        raise ValueError("; ".join(map(str, told)))
    return values_of(found.rig, found.friction)


def fleet_of(found: Sequence[Found]) -> Fleet:
    """The rigs that were found, the nominal one where none was."""
    values = [{**NOMINAL, **one.values} for one in found]
    rigs = tuple(replace(Rig(), **{name: one[name] for name in OF_RIGS}) for one in values)
    factors = tuple(tuple(one[name] / NOMINAL[name] for name in OF_FRICTION) for one in values)
    return Fleet(rigs=rigs, friction=factors)
