"""A bench on which mutants are tried: a copy of the project, with compiled kernels of its own.

Kernels are kept in a cache of the bench, filled by the tests of the unchanged project. Each mutant gets it anew as
hard links, which Numba replaces and never writes into. So a mutant renews just the kernels that stand on the file
it changes, once for all of its tests, and the next one finds nothing of it.
"""

from __future__ import annotations

import os
import re
import shutil
import signal
import subprocess
import sys
from collections.abc import Callable
from contextlib import suppress
from dataclasses import dataclass
from pathlib import Path
from time import perf_counter

from tests.mutants.mutation import Mutant

try:
    import resource
except ImportError:  # Windows
    resource = None  # type: ignore[assignment]

_COMPILATION = 120.0
"""What a mutant may take beyond five times the unchanged project's time, s: kernels are compiled anew."""

_MEMORY = 8 << 30
"""What a mutant's tests may take, bytes, where the system can hold them to it."""

_FAILED = re.compile(r"^(?:FAILED|ERROR) (\S+)", re.MULTILINE)


@dataclass(frozen=True)
class Outcome:
    """What became of a mutant: the test that failed ("time" where the limit was passed), or None."""

    killed_by: str | None
    seconds: float


class Bench:
    """A copy of the project below `root`, kept in `folder` with its kernels; `say` is told what takes long."""

    def __init__(self, root: Path, folder: Path, say: Callable[[str], None] = lambda _: None) -> None:
        self.tree = folder / "tree"
        self._kept, self._cache = folder / "kernels", folder / "cache"
        self._say = say
        self._times: dict[str, float] = {}
        self._process: subprocess.Popen[str] | None = None
        self._stopped = False
        shutil.rmtree(self.tree, ignore_errors=True)
        for name in _files_below(root):
            copy = self.tree / name
            copy.parent.mkdir(parents=True, exist_ok=True)
            shutil.copy2(root / name, copy)

    def try_out(self, mutant: Mutant, stages: list[list[str]]) -> Outcome:
        """Run the tests on a mutant, stage by stage and short ones first, until one fails or takes too long.

        `ValueError` where a test fails without any mutant.
        """
        start = perf_counter()
        shutil.rmtree(self._cache, ignore_errors=True)
        for tests in stages:
            times = {test: self._time_of(test) for test in tests}
            limit = 5.0 * sum(times.values()) + _COMPILATION
            status, output = self._mutated(mutant, sorted(tests, key=times.__getitem__), limit)
            if status != 0:
                failed = _FAILED.search(output)
                by = "time" if status is None else failed[1] if failed else f"exit status {status}"
                return Outcome(by, perf_counter() - start)
        return Outcome(None, perf_counter() - start)

    def stop(self) -> None:
        """End the tests that run, with all that they have begun, and run no more."""
        self._stopped = True
        if (process := self._process) is not None:
            _end(process)

    def _time_of(self, test: str) -> float:
        """Time (s) that a file of tests takes on the unchanged project, once its kernels are compiled."""
        while test not in self._times and not self._stopped:
            before, start = self._kernels(), perf_counter()
            status, output = self._run([test], self._kept, None)
            if status != 0 and not self._stopped:
                raise ValueError(f"{test} fails without any mutant:\n{output[-2000:]}")
            seconds = perf_counter() - start
            if self._kernels() == before:
                self._times[test] = seconds
            else:
                self._say(f"compiled the kernels of {test}, {seconds:.0f} s")
        return self._times.get(test, 0.0)

    def _kernels(self) -> set[tuple[Path, int]]:
        return {(path, path.stat().st_mtime_ns) for path in self._kept.rglob("*.nb?")}

    def _mutated(self, mutant: Mutant, tests: list[str], limit: float) -> tuple[int | None, str]:
        file = self.tree / mutant.file
        source, times = file.read_bytes(), file.stat()
        if self._kept.exists():
            shutil.copytree(self._kept, self._cache, copy_function=_link, dirs_exist_ok=True)
        try:
            file.write_bytes(mutant.applied_to(source))
            for compiled in file.parent.glob(f"__pycache__/{file.stem}.*"):
                compiled.unlink()
            return self._run(tests, self._cache, limit)
        finally:
            file.write_bytes(source)
            os.utime(file, ns=(times.st_atime_ns, times.st_mtime_ns))

    def _run(self, tests: list[str], cache: Path, limit: float | None) -> tuple[int | None, str]:
        """Exit status (None: out of time, or stopped) and output of pytest, which ends at the first failure."""
        if self._stopped:
            return None, ""
        options = ["-x", "-q", "--no-header", "--tb=no", "-rfE", "-p", "no:cacheprovider"]
        variables = {"PYTHONPATH": str(self.tree), "NUMBA_CACHE_DIR": str(cache), "OMP_NUM_THREADS": "1"}
        if cache == self._cache:
            variables["PYTHONDONTWRITEBYTECODE"] = "1"
        process = self._process = subprocess.Popen(
            [sys.executable, "-m", "pytest", *options, *tests],
            cwd=self.tree,
            env={**os.environ, **variables},
            stdout=subprocess.PIPE,
            stderr=subprocess.STDOUT,
            text=True,
            start_new_session=True,
            preexec_fn=_limit_memory if resource else None,
        )
        try:
            output, _ = process.communicate(timeout=limit)
        except subprocess.TimeoutExpired:
            _end(process)
            process.communicate()
            return None, ""
        finally:
            self._process = None
        return process.returncode, output


def _link(source: str, target: str) -> None:
    """A hard link, where there is nothing yet: what a mutant has renewed stays."""
    with suppress(FileExistsError):
        os.link(source, target)


def _limit_memory() -> None:
    """In the child: a mutant that takes memory without end must not take the machine's."""
    assert resource is not None
    resource.setrlimit(resource.RLIMIT_DATA, (_MEMORY, _MEMORY))


def _end(process: subprocess.Popen[str]) -> None:
    """End a process with its children, which are a group of their own."""
    if process.poll() is None:
        with suppress(ProcessLookupError, PermissionError):
            os.killpg(process.pid, signal.SIGKILL) if hasattr(os, "killpg") else process.kill()


def _files_below(root: Path) -> list[str]:
    """The project's files: what Git keeps or would keep; everything where there is no Git."""
    command = ["git", "ls-files", "-z", "--cached", "--others", "--exclude-standard"]
    listed = subprocess.run(command, cwd=root, capture_output=True, check=False, text=True)
    names = listed.stdout.split("\0") if listed.returncode == 0 else [str(p.relative_to(root)) for p in root.rglob("*")]
    return [name for name in names if (root / name).is_file()]
