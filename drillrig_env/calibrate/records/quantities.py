"""The quantities of a record, the units in which loggers write them, and the names that they go by."""

from __future__ import annotations

import re
from collections.abc import Mapping
from dataclasses import dataclass
from math import pi

from drillrig_env.parameters import closest

_REVOLUTION = 2.0 * pi
_POUND = 4.4482216152605  # N, a pound of force
_FOOT = 0.3048  # m

UNITS: Mapping[str, Mapping[str, float]] = {
    "time": {"s": 1.0, "ms": 1e-3, "us": 1e-6, "ns": 1e-9, "min": 60.0, "h": 3600.0, "day": 86400.0},
    "speed": {"rad/s": 1.0, "rpm": _REVOLUTION / 60.0, "deg/s": _REVOLUTION / 360.0, "rev/s": _REVOLUTION},
    "angle": {"rad": 1.0, "deg": _REVOLUTION / 360.0, "rev": _REVOLUTION},
    "current": {"A": 1.0, "mA": 1e-3, "kA": 1e3},
    "voltage": {"V": 1.0, "mV": 1e-3, "kV": 1e3},
    "torque": {"N m": 1.0, "mN m": 1e-3, "kN m": 1e3, "ft lbf": _POUND * _FOOT, "kft lbf": 1e3 * _POUND * _FOOT},
    "force": {"N": 1.0, "kN": 1e3, "kgf": 9.80665, "tf": 9806.65, "lbf": _POUND, "klbf": 1e3 * _POUND},
}
"""By kind of quantity: its units, the SI unit first, and what one of each is in SI units."""

QUANTITIES: Mapping[str, str] = {
    "time": "time",
    "bit_speed": "speed",
    "collar_speed": "speed",
    "top_speed": "speed",
    "bit_angle": "angle",
    "collar_angle": "angle",
    "top_angle": "angle",
    "current": "current",
    "voltage": "voltage",
    "torque_into_string": "torque",
    "speed_reference": "speed",
    "normal_force": "force",
}
"""What a column can be, and its kind. An angle becomes the speed of the same disc."""

LEFT_OUT = "none"
"""What a column is mapped to that is not to be read."""

_SPELLINGS = {
    "time": {"sec": "s", "second": "s", "seconds": "s", "sek": "s", "msec": "ms", "millisecond": "ms", "usec": "us",
             "milliseconds": "ms", "microseconds": "us", "minutes": "min", "hours": "h", "hr": "h", "d": "day",
             "days": "day"},
    "speed": {"rads": "rad/s", "rad/sec": "rad/s", "rads-1": "rad/s", "radps": "rad/s", "radian/s": "rad/s",
              "radians/s": "rad/s", "1/min": "rpm", "min-1": "rpm", "u/min": "rpm", "umin": "rpm", "rev/min": "rpm",
              "r/min": "rpm", "/min": "rpm", "degs": "deg/s", "deg/sec": "deg/s", "°/s": "deg/s", "degps": "deg/s",
              "degrees/s": "deg/s", "rps": "rev/s", "hz": "rev/s", "turns/s": "rev/s", "r/s": "rev/s"},
    "angle": {"radian": "rad", "radians": "rad", "°": "deg", "degree": "deg", "degrees": "deg",
              "turn": "rev", "turns": "rev", "revolutions": "rev"},
    "current": {"amp": "A", "amps": "A", "ampere": "A"},
    "voltage": {"volt": "V", "volts": "V"},
    "torque": {"n-m": "N m", "kn-m": "kN m", "ftlb": "ft lbf", "ft-lb": "ft lbf", "ft-lbf": "ft lbf",
               "lbft": "ft lbf", "lbfft": "ft lbf", "lbf-ft": "ft lbf", "kftlb": "kft lbf", "kft-lb": "kft lbf",
               "kft-lbf": "kft lbf", "klbfft": "kft lbf", "klbf-ft": "kft lbf"},
    "force": {"kg": "kgf", "t": "tf", "ton": "tf", "tons": "tf", "lb": "lbf", "lbs": "lbf", "klb": "klbf",
              "klbs": "klbf", "kip": "klbf", "kips": "klbf"},
}  # fmt: skip

_NAMES: Mapping[str, tuple[str, ...]] = {
    "time": ("t", "times", "timestamp", "time_stamp", "datetime", "date_time", "elapsed", "elapsed_time", "tout",
             "relative_time", "clock", "x_value", "zeit", "uhrzeit", "zeitstempel", "tempo", "tiempo", "temps"),
    "bit_speed": ("speed_bit", "bit_velocity", "bit_angular_velocity", "bit_angular_speed", "bit_rotation_speed",
                  "downhole_speed", "w_bit", "velocity_bit"),
    "collar_speed": ("speed_collar", "collars_speed", "collar_velocity", "collar_angular_velocity"),
    "top_speed": ("speed_top", "top_velocity", "top_angular_velocity", "top_angular_speed", "top_drive_speed",
                  "topdrive_speed", "surface_speed", "rotary_speed", "velocity_top", "w_top"),
    "bit_angle": ("angle_bit", "bit_encoder", "theta_bit", "bit_theta"),
    "collar_angle": ("angle_collar", "collar_encoder"),
    "top_angle": ("angle_top", "top_encoder", "theta_top", "top_theta", "top_drive_angle"),
    "current": ("motor_current", "armature_current", "current_motor"),
    "voltage": ("motor_voltage", "armature_voltage", "voltage_motor"),
    "torque_into_string": ("string_torque", "surface_torque", "top_torque", "top_drive_torque"),
    "speed_reference": ("reference_speed", "speed_ref", "ref_speed", "speed_setpoint", "speed_set_point",
                        "setpoint_speed"),
    "normal_force": ("wob", "weight_on_bit"),
}  # fmt: skip
"""Other names for each quantity; a column that goes by one of these must have a unit."""

_NAMES_WITH_UNIT = {
    "bit_rpm": ("bit_speed", "rpm"),
    "rpm_bit": ("bit_speed", "rpm"),
    "downhole_rpm": ("bit_speed", "rpm"),
    "omega_bit": ("bit_speed", "rad/s"),
    "bit_omega": ("bit_speed", "rad/s"),
    "collar_rpm": ("collar_speed", "rpm"),
    "omega_collar": ("collar_speed", "rad/s"),
    "top_rpm": ("top_speed", "rpm"),
    "rpm_top": ("top_speed", "rpm"),
    "top_drive_rpm": ("top_speed", "rpm"),
    "topdrive_rpm": ("top_speed", "rpm"),
    "surface_rpm": ("top_speed", "rpm"),
    "rotary_rpm": ("top_speed", "rpm"),
    "omega_top": ("top_speed", "rad/s"),
    "omega_ref": ("speed_reference", "rad/s"),
    "rpm_setpoint": ("speed_reference", "rpm"),
    "rpm_ref": ("speed_reference", "rpm"),
}


_BRACKETED = re.compile(r"(.*?)\s*[\[(<{]\s*(?!\d+[\])>}])([^\])>}]*?)\s*[\])>}]")


@dataclass(frozen=True)
class Guess:
    """What a column's name says: its quantity, and its unit as it is written, "" where none is."""

    quantity: str
    unit: str
    own_name: bool  # whether it is the quantity's own name, which stands for SI units where no unit is written


def unit_of(kind: str, text: str) -> str | None:
    """The unit of this kind that a text writes in one of its spellings; None where it is none.

    >>> unit_of("speed", "1/min"), unit_of("torque", "kN·m"), unit_of("speed", "m/s")
    ('rpm', 'kN m', None)

    A minus sign in front turns a quantity round: `-rpm`.
    """
    if text.strip().startswith("-"):
        turned = unit_of(kind, text.strip()[1:])
        return turned and f"-{turned}"
    plain = _plain(text)
    known = {_plain(unit): unit for unit in UNITS[kind]} | _SPELLINGS[kind]
    if kind == "angle" and (steps := re.fullmatch(r"counts?/(\d+)", plain)) and int(steps[1]) > 0:
        return f"counts/{steps[1]}"
    return known.get(plain)


def factor(kind: str, unit: str) -> float:
    """What one of a unit of `unit_of` is in SI units; of an encoder with N steps a turn, `counts/N`, one step."""
    if unit.startswith("-"):
        return -factor(kind, unit[1:])
    return _REVOLUTION / int(unit.partition("/")[2]) if unit.startswith("counts/") else UNITS[kind][unit]


def units_allowed(kind: str) -> str:
    """The units of a kind, as a message lists them."""
    return ", ".join([*UNITS[kind], *(["counts/N of an encoder with N steps a turn"] if kind == "angle" else [])])


def is_unit(text: str) -> bool:
    """Whether a text is a unit of any quantity, alone or in brackets."""
    return any(unit_of(kind, text) for kind in UNITS)


def read_target(text: str) -> tuple[str, str]:
    """Quantity and unit of the text `bit_speed:rpm`; the unit is "" where none is written.

    Raises `ValueError` for a quantity that is not known and a unit that it is not measured in.
    """
    name, _, unit = (part.strip() for part in text.partition(":"))
    if name == LEFT_OUT:
        return LEFT_OUT, ""
    if name not in QUANTITIES:
        raise ValueError(f"{name!r} is not known; {closest(name, [*QUANTITIES, LEFT_OUT])}")
    kind = QUANTITIES[name]
    if not unit:
        return name, ""
    found = unit_of(kind, unit)
    if found is None:
        raise ValueError(f"{unit!r} is no unit of {name}; allowed: {units_allowed(kind)}")
    return name, found


def bracketed(name: str) -> str:
    """What stands in brackets at the end of a column's name; "" where nothing does.

    >>> bracketed("Sensor 2 [rpm]")
    'rpm'
    """
    parts = _BRACKETED.fullmatch(name.strip())
    return parts[2] if parts else ""


def guess(name: str) -> Guess | None:
    """What a column's name says, such as "Bit Speed [rpm]", "bit_speed_rpm" or "WOB (kN)"; None where it is nothing.

    >>> guess("Bit_Speed_rpm")
    Guess(quantity='bit_speed', unit='rpm', own_name=True)
    """
    parts = _BRACKETED.fullmatch(name.strip())
    if parts:
        found = _of_words(_words(parts[1]))
        return found and Guess(found.quantity, parts[2] or found.unit, found.own_name)
    words = _words(name)
    for last in range(len(words), 0, -1):
        found = _of_words(words[:last])
        if found is None:
            continue
        rest = [word for word in words[last:] if word not in ("in", "per")]
        if not rest:
            return found
        for unit in ("/".join(rest), "".join(rest)):
            if known := unit_of(QUANTITIES[found.quantity], unit):
                return Guess(found.quantity, known, found.own_name)
    return None


def _of_words(words: list[str]) -> Guess | None:
    name = "_".join(words)
    if name in QUANTITIES:
        return Guess(name, "", own_name=True)
    if name in _NAMES_WITH_UNIT:
        return Guess(*_NAMES_WITH_UNIT[name], own_name=False)
    return next((Guess(quantity, "", own_name=False) for quantity, names in _NAMES.items() if name in names), None)


def _words(name: str) -> list[str]:
    """The words of a name in small letters: "BitSpeed", "bit speed" and "Bit_Speed" are bit and speed."""
    parted = re.sub(r"(?<=[a-z0-9])(?=[A-Z])", "_", name)
    return re.findall(r"[^\W_]+|°", parted.lower())


def _plain(unit: str) -> str:
    text = unit.strip().strip("[](){}<>").lower().replace("⁻¹", "-1").replace("µ", "u").replace("μ", "u")
    return re.sub(r"[\s·⋅*.^_]", "", text)
