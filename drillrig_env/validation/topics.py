"""All checks of the chapter, by topic."""

from __future__ import annotations

from functools import cache

from drillrig_env.validation import diagrams, equations, local_stability, low_end, time_responses
from drillrig_env.validation.check import Check

_TOPICS = {
    "Equations and parameters (section 4.1)": equations.checks,
    "Runs in time (sections 4.2, 4.3)": time_responses.checks,
    "Standstill and H1 (sections 4.4.1, 4.4.3)": low_end.checks,
    "Local stability (section 4.4.2)": local_stability.checks,
    "Bifurcation diagrams (section 4.4.3)": diagrams.checks,
}


@cache
def all_checks() -> dict[str, tuple[Check, ...]]:
    """Every check by topic; computed once, in some seconds."""
    return {topic: tuple(checks()) for topic, checks in _TOPICS.items()}
