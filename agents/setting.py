"""A setting of a comparison, and what a comparison is scored on."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass

from agents.training.settings import Training


@dataclass(frozen=True)
class Setting:
    """A setting of a comparison: its name, what a table calls it, and the training of its first seed."""

    name: str
    words: str
    training: Training


@dataclass(frozen=True)
class ScoredOn:
    """What a comparison is scored on: suites by name (None: those of one rig), sensors, and policies beside.

    The latter by what a table calls them.
    """

    suites: tuple[str, ...] | None
    sensors: str
    beside: Mapping[str, str]
