"""A control room of one's own in a process of its own, and Debian's Chromium without a window to look at it."""

from __future__ import annotations

import os
import re
import shutil
import signal
import subprocess
import sys
from collections.abc import Iterator, Sequence
from contextlib import contextmanager
from pathlib import Path
from typing import Any

from drillrig_env.command_line import Failed

ROOT = Path(__file__).parents[1]

_NAMES = ("chromium", "chromium-browser", "google-chrome")
_PATIENCE = 10.0  # s, until a server has ended


class Room:
    """A server that runs; `address` is where, `process` what."""

    def __init__(self, words: Sequence[str]) -> None:
        line = [sys.executable, "-m", "drillrig_env.cli", "room", "--no-browser", *words]
        settings = {**os.environ, "PYTHONPATH": str(ROOT), "PYTHONUNBUFFERED": "1"}
        self.process = subprocess.Popen(line, cwd=ROOT, env=settings, stdout=subprocess.PIPE, text=True)
        assert self.process.stdout is not None
        told = self.process.stdout.readline()
        found = re.search(r"http://\S+", told)
        if found is None:
            self.close()
            raise Failed(f"`{' '.join(line)}` did not say where it listens, but: {told!r}")
        self.address = found[0].rstrip("/")

    def close(self) -> int:
        """End it as Ctrl-C does; its exit code."""
        if self.process.poll() is None:
            self.process.send_signal(signal.SIGINT)
        try:
            return self.process.wait(_PATIENCE)
        except subprocess.TimeoutExpired:
            self.process.kill()
            return self.process.wait()
        finally:
            assert self.process.stdout is not None
            self.process.stdout.close()


@contextmanager
def room(*words: str) -> Iterator[Room]:
    """A server with these words behind `drillrig room`, on a free port unless they say which."""
    served = Room(words if "--port" in words else ("--port", "0", *words))
    try:
        yield served
    finally:
        served.close()


@contextmanager
def chromium() -> Iterator[Any]:
    """A browser of Playwright. `Failed` where there is no Chromium, or no Playwright."""
    where = next((found for name in _NAMES if (found := shutil.which(name))), None)
    if where is None:
        raise Failed("a browser needs Chromium: `apt-get install chromium`")
    try:
        from playwright.sync_api import sync_playwright
    except ImportError as error:
        raise Failed("a browser needs Playwright: pip install -e '.[room-test]'") from error
    with sync_playwright() as playwright:
        browser = playwright.chromium.launch(executable_path=where, args=["--no-sandbox"])
        try:
            yield browser
        finally:
            browser.close()


def is_drawn(page: Any, time: float = 0.0) -> None:
    """Wait until a page has drawn its run up to a time (s)."""
    page.wait_for_function(
        "time => Number(document.body.dataset.drawn) > 0 "
        "&& parseFloat(document.getElementById('time').textContent) >= time",
        arg=time,
        timeout=120_000,
    )
