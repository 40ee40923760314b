"""Versions, machine and date: what an artefact needs to be made again."""

from __future__ import annotations

import platform
from collections.abc import Iterable, Mapping
from datetime import UTC, datetime
from importlib.metadata import PackageNotFoundError, version
from typing import Any

from drillrig_env.engine.likeness import processor
from drillrig_env.jit.threads import available_threads

_PACKAGES = ("drillrig", "gymnasium", "numpy", "scipy", "numba", "stable-baselines3", "torch")


def provenance() -> dict[str, Any]:
    """Date, Python, machine with processor and cores, and the versions of the packages that count."""
    cores = available_threads()
    return {
        "date": datetime.now(UTC).date().isoformat(),
        "python": platform.python_version(),
        "machine": f"{platform.system()} {platform.machine()}, {processor()}, {cores} core{'s' * (cores > 1)}",
        "versions": {package: _version(package) for package in _PACKAGES},
    }


def note_processors(made: dict[str, Any], processors: Iterable[str]) -> None:
    """Note in a `provenance` the types of processors elsewhere, where they are not this machine's: bits may differ."""
    if others := sorted({*processors} - {processor()}):
        made["processors"] = [processor(), *others]


def when_and_where(made: Mapping[str, Any]) -> str:
    """Date and machine of a `provenance`, as pages say it."""
    return f"{made['date']}, {made['machine']}"


def in_words(made: Mapping[str, Any], beside: Mapping[str, str | None] | None = None) -> str:
    """All of a `provenance` as pages say it; `beside` are versions of packages that it does not name."""
    known = {**made["versions"], **(beside or {})}
    versions = ", ".join(f"{name} {number}" for name, number in known.items() if number)
    return f"{when_and_where(made)}, Python {made['python']}, {versions}"


def _version(package: str) -> str | None:
    try:
        return version(package)
    except PackageNotFoundError:
        return None
