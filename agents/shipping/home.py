"""The suites that an agent faces before it is shipped."""

from __future__ import annotations

from drillrig_env.evaluation.suites import OF_ONE_RIG, meant_for

_BESIDE = {"DrillRigUnknown-v0": ("drift",)}
"""Suites of other environments whose sensors and drive are the same."""


def suites_of(env_id: str) -> tuple[str, ...]:
    """The suites that an environment's agents face: those of its own rigs, and those of the one rig."""
    return tuple(dict.fromkeys((*meant_for(env_id), *_BESIDE.get(env_id, ()), *OF_ONE_RIG)))
