"""The folder of an evaluation: its files, whether they are whole, and what goes before another evaluation comes.

| file | holds |
|---|---|
| `results.csv` | scores, a row an episode; packed, as the documentation keeps them, `results.csv.xz` |
| `histories.npz` | a few rigs over time |
| `results.json` | what made the results, their tables as numbers, and rows and digests of the other two |
| `rows/SUITE/POLICY.parquet` | scores in a suite of more than 10,000 rigs, which are not in the table |
| `pieces/` | pieces of policies that are not done yet |
| `scores_default.png`, ... | pictures: see `drillrig_env.evaluation.pictures` |

A save writes `results.json` first, with the digests of the other files as they will be and as they are. Whenever
it is cut short, what lies there is what was saved last or the time before; anything else was damaged or edited,
and is refused.
"""

from __future__ import annotations

import hashlib
import lzma
import shutil
from collections.abc import Mapping
from pathlib import Path
from typing import Any

from drillrig_env.evaluation.histories import REGIONS, Histories
from drillrig_env.evaluation.large import ROWS, StoredScores
from drillrig_env.evaluation.pieces import PIECES
from drillrig_env.evaluation.results import Results
from drillrig_env.evaluation.suites import SUITES
from drillrig_env.files import json_text, read_json, write_bytes, write_text

CSV, HISTORIES, JSON = "results.csv", "histories.npz", "results.json"
COMPRESSED = ".xz"
PICTURES = ("scores", "calming", "map", *(f"histories_{region}" for region in REGIONS))
"""What pictures of a suite show; see `picture_name`."""

_REMEDY = "put a copy of it back, or remove the folder and evaluate again"
_PARTS = ("config", "provenance", "estimates", "files")

Stamp = Mapping[str, Any]
"""What is noted of a file: `sha256`, and `rows` of a table. Of a packed file it is what is packed that counts."""


def save(folder: Path, results: Results, histories: Histories, packed: bool = False) -> None:
    """Write results and histories into a folder, which is made; `packed` packs the rows.

    Raises `OSError` where that fails; what was saved there before can then still be read.
    """
    folder.mkdir(parents=True, exist_ok=True)
    rows, kept = results.rows.encode("utf-8"), histories.packed()
    content = {
        "config": results.config,
        "provenance": results.provenance,
        "files": {CSV: _stamp(rows, table=True), HISTORIES: _stamp(kept)},
        "estimates": results.estimates,
    }
    if results.stored:
        content["stored"] = {
            suite: {name: {**one.stamp, "file": one.path.name} for name, one in policies.items()}
            for suite, policies in results.stored.items()
        }
    before = _stamps(folder)
    if before not in ({}, content["files"]):
        content["before"] = before
    write_text(folder / JSON, json_text(content))
    write_bytes(folder / HISTORIES, kept)
    if packed:
        write_bytes(folder / (CSV + COMPRESSED), lzma.compress(rows, preset=9 | lzma.PRESET_EXTREME))
    else:
        write_bytes(folder / CSV, rows)


def read(folder: str | Path) -> Results:
    """The results that a folder holds.

    Raises `ValueError`, naming the file, where it holds none, or where one is damaged or was edited.
    """
    folder = Path(folder)
    content = _content(folder)
    rows = _rows(folder)
    if rows is None:
        raise ValueError(f"{folder} holds no results: {CSV} is missing")
    _check(folder / CSV, _stamp(rows, table=True), content)
    results = Results.of_rows(rows.decode("utf-8"), content["config"], content["provenance"], content["estimates"])
    for suite, policies in content.get("stored", {}).items():
        for policy, stamp in policies.items():
            path = folder / ROWS / suite / stamp["file"]
            results.add_stored(suite, policy, StoredScores.read(path, stamp, _REMEDY))
    results.arrange(results.policies)
    results.estimates = content["estimates"]
    return results


def read_histories(folder: str | Path) -> Histories:
    """The histories beside the results of a folder. `ValueError`, naming the file, as in `read`."""
    path = Path(folder) / HISTORIES
    content = _content(Path(folder))
    if not path.is_file():
        raise ValueError(f"{path} is missing; {_REMEDY}")
    kept = path.read_bytes()
    _check(path, _stamp(kept), content)
    return Histories.unpacked(kept)


def holds_results(folder: Path) -> bool:
    """Whether any file of an evaluation lies in a folder, damaged or not."""
    return any((folder / name).exists() for name in (CSV, CSV + COMPRESSED, HISTORIES, JSON, ROWS))


def clear(folder: Path) -> None:
    """Remove what an evaluation has left in a folder, its pictures too, and nothing else."""
    for name in (JSON, CSV, CSV + COMPRESSED, HISTORIES):
        (folder / name).unlink(missing_ok=True)
    for name in (ROWS, PIECES):
        shutil.rmtree(folder / name, ignore_errors=True)
    clear_pictures(folder)


def clear_pictures(folder: Path) -> None:
    """Remove the pictures of an evaluation, which show what its results no longer are."""
    for suite in SUITES:
        for picture in PICTURES:
            (folder / f"{picture_name(picture, suite)}.png").unlink(missing_ok=True)


def picture_name(picture: str, suite: str) -> str:
    """The name of a picture of a suite: "scores_default", "histories_default_below"."""
    kind, _, region = picture.partition("_")
    return f"{kind}_{suite}_{region}" if region else f"{kind}_{suite}"


def _content(folder: Path) -> dict[str, Any]:
    if not (folder / JSON).is_file():
        raise ValueError(f"{folder} holds no results: {JSON} is missing")
    content = read_json(folder / JSON, _REMEDY)
    if {"config", "provenance"} <= set(content) and "files" not in content:
        raise ValueError(
            f"{folder / JSON} is of an earlier version, which kept no digests, so that its results cannot be checked; "
            "remove the folder, or name another, and evaluate again"
        )
    for part in _PARTS:
        if not isinstance(content.get(part), dict):
            raise ValueError(f"{folder / JSON} is damaged: {part!r} is missing; {_REMEDY}")
    return content


def _rows(folder: Path) -> bytes | None:
    """The table as text, unpacked where it is packed; None where there is none."""
    plain, packed = folder / CSV, folder / (CSV + COMPRESSED)
    if plain.is_file():
        return plain.read_bytes()
    if not packed.is_file():
        return None
    try:
        return lzma.decompress(packed.read_bytes())
    except lzma.LZMAError as error:
        raise ValueError(f"{packed} is damaged: it cannot be unpacked ({error}); {_REMEDY}") from error


def _check(path: Path, found: Stamp, content: Mapping[str, Any]) -> None:
    """Raise `ValueError` where a file is neither what was saved last nor what was saved before."""
    written = [content[name].get(path.name) for name in ("files", "before") if name in content]
    if found in written:
        return
    last = written[0] or {}
    if "rows" in found and found["rows"] != last.get("rows"):
        fault = f"it has {found['rows']} rows, and had {last.get('rows')} when it was written"
    else:
        fault = "it is not what was written"
    raise ValueError(f"{path} is damaged: {fault}; {_REMEDY}")


def _stamps(folder: Path) -> dict[str, Stamp]:
    """The stamps of what lies in a folder."""
    found: dict[str, Stamp] = {}
    rows = _rows(folder)
    if rows is not None:
        found[CSV] = _stamp(rows, table=True)
    if (folder / HISTORIES).is_file():
        found[HISTORIES] = _stamp((folder / HISTORIES).read_bytes())
    return found


def _stamp(content: bytes, table: bool = False) -> Stamp:
    """`rows` are those below the header."""
    rows = {"rows": max(0, content.count(b"\n") - 1)} if table else {}
    return {**rows, "sha256": hashlib.sha256(content).hexdigest()}
