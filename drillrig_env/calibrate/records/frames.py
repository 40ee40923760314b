"""Parquet and Excel files, which pandas reads."""

from __future__ import annotations

from typing import Any

import numpy as np

from drillrig_env.calibrate.records.raw import Column, RawTable, column
from drillrig_env.calibrate.records.text import read_text
from drillrig_env.extras import missing


def read_parquet(source: str) -> RawTable:
    """The columns of a Parquet file; an index of times is one of them.

    Raises `ValueError` where it cannot be read, and `ImportError` without pandas and pyarrow.
    """
    pandas = _pandas(source, "a Parquet file", "pyarrow")
    try:
        frame = pandas.read_parquet(source)
    except (ValueError, OSError) as error:
        raise ValueError(f"{source}: is no Parquet file that can be read ({error})") from error
    if not isinstance(frame.index, pandas.RangeIndex):
        frame = frame.reset_index(names=[frame.index.name or "time"])
    columns = [_of_series(str(name), frame[name]) for name in frame.columns]
    return RawTable(source, columns, "row", None, ("Parquet file",))


def read_excel(source: str) -> RawTable:
    """The first sheet of an Excel file, as if it were a text file: with header, units and notes above the numbers.

    Raises `ValueError` where it cannot be read, and `ImportError` without pandas and openpyxl.
    """
    pandas = _pandas(source, "an Excel file", "openpyxl")
    try:
        with pandas.ExcelFile(source) as book:
            sheet = book.sheet_names[0]
            frame = pandas.read_excel(book, sheet_name=sheet, header=None, dtype=object)
    except (ValueError, KeyError, OSError) as error:
        raise ValueError(f"{source}: is no Excel file that can be read ({error})") from error
    lines = ["\t".join(_cell(value) for value in row) for row in frame.itertuples(index=False)]
    table = read_text(source, "\n".join(lines).encode())
    return RawTable(source, table.columns, "row", table.numbers, (f"Excel file, sheet {sheet!r}",), table.headerless)


def _pandas(source: str, what: str, engine: str) -> Any:
    try:
        import pandas

        __import__(engine)
    except ModuleNotFoundError as error:
        raise missing(f"{source}: {what}", f"pandas and {engine}", "records") from error
    return pandas


def _of_series(name: str, series: Any) -> Column:
    """A column of a frame; numbers that can be missing are floats, and dates have no zone."""
    if series.dtype.kind in "iufb":
        return column(name, series.to_numpy(dtype=float, na_value=np.nan))
    if series.dtype.kind == "M":
        zoned = getattr(series.dt, "tz", None) is not None
        return column(name, (series.dt.tz_convert(None) if zoned else series).to_numpy())
    if series.dtype.kind == "m":
        return column(name, series.dt.total_seconds().to_numpy(), "s")
    return column(name, series.to_numpy())


def _cell(value: Any) -> str:
    """A cell as a text file would have it; pandas gives None and NaN where it is empty."""
    if value is None or value != value:
        return ""
    return " ".join(str(value).split())
