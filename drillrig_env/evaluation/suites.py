"""Suites: the rigs that every policy faces, with starts, loads and seeds of their own."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from typing import Any

import numpy as np

from drillrig_env.env.scenario import Scenario
from drillrig_env.parameters import closest, refuse

EVALUATION_SEEDS = 1_000_000_000
"""Rig i of a suite has the seed EVALUATION_SEEDS + i; training takes seeds below only."""


@dataclass(frozen=True, eq=False)
class Suite:
    """Rigs to face. `groups` lists how many rigs share which reset options, in the rigs' order."""

    name: str
    description: str
    scenario: Scenario
    groups: tuple[tuple[int, dict[str, Any]], ...]

    @property
    def rigs(self) -> int:
        """Number of rigs, each an episode."""
        return sum(count for count, _ in self.groups)


def default_suite(rigs: int = 1000) -> Suite:
    """Draws of the default scenario from developed stick-slip, with constant N_1: the headline."""
    options = {"start": "stick_slip", "load_steps": []}
    return Suite("default", "default draws, starts in stick-slip", Scenario.named("default"), ((rigs, options),))


def chapter_suite(_rigs: int = 0) -> Suite:
    """The chapter's own cases: 10 N and 20 N over 1 to 5 rad/s, and 25 N stepped on at 3.0 and 3.14 rad/s."""
    targets = np.round(np.arange(1.0, 5.01, 0.2), 10)
    sweeps = [
        (len(targets), {"speed_target": targets, "normal_force": force, "start": "stick_slip", "load_steps": []})
        for force in (10.0, 20.0)
    ]
    stepped = (
        2,
        {"speed_target": np.array([3.0, 3.14]), "normal_force": 0.0, "start": "steady", "load_steps": [(10.0, 25.0)]},
    )
    return Suite("chapter", "the chapter's own cases", Scenario.named("nominal"), (*sweeps, stepped))


SUITES: dict[str, Callable[[int], Suite]] = {"default": default_suite, "chapter": chapter_suite}


def suite(name: str, rigs: int = 1000) -> Suite:
    """A suite by name; `rigs` counts for suites that are drawn. `ValueError` for an unknown name or rigs < 1."""
    if name not in SUITES:
        raise ValueError(f"suite {name!r} is not known; {closest(name, SUITES)}")
    if rigs < 1:
        raise refuse(f"suite {name}", "rigs", rigs, "", ">= 1")
    return SUITES[name](rigs)
