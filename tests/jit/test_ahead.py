"""Memory that is asked for ahead: nothing comes of it, wherever it lies."""

import numpy as np
import pytest

from drillrig_env.jit.ahead import fetch
from drillrig_env.jit.compiled import compiled

PAIR = np.dtype([("a", "f8", 20), ("b", "f8")])


@compiled
def _total_of_records(records, ahead):
    total = 0.0
    for i in range(records.shape[0]):
        fetch(records, i + ahead)
        total += records[i].b
    return total


@compiled
def _total_of_rows(rows, ahead):
    total = 0.0
    for i in range(rows.shape[0]):
        fetch(rows, i + ahead)
        total += rows[i, 0]
    return total


@pytest.mark.parametrize("ahead", [0, 3, 1 << 40, -(1 << 40)])
def test_asking_for_memory_changes_nothing_even_where_there_is_none(ahead):
    records, rows = np.zeros(9, PAIR), np.arange(9.0)[:, None] * np.ones((9, 4))
    records["b"] = np.arange(9.0)
    before = records.copy(), rows.copy()
    assert _total_of_records(records, ahead) == _total_of_rows(rows, ahead) == 36.0
    np.testing.assert_array_equal(records, before[0])
    np.testing.assert_array_equal(rows, before[1])


def test_an_array_without_entries_can_be_asked_for():
    assert _total_of_rows(np.empty((0, 4)), 1) == 0.0
