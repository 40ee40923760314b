"""How `reset(options=...)` pins what an episode would draw: the keys that it knows, and what is allowed of each."""

from __future__ import annotations

from collections.abc import Collection, Mapping
from typing import Any

import numpy as np
import numpy.typing as npt

from drillrig_env.allowed import Allowed
from drillrig_env.arrays import FloatArray
from drillrig_env.env.scenario import GIVEN, MOST_LOAD_STEPS, STARTS
from drillrig_env.model import STATE_NAMES, STATE_UNITS
from drillrig_env.parameters import NOT_NEGATIVE, POSITIVE, closest, refuse

_PINS: dict[str, tuple[str, Allowed]] = {
    "normal_force": ("N", NOT_NEGATIVE),
    "mu_s": ("", NOT_NEGATIVE),
    "mu_k": ("", NOT_NEGATIVE),
    "v_b": ("s/rad", POSITIVE),
    "speed_target": ("rad/s", POSITIVE),
}
PINS = (*_PINS, "rig", "start", "state", "speed_reference", "load_steps")
"""The keys that `reset(options=...)` understands."""


def check_pins(
    options: Mapping[str, Any] | None,
    rigs: int,
    duration: float,
    targets: Allowed = POSITIVE,
    given: Collection[str] = (),
) -> dict[str, Any]:
    """The options of a reset, checked: numbers (or one entry a rig), a start, a state, a list of load steps.

    `duration` (s) is that of an episode, `targets` are the speed targets (rad/s) that the task allows, the largest of
    which is the largest speed reference, and `given` is what the scenario's course gives, which cannot be pinned.

    Raises `ValueError` for an unknown key or an impossible value; it names the key, the value, its
    unit and what is allowed.
    """
    pins: dict[str, Any] = {}
    for key, value in options_of(options).items():
        if key not in PINS:
            raise ValueError(f"reset options: unknown key {key!r}; {closest(key, PINS)}")
        if key in given or (key == "load_steps" and "normal_force" in given):
            raise ValueError(f"reset options: {key} cannot be pinned, the scenario's course gives {', '.join(given)}")
        if key == "rig":
            pins[key] = value  # an index or a rig; the bank knows them
        elif key == "start":
            pins[key] = _check_start(value, rigs)
        elif key == "state":
            pins[key] = _check_state(value, rigs)
        elif key == "speed_reference":
            pins[key] = _check_number(key, value, rigs, "rad/s", Allowed(0.0, targets.high))
        elif key == "load_steps":
            pins[key] = _check_load_steps(value, duration)
        else:
            unit, allowed = _PINS[key]
            pins[key] = _check_number(key, value, rigs, unit, targets if key == "speed_target" else allowed)
    if "mu_s" in pins and "mu_k" in pins and np.any(pins["mu_s"] < pins["mu_k"]):
        raise refuse("reset options", "mu_s", pins["mu_s"], "", f">= mu_k = {pins['mu_k']}")
    _check_together(pins)
    return pins


def options_of(options: Any) -> dict[str, Any]:
    """The options of a reset as a dictionary of their own; None is an empty one. `ValueError` for anything else."""
    if options is not None and not isinstance(options, Mapping):
        raise refuse("reset", "options", repr(options), "", f"a dictionary, with the keys {', '.join(PINS)}")
    return dict(options or {})


def pins_of(options: Mapping[str, Any], indices: npt.NDArray[np.intp], rigs: int) -> dict[str, Any]:
    """The options of some of `rigs` rigs, from options whose lists have one entry for each of them all."""
    shapes: dict[str, tuple[int, ...]] = {"state": (rigs, len(STATE_NAMES))}
    return {
        key: np.asarray(value)[indices]
        if key != "load_steps" and np.shape(value) == shapes.get(key, (rigs,))
        else value
        for key, value in options.items()
    }


def _check_number(key: str, value: Any, rigs: int, unit: str, allowed: Allowed) -> FloatArray:
    if not allowed.holds(value):
        raise refuse("reset options", key, value, unit, allowed)
    array = np.asarray(value, dtype=float)
    if array.shape not in ((), (rigs,)):
        raise refuse("reset options", f"shape of {key}", array.shape, "", f"one number, or ({rigs},)")
    return array


def _check_start(value: Any, rigs: int) -> np.ndarray:
    names = np.asarray(value)
    if names.shape not in ((), (rigs,)) or not all(name in STARTS for name in np.atleast_1d(names)):
        raise refuse("reset options", "start", repr(value), "", f"{', '.join(STARTS)}; one, or one a rig")
    return np.array([STARTS.index(name) for name in np.atleast_1d(names)]).reshape(names.shape)


def _check_state(value: Any, rigs: int) -> FloatArray:
    states = ", ".join(f"{name} in {unit}" for name, unit in zip(STATE_NAMES, STATE_UNITS, strict=True))
    shapes = ((len(STATE_NAMES),), (rigs, len(STATE_NAMES)))
    try:
        array = np.asarray(value)
    except ValueError as error:  # lists of unequal lengths
        raise refuse("reset options", "state", repr(value), "", f"numbers of shape (7,): {states}") from error
    if array.dtype.kind not in "iuf" or array.shape not in shapes:
        given = array.shape if array.dtype.kind in "iuf" else repr(value)
        raise refuse("reset options", "shape of state", given, "", f"(7,) or ({rigs}, 7): {states}")
    for name, unit, column in zip(STATE_NAMES, STATE_UNITS, np.moveaxis(array, -1, 0), strict=True):
        if not Allowed().holds(column):
            raise refuse("reset options", f"{name} of state", column, unit, Allowed())
    return array.astype(float)


def _check_together(pins: Mapping[str, Any]) -> None:
    """Refuse what belongs to a given state without one, and another start beside one."""
    starts = np.atleast_1d(pins.get("start", []))
    if "state" in pins and np.any(starts != GIVEN):
        other = STARTS[starts[starts != GIVEN][0]]
        raise refuse("reset options", "start", other, "", f"none beside a state, or {STARTS[GIVEN]}")
    if "state" not in pins and np.any(starts == GIVEN):
        raise refuse("reset options", "start", STARTS[GIVEN], "", f"{', '.join(STARTS[:GIVEN])}; or a state beside it")
    if "state" not in pins and "speed_reference" in pins:
        raise ValueError(
            f"reset options: speed_reference = {pins['speed_reference']} rad/s is not allowed without a state; other "
            "episodes begin with that of the target, and at rest with 0 rad/s"
        )


def _check_load_steps(value: Any, duration: float) -> list[tuple[float, float]]:
    allowed = "a list of (time in s, N_1 in N)"
    try:
        table = np.asarray(list(value) or np.empty((0, 2)))
    except (TypeError, ValueError) as error:
        raise refuse("reset options", "load_steps", repr(value), "", allowed) from error
    if table.dtype.kind not in "iuf" or table.ndim != 2 or table.shape[1] != 2:
        raise refuse("reset options", "load_steps", repr(value), "", allowed)
    steps = [(float(time), float(force)) for time, force in table]
    times = [time for time, _ in steps]
    if len(steps) > MOST_LOAD_STEPS:
        raise refuse("reset options", "number of load_steps", len(steps), "", f"<= {MOST_LOAD_STEPS}")
    if any(not 0.0 <= time <= duration for time in times) or times != sorted(times):
        raise refuse("reset options", "times of load_steps", times, "s", f"ascending, 0 to {duration:g}")
    for _, force in steps:
        if not NOT_NEGATIVE.holds(force):
            raise refuse("reset options", "load_steps", force, "N", NOT_NEGATIVE)
    return steps
