"""Start-up: seconds until a fresh process has imported the package, stepped an environment, simulated a rig.

    python -m benchmarks.startup
    python -m benchmarks.startup --quick

Every figure is the median of fresh processes, from before the import to after the result, without Python's own
start. Each install is a copy of the package in an empty folder, whose kernels are compiled by the first process and
read from a cache by those after it:

- fresh install: the first process after it, with nothing compiled yet; and the processes after that;
- read-only install: nobody may write to the folder, so that Numba keeps its cache in the user's own folder;
- read-only, no home: nor is there a folder of the user's own to write to.

Root may write anywhere; run by root, the read-only cases drop that power with `setpriv`, and are left out without it.
"""

from __future__ import annotations

import os
import shutil
import statistics
import subprocess
import sys
import tempfile
from collections.abc import Iterator, Mapping, Sequence
from contextlib import contextmanager
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import drillrig_env
from benchmarks.measure import kept, note, print_table, write_json
from drillrig_env.allowed import COUNT
from drillrig_env.command_line import Parser, command
from drillrig_env.flags import of_kind

TIMED = """
import time
begin = time.perf_counter()
{statements}
print(time.perf_counter() - begin)
"""
STEP = "env = gym.make('DrillRig-v0'); env.reset(seed=0); env.step(env.action_space.sample())"
TASKS = {
    "import gymnasium": "import gymnasium",
    "import drillrig_env": "import drillrig_env",
    "import, first env step": f"import gymnasium as gym; import drillrig_env; {STEP}",
    "import, first simulate": "import drillrig_env; drillrig_env.simulate(duration=20.0)",
}
"""What a fresh process does, by name."""

COMPILING = ("import, first env step", "import, first simulate")
"""The tasks that compile when nothing is compiled yet."""

CASES: dict[str, dict[str, bool]] = {
    "fresh install": {},
    "read-only install": {"writable": False},
    "read-only install, no home": {"writable": False, "home": False},
}
"""What `installed` is asked for, by name."""

_TIMEOUT = 600.0  # s
_NO_POWER = ("setpriv", "--bounding-set=-dac_override,-dac_read_search,-fowner")


@dataclass(frozen=True)
class Install:
    """A copy of the package: its folder, the environment variables and the prefix of the commands that use it."""

    folder: Path
    variables: Mapping[str, str]
    prefix: tuple[str, ...] = ()

    def seconds(self, task: str) -> float:
        """Seconds that a fresh process needs for a task. `RuntimeError` with its last words where it fails."""
        command = [*self.prefix, sys.executable, "-c", TIMED.format(statements=TASKS[task])]
        done = subprocess.run(
            command, cwd=self.folder, env=dict(self.variables), capture_output=True, text=True, timeout=_TIMEOUT
        )
        if done.returncode != 0:
            raise RuntimeError(done.stderr.strip().splitlines()[-1].replace(str(self.folder), "..."))
        return float(done.stdout)


@contextmanager
def installed(writable: bool = True, home: bool = True) -> Iterator[Install]:
    """A fresh copy of the package with nothing compiled, and a home of its own, which can be written to or not."""
    with tempfile.TemporaryDirectory(ignore_cleanup_errors=True) as name:
        folder, own = Path(name, "packages"), Path(name, "home")
        own.mkdir()
        package = Path(drillrig_env.__file__).parent
        shutil.copytree(package, folder / package.name, ignore=shutil.ignore_patterns("__pycache__"))
        variables = {**os.environ, "HOME": str(own), "PYTHONPATH": str(folder)}
        for kept in ("NUMBA_CACHE_DIR", "XDG_CACHE_HOME", "PYTHONPYCACHEPREFIX"):
            variables.pop(kept, None)
        locked = [*([] if writable else [folder]), *([] if home else [own])]
        for top in locked:
            _set_mode(top, 0o555, 0o444)
        try:
            yield Install(folder, variables, _NO_POWER if locked and _is_root() else ())
        finally:
            for top in locked:
                _set_mode(top, 0o755, 0o644)


def _set_mode(top: Path, folders: int, files: int) -> None:
    for path in (top, *top.rglob("*")):
        path.chmod(folders if path.is_dir() else files)


def _is_root() -> bool:
    return hasattr(os, "geteuid") and os.geteuid() == 0


def why_not_read_only() -> str | None:
    """Why a folder cannot be made read-only for a process here; `None` where it can."""
    if os.name != "posix":
        return "the read-only cases are left out; they need a POSIX system"
    if _is_root() and shutil.which(_NO_POWER[0]) is None:
        return "the read-only cases are left out: root may write anywhere; run as a user, or install util-linux"
    return None


def measure(case: str, repeats: int, installs: int) -> Iterator[tuple[str, str, float]]:
    """Process ("first" or "later"), task and seconds of one fresh process after another. `RuntimeError` if one fails.

    "first": nothing had been compiled in this install; "later": everything had.
    """
    for number in range(installs):
        for task in COMPILING:
            with installed(**CASES[case]) as install:
                yield "first", task, install.seconds(task)
                if number == 0 and task == COMPILING[-1]:
                    yield from _later(install, repeats)


def _later(install: Install, repeats: int) -> Iterator[tuple[str, str, float]]:
    for task in COMPILING:
        install.seconds(task)
    for _ in range(repeats):
        for task in TASKS:
            yield "later", task, install.seconds(task)


def summary(runs: Mapping[str, Mapping[str, Sequence[float]]]) -> dict[str, Any]:
    """Median seconds beside the runs, by process and task."""
    return {
        process: {task: {"seconds": statistics.median(all_), "runs": list(all_)} for task, all_ in tasks.items()}
        for process, tasks in runs.items()
    }


def tabulate(cases: Mapping[str, Any]) -> None:
    """Print a row a case and kind of process, a column a task."""
    rows = []
    for case, found in cases.items():
        for process in ("first", "later"):
            tasks = found.get(process, {})
            cells = [f"{tasks[task]['seconds']:.2f}" if task in tasks else "-" for task in TASKS]
            if tasks:
                rows.append([case, f"{process} process{'es' if process == 'later' else ''}", *cells])
        if "fails" in found:
            rows.append([case, f"fails: {found['fails']}", *["-" for _ in TASKS]])
    print_table(["install", "process", *(f"{task}, s" for task in TASKS)], rows)


@command
def main(arguments: Sequence[str] | None = None) -> None:
    """Measure, write the figures after each of them, and print the table."""
    parser = Parser(prog="python -m benchmarks.startup", description=__doc__)
    parser.add_argument(
        "--repeats", type=of_kind(COUNT), help="later processes, whose median counts (default: 5; quick: 1)"
    )
    parser.add_argument(
        "--installs", type=of_kind(COUNT), help="fresh installs, whose median counts (default: 2; quick: 1)"
    )
    parser.add_argument("--quick", action="store_true", help="a first look: the fresh install alone, once")
    parser.add_argument("--json", type=Path, default=Path("results/benchmarks/startup.json"), help="where to write")
    chosen = parser.parse_args(arguments)
    repeats = chosen.repeats or (1 if chosen.quick else 5)
    installs = chosen.installs or (1 if chosen.quick else 2)
    wanted = list(CASES)[: 1 if chosen.quick else None]
    if len(wanted) > 1 and (hint := why_not_read_only()):
        note(hint)
        wanted = wanted[:1]
    results: dict[str, Any] = {
        "quick": chosen.quick,
        "repeats": repeats,
        "installs": installs,
        "tasks": TASKS,
        "cases": {},
    }

    def tell() -> None:
        tabulate(results["cases"])
        write_json(chosen.json, results)

    with kept(chosen.json, tell):
        for case in wanted:
            runs: dict[str, dict[str, list[float]]] = {}
            try:
                for process, task, seconds in measure(case, repeats, installs):
                    note(f"{case}, {process} process: {task}: {seconds:.2f} s")
                    runs.setdefault(process, {}).setdefault(task, []).append(seconds)
                    results["cases"][case] = summary(runs)
                    write_json(chosen.json, results, announce=False)
            except RuntimeError as error:
                note(f"{case}: fails: {error}")
                results["cases"].setdefault(case, {})["fails"] = str(error)
                write_json(chosen.json, results, announce=False)


if __name__ == "__main__":
    raise SystemExit(main())
