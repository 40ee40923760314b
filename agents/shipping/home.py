"""The suite at whose rigs an agent is at home: by which its seed is chosen, and of which its card tells most."""

from __future__ import annotations

from drillrig_env.evaluation.suites import OF_ONE_RIG

_AT_HOME = {"DrillRigUnknown-v0": ("unknown", "unknown_hard", "drift"), "DrillRigDrift-v0": ("drift",)}
"""Suites of those environments that are not about one rig that stays as it is, the own one first."""


def home_suite(env_id: str) -> str:
    """The suite of an environment's rigs."""
    return _AT_HOME.get(env_id, ("default",))[0]


def suites_of(env_id: str) -> tuple[str, ...]:
    """The suites that an environment's agents face."""
    return (*_AT_HOME.get(env_id, ()), *OF_ONE_RIG)
