"""Run the fast tests with the lowest versions of every dependency that pyproject.toml allows, and with the newest.

    python -m tests.bounds                        # both
    python -m tests.bounds lowest tests/env       # one of them, and only some tests

Each gets an environment of its own under .bounds/, made with uv (from the extra `dev`). PyTorch stays at the version of
constraints.txt in both: its oldest wheels are gigabytes, and what is used of it has not changed since.
"""

from __future__ import annotations

import argparse
import os
import re
import subprocess
import sys
from collections.abc import Sequence
from pathlib import Path

ROOT = Path(__file__).parents[1]
RESOLUTIONS = {"lowest": "lowest-direct", "newest": "highest"}
EXTRAS = "agents,export,plot,posterior,records,render,room"


def main(arguments: Sequence[str] | None = None) -> int:
    """Make the environments and run the tests in each; 1 where one of them fails."""
    parser = argparse.ArgumentParser(
        prog="python -m tests.bounds", description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter
    )
    parser.add_argument("which", nargs="?", choices=list(RESOLUTIONS), help="default: both")
    parser.add_argument("tests", nargs="*", default=["tests"], help="what pytest runs (default: all fast tests)")
    options = parser.parse_args(arguments)
    failed = []
    for name in [options.which] if options.which else RESOLUTIONS:
        python = environment(name)
        print(f"{name}: {versions(python)}", flush=True)
        settings = {**os.environ, "PYTHONPATH": str(ROOT), "NUMBA_CACHE_DIR": str(ROOT / ".bounds" / f"{name}-kernels")}
        if subprocess.run([python, "-m", "pytest", "-n", "2", "-q", *options.tests], cwd=ROOT, env=settings).returncode:
            failed.append(name)
    print(f"failed: {', '.join(failed)}" if failed else "passed")
    return 1 if failed else 0


def environment(name: str) -> Path:
    """The Python of an environment with the project and its dependencies at one end of what is allowed."""
    folder = ROOT / ".bounds" / name
    python = folder / ("Scripts/python.exe" if sys.platform == "win32" else "bin/python")
    if not python.exists():
        uv("venv", "--python", sys.executable, folder)
    kept = ROOT / ".bounds" / "kept.txt"
    kept.write_text(torch_of_constraints(), encoding="utf-8")
    install = ("pip", "install", "--python", python)
    uv(*install, "--resolution", RESOLUTIONS[name], "--override", kept, "--upgrade", "--editable", f"{ROOT}[{EXTRAS}]")
    uv(*install, "pytest>=8", "pytest-xdist", "mpmath", "httpx2")
    return python


def torch_of_constraints() -> str:
    """The line of constraints.txt that says which PyTorch is tested."""
    found = re.search(r"^torch==.*$", (ROOT / "constraints.txt").read_text(encoding="utf-8"), re.MULTILINE)
    assert found, "constraints.txt has no torch"
    return found[0] + "\n"


def versions(python: Path) -> str:
    """The versions that decide, as one line."""
    code = (
        "from importlib.metadata import version\n"
        "print(*(f'{name} {version(name)}' for name in ('gymnasium', 'numpy', 'scipy', 'numba')), sep=', ')"
    )
    return subprocess.run([python, "-c", code], capture_output=True, text=True, check=True).stdout.strip()


def uv(*words: str | Path) -> None:
    """Run uv quietly; what it says of an error is shown."""
    subprocess.run([sys.executable, "-m", "uv", "--quiet", *map(str, words)], check=True)


if __name__ == "__main__":
    sys.exit(main())
