"""The chapter's figures on a rig of one's own: how far its axes reach, and what may still be said of it."""

from __future__ import annotations

from dataclasses import fields, replace
from math import isfinite

from drillrig_env.arrays import FloatArray
from drillrig_env.friction import Friction
from drillrig_env.rig import Rig
from drillrig_env.scales import Scales
from drillrig_env.stability import fold_speed

_MOST_NAMED = 4  # changed parameters that a caption names


def pressed(rig: Rig, normal_force: float | FloatArray) -> Friction:
    """The friction of a rig at what corresponds to a normal force (N) on the chapter's; see `drillrig_env.scales`."""
    scales = Scales.of(rig)
    return replace(scales.friction, normal_force=normal_force * scales.force)


def scale(rig: Rig, normal_force: float) -> float:
    """How far a rig's speeds reach beside those of the chapter's: the ratio of the folds at a normal force (N) of its.

    1.0 for the chapter's rig. `ValueError` where the rig has no stick-slip at the force that corresponds to it.
    """
    if rig == Rig():
        return 1.0
    friction = pressed(rig, normal_force)
    own, chapter = float(fold_speed(rig, friction)), float(fold_speed(Rig(), Friction(normal_force)))
    if not isfinite(own):
        raise ValueError(f"this rig has no stick-slip at {friction.normal_force:.4g} N, and so no fold")
    return own / chapter


def rounded(speed: float) -> float:
    """A speed (rad/s) as it is written in a picture."""
    return float(f"{speed:.3g}")


def only_for_the_chapters(rig: Rig, text: str) -> str:
    """`text`, which holds for the chapter's rig; nothing for another."""
    return text if rig == Rig() else ""


def differences(rig: Rig) -> str:
    """In what a rig differs from the chapter's, in words; empty for the chapter's."""
    changed = [item for item in fields(Rig) if getattr(rig, item.name) != getattr(Rig(), item.name)]
    named = [
        f"{item.name} = {getattr(rig, item.name):g} {item.metadata['unit']}".rstrip() for item in changed[:_MOST_NAMED]
    ]
    more = len(changed) - len(named)
    return ", ".join([*named, f"{more} more"] if more else named)
