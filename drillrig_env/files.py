"""Files that are whole or not there, and folders with one owner at a time.

Whatever is cut short, by a kill, a full disk or an error, a file written with `written_whole` is the old one or
the new one, never a part. A folder that is `owned` has one process that writes into it.
"""

from __future__ import annotations

import hashlib
import json
import math
import os
import secrets
import shutil
import time
import zipfile
import zlib
from collections.abc import Callable, Iterator, Mapping, Sequence
from contextlib import contextmanager, suppress
from pathlib import Path
from typing import Any

import numpy as np
import numpy.typing as npt

LOCK, OWNER = ".lock", ".owner"
"""Files in a folder that is owned: the lock, which may stay behind and then means nothing, and the owner's number."""

_ATTEMPTS, _PAUSE = 20, 0.05  # on Windows a file that another program is just reading cannot be replaced; s


@contextmanager
def written_whole(path: str | Path) -> Iterator[Path]:
    """A path to write to; when the block ends, the file there takes the place of `path`, at once.

    The file to write lies beside `path`, in a folder that is made where it is missing, and ends like it, as libraries
    want it. Where the block raises, `path` is what it was and nothing is left beside it. A device such as /dev/stdout
    is written to as it is.

        with written_whole("model.zip") as new:
            model.save(new)

    Raises what the block raises, and `OSError` naming `path` where it cannot be written.
    """
    target = Path(os.path.realpath(path))
    if target.exists() and not target.is_file():
        yield target
        return
    target.parent.mkdir(parents=True, exist_ok=True)
    new = target.with_name(f".{target.stem}.{secrets.token_hex(4)}{target.suffix}")
    try:
        yield new
        if target.exists():
            shutil.copymode(target, new)
        _flush(new)
        _replace(new, target)
    except OSError as error:
        of_no_file = error.filename is None and error.errno is not None  # as of a write to a full disk
        if of_no_file or (error.filename is not None and Path(error.filename) == new):
            error.filename = str(path)
            del error.filename2  # None in its place would be printed as another file
        raise
    finally:
        with suppress(OSError):
            new.unlink(missing_ok=True)
    with suppress(OSError):  # a folder can be flushed on some systems only
        _flush(target.parent)


def write_bytes(path: str | Path, content: bytes) -> None:
    """Write bytes as the whole content of a file. `OSError` where it cannot be written; then it is what it was."""
    with written_whole(path) as new:
        new.write_bytes(content)


def write_text(path: str | Path, content: str) -> None:
    """Write text as the whole content of a file, in UTF-8 and with plain line ends; otherwise as `write_bytes`."""
    write_bytes(path, content.encode("utf-8"))


def json_text(content: Any, indent: int = 2) -> str:
    """Plain values as the text of a JSON file; NaN and infinity, which JSON has not, as null."""
    return json.dumps(_without_nan(content), indent=indent, ensure_ascii=False) + "\n"


def read_json(path: str | Path, remedy: str, fault: Callable[[dict[str, Any]], str] = lambda _: "") -> dict[str, Any]:
    """The object in a JSON file. `ValueError` with `remedy`, what to do, where it is damaged or no object.

    `fault` says of an object in words what it lacks, and nothing where it lacks nothing.
    """
    try:
        content = json.loads(Path(path).read_text(encoding="utf-8"))
    except ValueError as error:
        raise ValueError(f"{path} is damaged: it is not JSON ({error}); {remedy}") from error
    if not isinstance(content, dict):
        raise ValueError(f"{path} is damaged: it holds no object but a {type(content).__name__}; {remedy}")
    if lacking := fault(content):
        raise ValueError(f"{path} is damaged: {lacking}; {remedy}")
    return content


def read_arrays(path: str | Path, remedy: str) -> dict[str, npt.NDArray[Any]]:
    """The arrays of an `.npz` file. `ValueError` with `remedy`, what to do, where it is damaged or no such file."""
    try:
        with np.load(path, allow_pickle=False) as file:
            return {name: file[name] for name in file.files}
    except (ValueError, EOFError, KeyError, AttributeError, zipfile.BadZipFile, zlib.error) as error:
        raise ValueError(f"{path} is damaged: {str(error) or type(error).__name__}; {remedy}") from error


def digest(path: str | Path) -> str:
    """The SHA-256 of a file's content, in hexadecimal digits."""
    with Path(path).open("rb") as file:
        return hashlib.file_digest(file, "sha256").hexdigest()


def check_writable(folder: str | Path) -> None:
    """Raise `OSError`, naming the folder, where files cannot be written into it, there already or to be made.

    To be asked before any work whose results go there. It leaves nothing behind, also not the folder.
    """
    folder = Path(folder)
    nearest = next(path for path in (folder.absolute(), *folder.absolute().parents) if path.exists())
    probe = nearest / f".{secrets.token_hex(8)}"
    try:
        probe.touch(exist_ok=False)
        probe.unlink()
    except OSError as error:
        where = "" if nearest == folder.absolute() else f" ({nearest})"
        raise type(error)(f"{folder}{where} cannot be written: {(error.strerror or str(error)).lower()}") from error


def check_writable_file(path: str | Path) -> None:
    """Raise `OSError` where `written_whole` could not write this file, as `check_writable` does for a folder."""
    path = Path(path)
    if path.is_dir():
        raise IsADirectoryError(f"{path} cannot be written: it is a folder")
    if path.is_file() or not path.exists():  # else a device, which is written to as it is
        check_writable(path.parent)


def put_folder(new: Path, folder: Path, old: Path) -> None:
    """Put a folder in the place of another, which becomes `old`. `OSError` where it cannot; then all is as it was."""
    if not folder.exists():
        os.replace(new, folder)
        return
    os.replace(folder, old)
    try:
        os.replace(new, folder)
    except OSError:
        os.replace(old, folder)
        raise


@contextmanager
def written_folders(folders: Sequence[Path], check: Callable[[], object] | None = None) -> Iterator[list[Path]]:
    """Folders to write into; when the block ends, each takes the place of one of `folders`, at once.

    They lie beside `folders`, hidden. Where the block raises, or after it `check`, which may say that a folder must not
    be replaced, `folders` are what they were and nothing is left.
    """
    new = [folder.with_name(f".{folder.name}.{secrets.token_hex(4)}") for folder in folders]
    parents = [path for folder in folders for path in folder.parents if not path.exists()]
    try:
        for path in new:
            path.mkdir(parents=True)
        yield new
        if check is not None:
            check()
        for path, folder in zip(new, folders, strict=True):
            old = path.with_name(f"{path.name}.old")
            put_folder(path, folder, old)
            if old.exists():
                shutil.rmtree(old)
    finally:
        for path in new:
            shutil.rmtree(path, ignore_errors=True)
        for path in parents:
            with suppress(OSError):  # something else is in it
                path.rmdir()


@contextmanager
def owned(folder: str | Path, wait: float = 0.0) -> Iterator[None]:
    """Have a folder for oneself while the block runs. The folder is made where it is not there.

    Raises `BlockingIOError`, naming the folder and the process that has it, where another has it, in this process
    or in any other, and still has it after `wait` s. The lock is the system's: it ends with its process, however that
    ends.
    """
    from filelock import FileLock, Timeout  # it takes its time, and few of those who read files need it

    folder = Path(folder)
    folder.mkdir(parents=True, exist_ok=True)
    lock = FileLock(folder / LOCK)
    try:
        lock.acquire(timeout=wait)
    except Timeout:
        raise BlockingIOError(
            f"{folder} is in use by {_owner(folder)}; wait for it, or choose another folder"
        ) from None
    try:
        write_text(folder / OWNER, f"{os.getpid()}\n")
        yield
    finally:
        with suppress(OSError):
            (folder / OWNER).unlink(missing_ok=True)
        lock.release()


def _without_nan(value: Any) -> Any:
    if isinstance(value, Mapping):
        return {key: _without_nan(inner) for key, inner in value.items()}
    if isinstance(value, list | tuple):
        return [_without_nan(inner) for inner in value]
    return None if isinstance(value, float) and not math.isfinite(value) else value


def _owner(folder: Path) -> str:
    try:
        return f"process {int((folder / OWNER).read_text(encoding='utf-8'))}"
    except (OSError, ValueError):  # it has the lock and has not written its number yet
        return "another process"


def _flush(path: Path) -> None:
    """Bring what was written to the disk itself. (Windows flushes only what is open for writing.)"""
    descriptor = os.open(path, os.O_RDONLY if path.is_dir() or os.name != "nt" else os.O_RDWR)
    try:
        os.fsync(descriptor)
    finally:
        os.close(descriptor)


def _replace(new: Path, target: Path) -> None:
    for _ in range(_ATTEMPTS if os.name == "nt" else 1):
        try:
            os.replace(new, target)
            return
        except PermissionError as error:
            refused = error
            time.sleep(_PAUSE)
    raise refused
