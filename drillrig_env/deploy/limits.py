"""Within what a policy may act on a rig: limits of the speed reference, of current and torque, and of patience."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import asdict, dataclass
from typing import Any

from drillrig_env.allowed import Made, Text
from drillrig_env.parameters import COUNT, NOT_NEGATIVE, POSITIVE, check_fields, parameter, refuse


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
    """What a `Supervisor` keeps. Set them for the rig at hand: the defaults are the chapter rig's.

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

    def as_dict(self) -> dict[str, Any]:
        """The fields by name, for files."""
        return asdict(self)
