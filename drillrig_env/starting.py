"""A stop while a command still imports what it needs, and what is not installed: a line, a code and no traceback.

Imports take seconds, and in them nothing is there yet that has to be kept. Where they end, a command says for itself
how it stops (`drillrig_env.command_line.command`).
"""

from __future__ import annotations

import os
import signal
import sys
import threading
from types import FrameType, TracebackType
from typing import Any

from drillrig_env.extras import advice

_PACKAGES = ("drillrig_env", "baselines", "agents", "benchmarks", "docs")
_STOPS = {signal.SIGINT: (b"stopped by Ctrl-C\n", 130), signal.SIGTERM: (b"stopped by SIGTERM\n", 143)}
_earlier: dict[signal.Signals, Any] = {}


def imports_begin() -> None:
    """From here on Ctrl-C and SIGTERM end the process at once, until `imports_end`; ignored ones stay ignored.

    Where a package of an extra is not installed, a line says how to get it.
    """
    if threading.current_thread() is not threading.main_thread():
        return
    for number, normal in ((signal.SIGINT, signal.default_int_handler), (signal.SIGTERM, signal.SIG_DFL)):
        if signal.getsignal(number) == normal:
            _earlier[number] = signal.signal(number, _end)
    sys.excepthook = _tell


def imports_end() -> None:
    """Ctrl-C, SIGTERM and errors do again what they did before; without `imports_begin` nothing changes."""
    if sys.excepthook is _tell:
        sys.excepthook = sys.__excepthook__
    while _earlier:
        signal.signal(*_earlier.popitem())


def is_command() -> bool:
    """Whether this process was started as `python -m` with a module of the project."""
    spec = getattr(sys.modules["__main__"], "__spec__", None)
    if spec is not None:
        name = str(spec.name)
    elif sys.argv[:1] == ["-m"]:  # Python still looks for the module, and imports the packages that it is in
        name = sys.orig_argv[sys.orig_argv.index("-m") + 1] if "-m" in sys.orig_argv else ""
    else:
        return False
    return name.partition(".")[0] in _PACKAGES


def _end(number: int, _frame: FrameType | None) -> None:
    words, code = _STOPS[signal.Signals(number)]
    os.write(2, words)
    os._exit(code)


def _tell(kind: type[BaseException], error: BaseException, trace: TracebackType | None) -> None:
    told = advice(error) if isinstance(error, ImportError) else None
    if told is None:
        sys.__excepthook__(kind, error, trace)
    else:
        print(f"error: {told}", file=sys.stderr)
