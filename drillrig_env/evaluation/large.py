"""Scores of a large suite on disk: one Parquet file a policy, a row group a piece, read a column at a time.

A table needs one column of scores and the few that choose its rows; a column of a million rigs takes 8 MB.
"""

from __future__ import annotations

import hashlib
from collections.abc import Iterable, Iterator, Mapping
from pathlib import Path
from typing import Any

import numpy.typing as npt

from drillrig_env.extras import missing
from drillrig_env.files import digest, written_whole

ROWS = "rows"
"""The folder, in that of an evaluation, of the rows of large suites."""


class StoredScores(Mapping[str, npt.NDArray[Any]]):
    """Columns of a Parquet file by name, each read when it is asked for and not kept.

    Of `stamp`, `digest` is that of the numbers themselves, whatever file they are in; `sha256` that of the file.
    """

    def __init__(self, path: Path, stamp: Mapping[str, Any]) -> None:
        self.path, self.stamp = path, dict(stamp)
        self._names: list[str] = _parquet().read_schema(path).names

    def __getitem__(self, name: str) -> npt.NDArray[Any]:
        if name not in self._names:
            raise KeyError(name)
        column = _parquet().read_table(self.path, columns=[name])[name]
        values: npt.NDArray[Any] = column.to_numpy()
        return values.astype(str) if values.dtype.kind == "O" else values

    def __iter__(self) -> Iterator[str]:
        return iter(self._names)

    def __len__(self) -> int:
        return len(self._names)

    @classmethod
    def read(cls, path: Path, stamp: Mapping[str, Any], remedy: str) -> StoredScores:
        """The scores in a file that is to have this stamp. `ValueError` with `remedy` where it has not."""
        if not path.is_file():
            raise ValueError(f"{path} is missing; {remedy}")
        if digest(path) != stamp.get("sha256"):
            raise ValueError(f"{path} is damaged: it is not what was written; {remedy}")
        return cls(path, stamp)


def check_large() -> None:
    """Raise `ImportError`, saying what to install, where Parquet files cannot be written."""
    _parquet()


def store(path: Path, parts: Iterable[Mapping[str, npt.NDArray[Any]]]) -> StoredScores:
    """Write scores into a file, part after part, of which one is held at a time."""
    import pyarrow

    parquet, numbers, rows = _parquet(), hashlib.sha256(), 0
    with written_whole(path) as new:
        writer: Any = None
        try:
            for part in parts:
                table = pyarrow.table({name: _column(values) for name, values in part.items()})
                writer = writer or parquet.ParquetWriter(new, table.schema, compression="zstd")
                writer.write_table(table)
                for name, values in part.items():
                    numbers.update(name.encode())
                    numbers.update("\n".join(values).encode() if values.dtype.kind == "U" else values.tobytes())
                rows += table.num_rows
        finally:
            if writer is not None:
                writer.close()
    return StoredScores(path, {"rows": rows, "sha256": digest(path), "digest": numbers.hexdigest()})


def _column(values: npt.NDArray[Any]) -> Any:
    import pyarrow

    return pyarrow.array(values.tolist(), pyarrow.string()) if values.dtype.kind == "U" else pyarrow.array(values)


def _parquet() -> Any:
    try:
        import pyarrow.parquet
    except ImportError:
        raise missing("an evaluation of more than 10,000 rigs", "pyarrow", "scale") from None
    return pyarrow.parquet
