"""How the package compiles its hot paths: one decorator, cached on disk, safe to edit."""

from __future__ import annotations

from collections.abc import Callable
from functools import partial
from typing import Any, Literal, TypeVar

import numba

from drillrig_env.jit.announcement import announce_compilation
from drillrig_env.jit.cache import cached

if numba.config.DISABLE_JIT:  # type: ignore[attr-defined]
    raise ImportError(
        "NUMBA_DISABLE_JIT is set, and drillrig_env cannot run without compiled kernels: they work on vectors of the "
        "processor, which Python has not; unset it"
    )

F = TypeVar("F", bound=Callable[..., Any])
T = TypeVar("T")


def compiled(function: F) -> F:
    """Compile `function` with Numba: IEEE arithmetic, no GIL, machine code cached on disk.

    No fast-math flag is set: the same inputs give the same bits from whichever kernel a
    function is called. `drillrig_env.jit.stamp` says when a cached kernel is renewed.
    """
    return _compile(function, inline="never")


def inlined(function: F) -> F:
    """Like `compiled`, for small functions on the hot path: their body becomes part of the caller."""
    return _compile(function, inline="always")


def bound(kernel: Callable[..., T], *arguments: Any) -> Callable[[], T]:
    """A call of a compiled kernel on these very arrays, again and again.

    Numba looks up the types of all arguments at each call: for ten arrays longer than one rig takes for a
    control step. Here it does so once.
    """
    dispatcher: Any = kernel
    typeof: Any = numba.typeof
    signature = tuple(typeof(argument) for argument in arguments)
    dispatcher.compile(signature)
    return partial(dispatcher.overloads[signature].entry_point, *arguments)


def _compile(function: F, inline: Literal["never", "always"]) -> F:
    def compiler(cache: bool) -> Any:
        return numba.njit(cache=cache, nogil=True, error_model="numpy", inline=inline)(function)

    return cached(compiler, function.__code__.co_filename)  # type: ignore[no-any-return]


announce_compilation(__name__.partition(".")[0])
