"""MATLAB files: vectors by name, alone, in structs, or as the columns of a matrix."""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from typing import Any

import numpy as np

from drillrig_env.calibrate.records.raw import RawTable, column, of_one_length


def read_matlab(source: str) -> RawTable:
    """The vectors in a `.mat` file, by name; those of a struct by the names of its fields, where each is there once.

    Raises `ValueError` where it cannot be read, or holds none.
    """
    from scipy.io import loadmat
    from scipy.io.matlab import MatReadError

    try:
        content = loadmat(source, simplify_cells=True)
    except NotImplementedError as error:
        raise ValueError(f"{source}: is of MATLAB's version 7.3; allowed: one written by save(..., '-v7')") from error
    except (MatReadError, ValueError, TypeError, EOFError) as error:
        raise ValueError(f"{source}: is no MATLAB file that can be read ({error})") from error
    found = [(name, value) for name, value in _vectors(content) if value.size > 1]
    fields = [name.rpartition(".")[2] for name, _ in found]
    names = [field if fields.count(field) == 1 else name for field, (name, _) in zip(fields, found, strict=True)]
    columns, note = of_one_length(source, [column(name, one[1]) for name, one in zip(names, found, strict=True)])
    return RawTable(source, columns, "sample", None, ("MATLAB file", *([note] if note else [])))


def _vectors(content: Mapping[str, Any], inside: str = "") -> Iterator[tuple[str, np.ndarray[Any, Any]]]:
    for name, value in content.items():
        if name.startswith("__"):
            continue
        if isinstance(value, Mapping):
            yield from _vectors(value, f"{inside}{name}.")
        elif isinstance(value, np.ndarray) and value.dtype.kind in "iufb":
            if value.ndim == 1:
                yield f"{inside}{name}", value
            elif value.ndim == 2:
                matrix = value if value.shape[0] >= value.shape[1] else value.T
                yield from ((f"{inside}{name}({k + 1})", matrix[:, k]) for k in range(matrix.shape[1]))
