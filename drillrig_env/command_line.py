"""What every command has in common: its parser, how it ends, and its exit code.

| code | means |
|---:|---|
| 0 | done |
| 1 | something failed: a policy, a training, a computation, a file that could not be written; one sentence says what |
| 2 | the arguments are not allowed; one sentence says why, and nothing was done |
| 130 | stopped by Ctrl-C (SIGINT) before the end; what was finished is kept |
| 143 | stopped by SIGTERM before the end; what was finished is kept |
"""

from __future__ import annotations

import argparse
import difflib
import os
import signal
import sys
import threading
from collections.abc import Callable, Iterator, Sequence
from contextlib import contextmanager
from functools import wraps
from typing import Any, NoReturn, ParamSpec

from drillrig_env.parameters import closest
from drillrig_env.starting import imports_end

DONE, FAILED, BAD_ARGUMENTS, INTERRUPTED, TERMINATED = 0, 1, 2, 130, 143

P = ParamSpec("P")


class Terminated(KeyboardInterrupt):
    """SIGTERM has come. It passes through code as Ctrl-C does, and ends with an exit code of its own."""


class Failed(RuntimeError):  # noqa: N818  # no mistake of the program
    """What was asked for was allowed and could not be done; the sentence and its notes say all that there is to say."""


class Parser(argparse.ArgumentParser):
    """A parser whose errors are one sentence, without the usage above it, and that takes no flag cut short."""

    def __init__(self, *args: Any, **settings: Any) -> None:
        settings = {"formatter_class": argparse.RawDescriptionHelpFormatter, "allow_abbrev": False, **settings}
        super().__init__(*args, **settings)

    def error(self, message: str | Exception) -> NoReturn:
        """End with code 2 and a sentence that says what is not allowed, or what the error says."""
        said = message if isinstance(message, str) else sentence_of(message)
        self.exit(BAD_ARGUMENTS, f"{self.prog}: error: {said}\nhelp: {self.prog} --help\n")

    def parse_args(self, args: Sequence[str] | None = None, namespace: Any = None) -> Any:  # type: ignore[override]
        """The arguments; an unknown flag ends with code 2 and the closest known one."""
        if self._subparsers is None:
            words = sys.argv[1:] if args is None else list(args)
            for word in words[: words.index("--") if "--" in words else None]:
                self._check_flag(word.partition("=")[0])
        return super().parse_args(args, namespace)

    def _check_flag(self, flag: str) -> None:
        if flag.startswith("--") and flag not in self._option_string_actions:
            close = difflib.get_close_matches(flag, self._option_string_actions, n=1)
            self.error(f"unknown argument {flag}" + "".join(f"; did you mean {one}?" for one in close))

    def _check_value(self, action: argparse.Action, value: Any) -> None:
        """Refuse what is not among an argument's choices, with the closest of them."""
        if action.choices is not None and value not in action.choices:
            raise argparse.ArgumentError(action, f"{value!r} is not known; {closest(str(value), action.choices)}")


def sentence_of(error: Exception) -> str:
    """What an error says, that of a file without its number: "my.csv: no such file or directory"."""
    if isinstance(error, OSError) and error.strerror and error.filename is not None:
        return f"{os.fspath(error.filename)}: {error.strerror.lower()}"
    return str(error) or type(error).__name__


def command(main: Callable[P, int | None]) -> Callable[P, int]:
    """`main` with the exit codes of every command: Ctrl-C, SIGTERM and what fails end in one line.

    What fails is `Failed`, a file, a rig beyond what can be computed, and memory that is too small.

    What a stop or a failure keeps, and how to go on, `main` adds as a note to the exception that it lets pass:

        except KeyboardInterrupt as stop:
            stop.add_note(f"to go on: python train.py --resume {folder}")
            raise
    """

    @wraps(main)
    def run(*args: P.args, **settings: P.kwargs) -> int:
        imports_end()
        try:
            with sigterm_as_exception():
                return main(*args, **settings) or DONE
        except KeyboardInterrupt as stop:
            terminated = isinstance(stop, Terminated)
            _say("; ".join([f"stopped by {'SIGTERM' if terminated else 'Ctrl-C'}", *getattr(stop, "__notes__", ())]))
            return TERMINATED if terminated else INTERRUPTED
        except BrokenPipeError:  # nobody reads on, as in `... | head`
            os.dup2(os.open(os.devnull, os.O_WRONLY), sys.stdout.fileno())
            return FAILED
        except (OSError, Failed, FloatingPointError, MemoryError) as error:
            _say("; ".join([f"error: {sentence_of(error)}", *getattr(error, "__notes__", ())]))
            return FAILED

    return run


@contextmanager
def sigterm_as_exception() -> Iterator[None]:
    """While the block runs in the main thread, SIGTERM raises `Terminated` there."""
    with _handled(signal.SIGTERM, _terminate):
        yield


@contextmanager
def interrupt_as_exception() -> Iterator[None]:
    """While the block runs in the main thread, SIGINT raises `KeyboardInterrupt`, also where it was ignored before.

    A shell has what it starts in the background ignore it.
    """
    with _handled(signal.SIGINT, signal.default_int_handler):
        yield


@contextmanager
def _handled(number: signal.Signals, handler: Any) -> Iterator[None]:
    if threading.current_thread() is not threading.main_thread():
        yield
        return
    earlier = signal.signal(number, handler)
    try:
        yield
    finally:
        signal.signal(number, signal.SIG_DFL if earlier is None else earlier)


@contextmanager
def deaf_to_interrupt() -> Iterator[None]:
    """Let a process that is started here be deaf to Ctrl-C from its first moment: that is the parent's to answer.

    It inherits what this thread does not hear. A Ctrl-C in the meantime reaches the parent when the block ends.
    """
    if not hasattr(signal, "pthread_sigmask"):  # Windows
        yield
        return
    earlier = signal.pthread_sigmask(signal.SIG_BLOCK, {signal.SIGINT})
    try:
        yield
    finally:
        signal.pthread_sigmask(signal.SIG_SETMASK, earlier)


def _terminate(_number: int, _frame: object) -> None:
    raise Terminated


def _say(line: str) -> None:
    print(line, file=sys.stderr, flush=True)
