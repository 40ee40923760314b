"""How the package compiles its hot paths: one decorator, cached on disk, safe to edit."""

from __future__ import annotations

import inspect
from collections.abc import Callable, Hashable
from functools import partial
from typing import Any, Literal, TypeVar

import numba
import numpy as np

from drillrig_env.jit.announcement import announce_compilation
from drillrig_env.jit.cache import cached

if numba.config.DISABLE_JIT:  # type: ignore[attr-defined]
    raise ImportError(
        "NUMBA_DISABLE_JIT is set, and drillrig_env cannot run without compiled kernels: they work on vectors of the "
        "processor, which Python has not; unset it"
    )

F = TypeVar("F", bound=Callable[..., Any])
T = TypeVar("T")


NOT_COMPILED: tuple[type[Exception], ...] = (
    numba.core.errors.NumbaError,
    numba.core.errors.UnsupportedBytecodeError,
)
"""What Numba raises for a function that it cannot compile."""


def compiled(function: F) -> F:
    """Compile `function` with Numba: IEEE arithmetic, no GIL, machine code cached on disk.

    No fast-math flag is set: the same inputs give the same bits from whichever kernel a
    function is called. `drillrig_env.jit.stamp` says when a cached kernel is renewed.
    """
    return _compile(function, inline="never")


def inlined(function: F) -> F:
    """Like `compiled`, for small functions on the hot path: their body becomes part of the caller."""
    return _compile(function, inline="always")


def is_compilable(function: object) -> bool:
    """Whether this is a function of Python's, or one that is compiled already; Numba takes no other callable."""
    return inspect.isfunction(function) or hasattr(function, "py_func")


def reason_of(error: Exception) -> str:
    """What a function cannot be compiled for, in a line, from the many that Numba has around it."""
    lines = (line.strip() for line in str(error).splitlines())
    return next((line for line in lines if line and not line.startswith(("Failed in ", "During: "))), str(error))


_ENTRY_POINTS: dict[Hashable, Callable[..., Any]] = {}
"""Compiled code by kernel and kinds of its arguments."""


def bound(kernel: Callable[..., T], *arguments: np.ndarray) -> Callable[[], T]:
    """A call of a compiled kernel on these very arrays, again and again.

    Numba looks up the types of all arguments at each call: for ten arrays longer than one rig takes for a
    control step. Here it does so once, and not again for other arrays of the same kinds.
    """
    kinds = (kernel, *((array.dtype, array.ndim, *_flags(array)) for array in arguments))
    if kinds not in _ENTRY_POINTS:
        dispatcher: Any = kernel
        typeof: Any = numba.typeof
        signature = tuple(typeof(argument) for argument in arguments)
        dispatcher.compile(signature)
        _ENTRY_POINTS[kinds] = dispatcher.overloads[signature].entry_point
    return partial(_ENTRY_POINTS[kinds], *arguments)


def _flags(array: np.ndarray) -> tuple[bool, ...]:
    """What Numba tells arrays of one dtype and number of dimensions apart by."""
    flags = array.flags
    return flags.c_contiguous, flags.f_contiguous, flags.aligned, flags.writeable


def _compile(function: F, inline: Literal["never", "always"]) -> F:
    def compiler(cache: bool) -> Any:
        return numba.njit(cache=cache, nogil=True, error_model="numpy", inline=inline)(function)

    return cached(compiler, function.__code__.co_filename)  # type: ignore[no-any-return]


announce_compilation(__name__.partition(".")[0])
