"""The chapter's figures on a rig of one's own: how far its axes reach, and what may still be said of it."""

from __future__ import annotations

from dataclasses import fields
from math import isfinite

from drillrig_env.friction import Friction
from drillrig_env.rig import Rig
from drillrig_env.stability import fold_speed

_MOST_NAMED = 4  # changed parameters that a caption names


def scale(rig: Rig, normal_force: float) -> float:
    """How far a rig's speeds reach beside those of the chapter's: the ratio of the folds at a normal force (N).

    1.0 for the chapter's rig. `ValueError` where the rig has no stick-slip at that force.
    """
    if rig == Rig():
        return 1.0
    own, chapter = (float(fold_speed(one, Friction(normal_force))) for one in (rig, Rig()))
    if not isfinite(own):
        raise ValueError(f"this rig has no stick-slip at {normal_force:g} N, and so no fold")
    return own / chapter


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
