"""The gains that `python -m baselines.tune` found, from its record tuned.json."""

from __future__ import annotations

import json
from functools import lru_cache
from pathlib import Path
from typing import Any

RECORD = Path(__file__).with_name("tuned.json")
"""What was found and how: a list, one entry for each controller and choice of sensors."""


def tuned_values(controller: str) -> dict[str, dict[str, float]]:
    """The values found for a controller's arguments, by the sensors that it was tuned with."""
    return {
        sensors: dict(entry["values"])
        for entry in _entries()
        if entry["controller"] == controller
        for sensors in entry["sensors"]
    }


@lru_cache(maxsize=1)
def _entries() -> list[dict[str, Any]]:
    entries: list[dict[str, Any]] = json.loads(RECORD.read_text(encoding="utf-8"))
    return entries
