"""The folder of a calibration: rig and friction as files, how well they are known, joint draws, and a page.

    rig.toml, friction.toml    what fits best, read by `Rig.from_toml` and `Friction.from_toml`
    calibration.json           intervals, misfits, the load, the records and their hashes, seed, versions, command
    draws.npz                  64 joint draws: `names`, and `values` of shape (64, names)
    index.html, *.png          measured beside model, what is known how well, what it means

It is written whole, or not at all.
"""

from __future__ import annotations

import html
import os
import secrets
import shutil
from collections.abc import Sequence
from fnmatch import fnmatch
from pathlib import Path
from typing import Any

import numpy as np

from drillrig_env.calibrate.calibration import Calibration
from drillrig_env.calibrate.meaning import Meaning
from drillrig_env.calibrate.misfit import misfit_words, misfits
from drillrig_env.evaluation.provenance import provenance
from drillrig_env.files import check_writable, json_text, write_text
from drillrig_env.plots.style import Picture

_FILES = ("rig.toml", "friction.toml", "calibration.json", "draws.npz", "index.html", "intervals.png")


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
    return path.is_file() and (path.name in _FILES or fnmatch(path.name, "record_*.png"))


def write_result(
    folder: Path,
    calibration: Calibration,
    means: Sequence[Meaning],
    pictures: dict[str, Picture],
    command: str,
    overwrite: bool = False,
) -> None:
    """Write the folder; `command` is the line that made it, `pictures` are by the name of their file."""
    check_free(folder, overwrite)
    folder = folder.resolve()
    new = folder.with_name(f".{folder.name}.{secrets.token_hex(4)}")
    new.mkdir(parents=True)
    try:
        calibration.rig.to_toml(new / "rig.toml")
        calibration.friction.to_toml(new / "friction.toml")
        write_text(new / "calibration.json", json_text(summary(calibration, means, command)))
        unknowns = calibration.unknowns
        values = [list(unknowns.values(logs).values()) for logs in calibration.draws]
        np.savez(new / "draws.npz", names=np.array(unknowns.names), values=np.array(values))
        _write_page(new, calibration, means, pictures, command)
        if folder.exists():
            old = new.with_name(f"{new.name}.old")
            os.replace(folder, old)
            try:
                os.replace(new, folder)
            except OSError:
                os.replace(old, folder)
                raise
            shutil.rmtree(old)
        else:
            os.replace(new, folder)
    except OSError as error:  # a full disk names no file
        raise type(error)(f"{folder} cannot be written: {(error.strerror or str(error)).lower()}") from error
    finally:
        shutil.rmtree(new, ignore_errors=True)


def summary(calibration: Calibration, means: Sequence[Meaning], command: str) -> dict[str, Any]:
    """What is known of a calibration, for calibration.json."""
    best = calibration.best
    return {
        "parameters": {
            name: {"value": value, "low": low, "high": high, "known": told}
            for name, value, low, high, told in calibration.rows()
        },
        "probability": 0.9,
        "load": calibration.load,
        "means": {one.name: {"value": one.value, "low": one.low, "high": one.high} for one in means},
        "misfits": [vars(one) for one in misfits(calibration)],
        "cost": best.cost,
        "costs": best.costs.tolist(),
        "starts": best.starts,
        "stopped": best.stopped,
        "windows": calibration.spread.windows,
        "records": [
            {"file": one.source, "sha256": one.digest, "notes": list(one.notes)} for one in calibration.records
        ],
        "seed": calibration.seed,
        "command": command,
        "made": provenance(),
    }


def parameter_rows(calibration: Calibration) -> list[list[str]]:
    """A row of text for each parameter: name, value, interval and how it is known."""
    return [
        [name, f"{value:.4g}", f"{low:.4g} to {high:.4g}", f"{50.0 * (high - low) / value:.1f} %", told]
        for name, value, low, high, told in calibration.rows()
    ]


HEADINGS = ["parameter", "value", "90 % interval", "+-", "known"]


def meaning_words(one: Meaning) -> str:
    """A speed with its interval, or that the records do not tell it."""
    if not one.determined:
        return f"{one.name}: not determined by these records"
    return f"{one.name}: {one.value:.3f} rad/s ({one.low:.3f} to {one.high:.3f})"


def _write_page(
    folder: Path, calibration: Calibration, means: Sequence[Meaning], pictures: dict[str, Picture], command: str
) -> None:
    from drillrig_env.plots.style import look, save

    figures = []
    for name, picture in pictures.items():
        with look():
            save(picture, folder, name, ["png"])
        caption = html.escape(picture.caption)
        figures.append(f'<figure><img src="{name}.png" alt=""><figcaption>{caption}</figcaption></figure>')
    head, *body = (
        "".join(f"<td>{html.escape(cell)}</td>" for cell in row) for row in (HEADINGS, *parameter_rows(calibration))
    )
    table = "\n".join(f"<tr>{line}</tr>" for line in (head.replace("td>", "th>"), *body))
    notes = "".join(
        f"<li>{html.escape(one.source)}: {html.escape('; '.join(one.notes))}</li>" for one in calibration.records
    )
    load = f"at N_1 = {calibration.load:.4g} N: "
    words = [*(load + meaning_words(one) for one in means), *misfit_words(misfits(calibration))]
    told = "".join(f"<li>{html.escape(one)}</li>" for one in words)
    write_text(
        folder / "index.html",
        _PAGE.format(table=table, figures="\n".join(figures), told=told, notes=notes, command=html.escape(command)),
    )


_PAGE = """<!doctype html>
<html lang="en"><meta charset="utf-8"><title>A calibrated rig</title>
<style>body {{ font: 16px/1.5 sans-serif; max-width: 52em; margin: 2em auto; padding: 0 1em }}
table {{ border-collapse: collapse }} td, th {{ border-bottom: 1px solid #ccc; padding: .2em .8em; text-align: left }}
img {{ max-width: 100% }} figcaption {{ color: #555; font-size: 90% }}</style>
<h1>A calibrated rig</h1>
<h2>What it means</h2><ul>{told}</ul>
<h2>Parameters</h2><table>{table}</table>
<h2>Measured beside the model</h2>{figures}
<h2>Records</h2><ul>{notes}</ul>
<p>Made by <code>{command}</code></p></html>
"""
