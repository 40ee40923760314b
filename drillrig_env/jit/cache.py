"""Where machine code is kept between processes, and how a cache that is damaged or full is lived with.

Numba keeps it beside the source, or in the user's own cache folder. Where neither may be written to, a folder for
this user in the system's temporary folder takes their place, so that nothing is compiled twice on one machine.
"""

from __future__ import annotations

import hashlib
import os
import pickle
import stat
import tempfile
import warnings
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from functools import cache
from pathlib import Path
from typing import Any

import numba
from numba.core.caching import IndexDataCacheFile

from drillrig_env.jit.stamp import stamp_of

_DIGEST = hashlib.sha256().digest_size
_index_data_file: Any = IndexDataCacheFile  # its type says nothing of what it does


class CacheFile(_index_data_file):  # type: ignore[misc]
    """The cache of one kernel. What is damaged counts as not there; what cannot be written is let be.

    Numba numbers the files of machine code, and two processes that compile at once may give one number to two
    signatures, or to code before and after an edit: then one runs the other's code, on memory of another layout. Here
    a file's name says what is in it.
    """

    def load(self, key: Any) -> Any:
        """Machine code for a signature, or None where there is none that is whole."""
        try:
            return super().load(key)
        except Exception:  # whatever unpickling a damaged file leads to
            return None

    def save(self, key: Any, data: Any) -> None:
        """Keep machine code, if the disk has room for it."""
        content = hashlib.sha256(repr((key, self._source_stamp, self._version)).encode()).hexdigest()
        name = f"{self._index_name.removesuffix('.nbi')}.{content[:16]}.nbc"
        try:
            self._save_data(name, data)
            self._save_index({**self._load_index(), key: name})
        except OSError as error:
            warn_of_no_cache(f"cannot write its machine code to {self._cache_path} ({error.strerror})")

    def _load_index(self) -> Any:
        try:
            return super()._load_index()
        except Exception:
            return {}

    def _load_data(self, name: str) -> Any:
        content = Path(self._data_path(name)).read_bytes()
        digest, data = content[:_DIGEST], content[_DIGEST:]
        if hashlib.sha256(data).digest() != digest:
            raise OSError(f"{name} is damaged")
        return pickle.loads(data)

    def _save_data(self, name: str, data: Any) -> None:
        content = self._dump(data)
        with self._open_for_write(self._data_path(name)) as file:
            file.write(hashlib.sha256(content).digest() + content)


def cached(compiler: Callable[[bool], Any], source: str) -> Any:
    """The dispatcher that `compiler(cache)` makes, with a cache where there is a folder for it.

    `source` is the file of the kernel, which with all that it stands on decides when the cache is renewed.
    """
    try:
        dispatcher = compiler(True)
    except RuntimeError:  # neither the package's folder nor the user's may be written to
        folder = temporary_folder()
        if folder is None:
            warn_of_no_cache("finds no folder to keep its machine code in")
            return compiler(False)
        with _cache_in(folder):
            dispatcher = compiler(True)
    files = dispatcher._cache._cache_file
    base = files._index_name.removesuffix(".nbi")
    dispatcher._cache._cache_file = CacheFile(files._cache_path, base, stamp_of(source))
    return dispatcher


@cache
def temporary_folder() -> Path | None:
    """A folder in the system's temporary folder that belongs to this user alone; None where there can be none.

    Machine code is executed when it is loaded: a folder of somebody else, a link, or one that others may write to is
    not taken.
    """
    user = str(os.getuid()) if hasattr(os, "getuid") else "user"  # elsewhere the temporary folder is the user's own
    try:
        folder = Path(tempfile.gettempdir(), f"drillrig-{user}")
        folder.mkdir(mode=0o700, exist_ok=True)
        found = folder.lstat()
    except OSError:
        return None
    mine = not hasattr(os, "getuid") or (found.st_uid == os.getuid() and not found.st_mode & 0o077)
    return folder if stat.S_ISDIR(found.st_mode) and mine and os.access(folder, os.W_OK | os.X_OK) else None


@contextmanager
def _cache_in(folder: Path) -> Iterator[None]:
    config: Any = numba.config
    before, config.CACHE_DIR = config.CACHE_DIR, str(folder)
    try:
        yield
    finally:
        config.CACHE_DIR = before


_WARNED: list[str] = []


def warn_of_no_cache(why: str) -> None:
    """Warn, once a process, that kernels will be compiled anew in every process."""
    if not _WARNED:
        _WARNED.append(why)
        warnings.warn(
            f"drillrig_env {why} and compiles it anew in every process, some 5 s; "
            "name a folder that can be written to in the environment variable NUMBA_CACHE_DIR",
            stacklevel=2,
        )
