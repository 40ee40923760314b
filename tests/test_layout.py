"""The layout of the house: imports point down, from applications to ground, and never up."""

import ast
from pathlib import Path

import pytest

ROOT = Path(__file__).parents[1]

FLOORS = [
    [
        "arrays",
        "lumps",
        "allowed",
        "parameters",
        "toml",
        "files",
        "seeds",
        "markdown",
        "command_line",
        "extras",
        "progress",
        "starting",
        "lazy",
        "moved",
        "modules",
        "jit",
        "engine",
    ],
    ["rig", "course"],
    ["drive", "friction", "slowest_mode"],
    ["flags", "scales"],
    ["model"],
    ["reference", "fleet", "inputs"],
    ["stepper"],
    ["simulation", "verdict", "indicators"],
    ["policy"],
    ["stability"],
    ["env"],
    ["plots"],
    ["evaluation"],
    ["calibrate", "validation"],
    ["deploy"],
    ["twin"],
    ["room"],
    ["cli"],
]
"""The rooms of `drillrig_env` from the ground up; those of one floor may not import each other, but for the ground."""

BUILDINGS = ["drillrig_env", "baselines", "agents", "benchmarks", "docs"]
"""Packages from the ground up."""

FLOOR = {room: floor for floor, rooms in enumerate(FLOORS) for room in rooms}


def modules(building):
    return sorted(path for path in (ROOT / building).rglob("*.py"))


def imports(path):
    """The project's own modules that a file imports, anywhere in it, with the line."""
    for node in ast.walk(ast.parse(path.read_text(encoding="utf-8"))):
        if isinstance(node, ast.Import):
            found = [alias.name for alias in node.names]
        elif isinstance(node, ast.ImportFrom):
            found = [node.module or ""]
            if node.module in BUILDINGS:
                found = [f"{node.module}.{alias.name}" for alias in node.names]
        else:
            continue
        for name in found:
            if name.split(".")[0] in BUILDINGS:
                yield node.lineno, name


@pytest.mark.parametrize("building", BUILDINGS)
def test_packages_import_only_those_below(building):
    allowed = BUILDINGS[: BUILDINGS.index(building) + 1]
    wrong = [
        f"{path.relative_to(ROOT)}:{line} imports {name}"
        for path in modules(building)
        for line, name in imports(path)
        if name.split(".")[0] not in allowed
    ]
    assert not wrong, "\n".join(wrong)


def test_rooms_import_only_those_below():
    wrong = []
    for path in modules("drillrig_env"):
        inside = path.relative_to(ROOT / "drillrig_env")
        room = inside.parts[0].removesuffix(".py")
        if room in ("__init__", "__main__"):
            continue
        assert room in FLOOR, f"{inside} is in no room of the house"
        for line, name in imports(path):
            other = name.split(".")[1] if "." in name else ""
            if room == "cli" and name == "drillrig_env":  # the public names, which stand on all rooms but the commands
                continue
            if other == room or (FLOOR.get(other) == FLOOR[room] == 0):
                continue
            if other not in FLOOR or FLOOR[other] >= FLOOR[room]:
                wrong.append(f"drillrig_env/{inside}:{line} imports {name}")
    assert not wrong, "\n".join(wrong)


def test_an_arrow_up_is_seen(tmp_path):
    file = tmp_path / "one.py"
    file.write_text("def late():\n    from drillrig_env.env import core\n    from drillrig_env import simulate\n")
    assert list(imports(file)) == [(2, "drillrig_env.env"), (3, "drillrig_env.simulate")]
