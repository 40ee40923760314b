"""The rooms that decide: which files are mutated, and which tests stand for each."""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path


@dataclass(frozen=True)
class Room:
    """Files and folders to mutate, and the tests that all of them share (files and folders)."""

    sources: tuple[str, ...]
    tests: tuple[str, ...]


ROOMS = {
    "model": Room(
        (
            "drillrig_env/model.py",
            "drillrig_env/verdict.py",
            "drillrig_env/drive.py",
            "drillrig_env/policy",
            "drillrig_env/simulation.py",
            "drillrig_env/friction",
        ),
        (
            "tests/test_model.py",
            "tests/test_verdict.py",
            "tests/test_friction.py",
            "tests/test_contact.py",
            "tests/test_drive.py",
            "tests/test_simulation.py",
            "tests/policy",
        ),
    ),
    "stepper": Room(("drillrig_env/stepper",), ("tests/stepper",)),
    "env": Room(("drillrig_env/env",), ("tests/env",)),
    "stability": Room(("drillrig_env/stability",), ("tests/stability",)),
    "engine": Room(("drillrig_env/engine",), ("tests/engine",)),
    "evaluation": Room(("drillrig_env/evaluation",), ("tests/evaluation",)),
    "baselines": Room(("baselines",), ("tests/baselines",)),
    "calibrate": Room(("drillrig_env/calibrate",), ("tests/calibrate",)),
    "deploy": Room(("drillrig_env/deploy",), ("tests/deploy", "tests/twin")),
    "twin": Room(("drillrig_env/twin",), ("tests/twin",)),
}

_LEFT_ALONE = (
    "drillrig_env/calibrate/page.py",
    "drillrig_env/calibrate/pictures",
    "drillrig_env/calibrate/report.py",
    "drillrig_env/engine/on_ray.py",
    "drillrig_env/engine/tune_on_ray.py",
    "drillrig_env/env/charts.py",
    "drillrig_env/env/rendering.py",
    "drillrig_env/evaluation/findings.py",
    "drillrig_env/evaluation/pictures",
    "drillrig_env/evaluation/provenance.py",
    "drillrig_env/evaluation/report.py",
)
"""Pictures and pages: they are looked at; and what only slow tests judge."""

_NO_JUDGES = ("test_page.py", "test_pictures.py", "test_rendering.py", "test_charts.py")
"""Tests of what is left alone; they say nothing of the rest of their room, and take long."""

_BESIDE = {
    "drillrig_env/env/draws.py": ("tests/env/test_scenario.py", "tests/env/test_varying.py"),
    "drillrig_env/env/info.py": ("tests/env/test_infos.py", "tests/env/test_varying.py"),
    "drillrig_env/env/kernel.py": ("tests/env/test_core.py", "tests/env/test_sensors.py", "tests/env/test_varying.py"),
    "drillrig_env/env/settings.py": ("tests/env/test_core.py",),
    "drillrig_env/env/starts.py": ("tests/env/test_core.py",),
    "drillrig_env/env/wandering.py": ("tests/env/test_varying.py",),
    "drillrig_env/env/reward.py": ("tests/env/test_core.py",),
    "drillrig_env/env/many.py": ("tests/env/test_state.py", "tests/env/test_copies.py"),
    "drillrig_env/env/one.py": ("tests/env/test_state.py", "tests/env/test_copies.py", "tests/env/test_setters.py"),
    "drillrig_env/env/registration.py": ("tests/env/test_vector.py",),
    "drillrig_env/env/sb3.py": ("tests/env/test_forms.py", "tests/env/test_vec_env.py"),
    "drillrig_env/env/single.py": ("tests/env/test_forms.py", "tests/env/test_bad_actions.py"),
    "drillrig_env/env/vector.py": ("tests/env/test_forms.py",),
    "drillrig_env/stability/bifurcation.py": ("tests/stability/test_orbits.py",),
    "drillrig_env/stability/limit_cycle.py": ("tests/stability/test_orbits.py",),
    "drillrig_env/stability/orbit.py": ("tests/stability/test_limit_cycle.py",),
    "drillrig_env/stepper/tables.py": ("tests/stepper/test_propagator.py",),
    "drillrig_env/stepper/collocation.py": ("tests/stepper/test_propagator.py",),
    "drillrig_env/stepper/along.py": ("tests/test_course.py", "tests/stepper/test_turning.py"),
    "drillrig_env/stepper/kinks.py": ("tests/stepper/test_propagator.py",),
    "drillrig_env/stepper/reach.py": ("tests/stepper/test_collocation.py", "tests/stepper/test_propagator.py"),
    "drillrig_env/stepper/settling.py": ("tests/stepper/test_propagator.py",),
    "drillrig_env/friction/friction.py": ("tests/test_friction.py",),
    "baselines/constant.py": ("tests/baselines/test_laws.py",),
    "baselines/feed_forward_start.py": ("tests/baselines/test_laws.py",),
    "baselines/jump_ease_estimated.py": ("tests/baselines/test_laws.py", "tests/baselines/test_jump_ease.py"),
    "baselines/mppi.py": ("tests/baselines/test_laws.py",),
    "baselines/soft_torque.py": ("tests/baselines/test_laws.py",),
    "baselines/speed_pulse.py": ("tests/baselines/test_laws.py",),
    "baselines/z_torque.py": ("tests/baselines/test_laws.py",),
}
"""Tests for a file that do not have its name."""


def files_of(room: str, root: Path) -> list[str]:
    """The files of a room that are mutated, relative to the `root` of the project."""
    found: list[Path] = []
    for source in ROOMS[room].sources:
        place = root / source
        found += sorted(place.rglob("*.py")) if place.is_dir() else [place] * place.exists()
    names = (path.relative_to(root).as_posix() for path in found)
    return [name for name in names if not name.startswith(_LEFT_ALONE)]


def stages_of(file: str, room: str, root: Path) -> list[list[str]]:
    """The tests that a file has to pass: first its own, by its name and by _BESIDE; then all others of its room."""
    shared: list[Path] = []
    for test in ROOMS[room].tests:
        place = root / test
        shared += sorted(place.rglob("test_*.py")) if place.is_dir() else [place] * place.exists()
    names = [path.relative_to(root).as_posix() for path in shared if path.name not in _NO_JUDGES]
    stem = Path(file).stem
    own = [name for name in names if Path(name).name in (f"test_{stem}.py", f"test_{stem}s.py")]
    own += [name for name in _BESIDE.get(file, ()) if name in names and name not in own]
    return [stage for stage in (own, [name for name in names if name not in own]) if stage]
