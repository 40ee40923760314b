"""The folder of a calibration: rig and friction as files, how well they are known, joint draws, and a page.

    rig.toml, friction.toml    what fits best, read by `Rig.from_toml` and `Friction.from_toml`
    calibration.json           intervals, scores, misfits, load, the records' hashes, seed, versions, command
    draws.npz                  64 joint draws: `names`, and `values` of shape (64, names)
    index.html, *.png          measured beside model, what is known how well, what it means

It is written whole, or not at all, and by one process at a time.
"""

from __future__ import annotations

import os
import shutil
from collections.abc import Iterator, Mapping
from contextlib import contextmanager, suppress
from fnmatch import fnmatch
from pathlib import Path

import numpy as np

from drillrig_env.calibrate.page import page
from drillrig_env.calibrate.report import Report
from drillrig_env.files import check_writable, json_text, owned, put_folder, write_text
from drillrig_env.plots.style import Picture, look, save

_FILES = ("rig.toml", "friction.toml", "calibration.json", "draws.npz", "index.html")
_PICTURES = ("intervals.png", "correlations.png", "borders.png", "record_*.png")


def check_free(folder: Path, overwrite: bool) -> None:
    """Raise `OSError` where a result cannot be written there, and where one is there that may not be overwritten.

    With `overwrite` only a result is: a folder with anything else in it stays.
    """
    if folder.exists() and not overwrite:
        raise FileExistsError(f"{folder} is there already; choose another --output, or give --overwrite")
    if folder.exists():
        others = (
            [path.name for path in folder.iterdir() if not _of_a_result(path)] if folder.is_dir() else [folder.name]
        )
        if others:
            raise FileExistsError(
                f"{folder} holds {min(others)}, which is no part of a result; choose another --output"
            )
    check_writable(folder.resolve().parent)


def _of_a_result(path: Path) -> bool:
    """Whether a file has the name of one that a result has."""
    return path.is_file() and (path.name in _FILES or any(fnmatch(path.name, one) for one in _PICTURES))


@contextmanager
def reserved(folder: Path, overwrite: bool = False) -> Iterator[Path]:
    """A new folder to write a result into; when the block ends, it takes the place of `folder`, at once.

    It lies within a hidden folder beside `folder`, which this process has for itself: what a run that was killed left
    there goes, and a result that it had just put aside comes back. Where the block raises, `folder` is what it was and
    nothing stays beside it. Raises `BlockingIOError` where another process is writing that result, and as `check_free`.
    """
    folder = folder.resolve()
    check_writable(folder.parent)
    hidden = folder.with_name(f".{folder.name}.calibrating")
    new, old = hidden / "new", hidden / "old"
    try:
        with owned(hidden):
            if old.exists() and not folder.exists():
                os.replace(old, folder)
            check_free(folder, overwrite)
            for left in (new, old):
                shutil.rmtree(left, ignore_errors=True)
            new.mkdir()
            try:
                yield new
                put_folder(new, folder, old)
            finally:
                for left in (new, old):
                    shutil.rmtree(left, ignore_errors=True)
    except BlockingIOError as error:
        raise BlockingIOError(str(error).replace(str(hidden), str(folder))) from None
    finally:
        _remove(hidden)


def write_result(folder: Path, report: Report, pictures: Mapping[str, Picture]) -> None:
    """Write the files into a folder that is there; `pictures` are by the name of their file.

    `OSError` naming the folder where it cannot be written.
    """
    calibration = report.calibration
    try:
        calibration.rig.to_toml(folder / "rig.toml")
        calibration.friction.to_toml(folder / "friction.toml")
        write_text(folder / "calibration.json", json_text(report.summary()))
        unknowns = calibration.unknowns
        values = [list(unknowns.values(logs).values()) for logs in calibration.draws]
        np.savez(folder / "draws.npz", names=np.array(unknowns.names), values=np.array(values))
        with look():
            for name, picture in pictures.items():
                save(picture, folder, name, ["png"])
        captions = {name: picture.caption for name, picture in pictures.items()}
        write_text(folder / "index.html", page(report, {folder / f"{name}.png": captions[name] for name in captions}))
    except OSError as error:  # a full disk names no file
        raise type(error)(f"the result cannot be written: {(error.strerror or str(error)).lower()}") from error


def _remove(hidden: Path) -> None:
    """Take the hidden folder away, where nobody has it: another may have begun to wait for it."""
    with suppress(OSError), owned(hidden):
        shutil.rmtree(hidden, ignore_errors=True)
