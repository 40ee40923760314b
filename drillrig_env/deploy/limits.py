"""Within what a policy may act on a rig: limits of the speed reference, of current and torque, and of patience."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import asdict, dataclass
from typing import Any

from drillrig_env.allowed import Made, Text
from drillrig_env.parameters import COUNT, NOT_NEGATIVE, POSITIVE, check_fields, parameter, refuse
from drillrig_env.scales import Scales

_LEVEL_OF_CURRENT, _LEVEL_OF_TORQUE = 1.3, 0.3  # A and N m: of the chapter's rig in steady rotation
_TIMES = ("overload_time", "stale", "hold_time", "fallback_time", "sound_time")


def _read_ranges(ranges: Any) -> dict[str, tuple[float, float]]:
    """Plausible values by channel, as pairs (low, high)."""
    if not isinstance(ranges, Mapping):
        raise ValueError("is not allowed; allowed: (low, high) by channel")
    found = {str(name): (float(pair[0]), float(pair[1])) for name, pair in ranges.items()}
    for name, (low, high) in found.items():
        if not low < high:
            raise refuse("Limits", f"plausible {name}", (low, high), "", "low < high")
    return found


@dataclass(frozen=True)
class Limits:
    """What a `Supervisor` keeps. Set them for the rig at hand: the defaults are the chapter rig's; see `for_policy`.

    Raises `ValueError` for a value that is not allowed.
    """

    lowest_reference: float = parameter(0.0, "rad/s", "lowest speed reference", allowed=NOT_NEGATIVE)
    highest_reference: float = parameter(10.0, "rad/s", "highest speed reference", allowed=POSITIVE)
    rate: float = parameter(2.0, "rad/s^2", "largest rate of the speed reference", allowed=POSITIVE)
    top_speed: float = parameter(12.0, "rad/s", "top speed above which the rig is brought down", allowed=POSITIVE)
    current: float = parameter(4.0, "A", "current either way, above which the reference stays", allowed=POSITIVE)
    torque: float = parameter(1.5, "N m", "torque into the string either way, likewise", allowed=POSITIVE)
    overload_time: float = parameter(2.0, "s", "of current or torque above, until the ramp down", allowed=POSITIVE)
    stale: float = parameter(0.25, "s", "age from which a measurement counts as missing", allowed=POSITIVE)
    frozen: int = parameter(20, "control steps", "without any change, from which one counts as frozen", allowed=COUNT)
    hold_time: float = parameter(1.0, "s", "that the reference is held in a fault", allowed=NOT_NEGATIVE)
    fallback_time: float = parameter(10.0, "s", "of the fallback law, until the ramp down", allowed=NOT_NEGATIVE)
    sound_time: float = parameter(1.0, "s", "without a fault, until the policy acts again", allowed=NOT_NEGATIVE)
    fallback: str = parameter(
        "constant", meaning="law in a fault", allowed=Text("constant, z_torque, or the path of a file of z_torque")
    )
    safe_speed: float = parameter(1.0, "rad/s", "where the ramp of a fault ends", allowed=NOT_NEGATIVE)
    ramp: float = parameter(0.5, "rad/s^2", "rate of the ramp down", allowed=POSITIVE)
    plausible: dict[str, tuple[float, float]] = parameter(
        factory=dict, meaning="plausible values of channels", allowed=Made(_read_ranges, "(low, high) by channel")
    )

    def __post_init__(self) -> None:
        check_fields(self)
        if not self.lowest_reference < self.highest_reference:
            allowed = f"< highest_reference = {self.highest_reference:g}"
            raise refuse("Limits", "lowest_reference", self.lowest_reference, "rad/s", allowed)
        if not self.safe_speed <= self.highest_reference:
            allowed = f"<= highest_reference = {self.highest_reference:g}"
            raise refuse("Limits", "safe_speed", self.safe_speed, "rad/s", allowed)

    @classmethod
    def for_policy(cls, about: Mapping[str, Any], **given: Any) -> Limits:
        """The limits of the rig that a policy's file is for, with those that are `given` in their place.

        `about` is that of a `PolicyFile`. Range and rate are the policy's, all else grows with the rig's scales (three
        digits are kept); on the chapter's rig it is the defaults. `ValueError` for a value that is not allowed.
        """
        highest = float(about["speed_reference"]["high"])
        scales, own = Scales.of(about["rig"], highest), cls()
        grown = {
            "top_speed": own.top_speed * scales.speed,
            "current": _LEVEL_OF_CURRENT * scales.current + (own.current - _LEVEL_OF_CURRENT) * scales.current_swing,
            "torque": _LEVEL_OF_TORQUE * scales.load + (own.torque - _LEVEL_OF_TORQUE) * scales.torque,
            "safe_speed": own.safe_speed * scales.speed,
            "ramp": own.ramp * scales.rate,
            **{name: getattr(own, name) * scales.time for name in _TIMES},
        }
        rounded = {name: float(f"{value:.3g}") for name, value in grown.items()}
        rate = float(about["slew_limit"]["value"])
        return cls(**{"highest_reference": highest, "rate": rate, **rounded, **given})

    def as_dict(self) -> dict[str, Any]:
        """The fields by name, for files."""
        return asdict(self)
