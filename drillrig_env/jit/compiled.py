"""How the package compiles its hot paths: one decorator, cached on disk, safe to edit."""

from __future__ import annotations

import warnings
from collections.abc import Callable
from functools import lru_cache, partial
from typing import Any, Literal, TypeVar

import numba

from drillrig_env.jit.stamp import stamp_of

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

    try:
        dispatcher = compiler(cache=True)
    except RuntimeError:  # neither the package's folder nor the user's may be written to
        _warn_of_no_cache()
        return compiler(cache=False)  # type: ignore[no-any-return]
    cache_file = dispatcher._cache._cache_file
    cache_file._source_stamp = stamp_of(function.__code__.co_filename)
    return dispatcher  # type: ignore[no-any-return]


@lru_cache(maxsize=1)
def _warn_of_no_cache() -> None:
    warnings.warn(
        "drillrig_env finds no folder to keep its machine code in and compiles it anew in every process, some 20 s; "
        "name a folder that can be written to in the environment variable NUMBA_CACHE_DIR",
        stacklevel=2,
    )
