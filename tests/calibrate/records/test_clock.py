"""Clocks of loggers: sorted, each time once, gaps told, and two records never mixed."""

import numpy as np
import pytest

from drillrig_env.calibrate.records import read_record

NAMES = ("time", "bit_speed", "top_speed")


def read(write, table):
    return read_record(write(NAMES, table.T))


def same(record, table):
    np.testing.assert_allclose(record.time, table[:, 0] - table[0, 0], atol=1e-6)
    np.testing.assert_allclose(record.signals["bit_speed"], table[:, 1], atol=1e-6)


def test_the_first_sample_is_zero_and_the_files_own_clock_is_kept(write, table):
    for begin in (12.5, -5.0):
        record = read(write, table + np.array([begin, 0, 0]))
        same(record, table)
        assert record.begin == pytest.approx(begin)


def test_samples_that_come_late_and_all_in_disorder_are_sorted(write, table):
    rng = np.random.default_rng(0)
    late = table[np.argsort(np.arange(len(table)) + 3.0 * rng.random(len(table)))]
    packets = np.concatenate([table[:200], table[250:300], table[200:250], table[300:]])
    for rows in (late, packets, table[rng.permutation(len(table))]):
        record = read(write, rows)
        same(record, table)
        assert any("the samples were sorted" in note for note in record.notes)


def test_repeated_times_are_kept_once(write, table):
    record = read(write, np.repeat(table, np.where(np.arange(len(table)) % 7, 1, 2), axis=0))
    same(record, table)
    assert "repeated times: 86 samples dropped, the first of each time is kept" in record.notes


def test_rows_that_were_all_written_twice(write, table):
    record = read(write, np.repeat(table, 2, axis=0))
    same(record, table)
    assert "repeated times: 601 samples dropped, the first of each time is kept" in record.notes


def test_rows_without_a_time_are_dropped(write, table):
    rows = table.copy()
    rows[[5, 80], 0] = np.nan
    record = read(write, rows)
    same(record, np.delete(table, [5, 80], axis=0))
    assert "rows without a time: 2 dropped" in record.notes


def test_gaps_and_uneven_sampling_are_left_as_they_are(write, table):
    rows = np.delete(table, slice(200, 300), axis=0)
    record = read(write, rows)
    same(record, rows)
    assert "gaps: 1, the longest of 2.02 s from 3.98 s on" in record.notes
    kept = np.sort(np.random.default_rng(1).choice(len(table), 300, replace=False))
    same(read(write, table[kept]), table[kept])


@pytest.mark.parametrize("tick", [0.1, 1.0])
@pytest.mark.parametrize("begin", [0, 3, 17])
def test_a_clock_that_ticks_more_slowly_than_samples_come_is_spread_evenly(write, table, tick, begin):
    rows = table[begin:].copy()
    rows[:, 0] = np.floor(rows[:, 0] / tick + 1e-9) * tick
    record = read(write, rows)
    same(record, table[begin:])
    assert any(f"the clock ticks each {tick:g} s" in note for note in record.notes)


def test_a_coarse_clock_stops_at_a_gap(write, table):
    rows = np.delete(table, slice(200, 350), axis=0)
    coarse = rows.copy()
    coarse[:, 0] = np.floor(rows[:, 0] / 0.1 + 1e-9) * 0.1
    same(read(write, coarse), rows)


@pytest.mark.parametrize(
    ("rows", "words"),
    [
        (lambda table: table[::-1], ["line 2", "backwards, from 12 to 0 s", "earliest sample first"]),
        (lambda table: np.concatenate([table, table[:300]]), ["line 603", "falls from 12 to 0 s", "one record a file"]),
        (lambda table: table * [0, 1, 1] + [3, 0, 0], ["column time", "601 samples", "1 of them apart"]),
    ],
)
def test_what_is_no_clock_is_refused(rows, words, write, table):
    with pytest.raises(ValueError, match=r"run\.csv") as caught:
        read(write, rows(table))
    for word in words:
        assert word in str(caught.value)


def test_since_is_on_the_clock_of_the_file(write, table):
    extended = np.column_stack([table, np.full(len(table), 3.14), np.full(len(table), 25.0)])
    record = read_record(write((*NAMES, "speed_reference", "normal_force"), (extended + np.array([20, 0, 0, 0, 0])).T))
    later = record.since(24.99)
    np.testing.assert_allclose(later.time, table[250:, 0] - 4.99, atol=1e-6)
    np.testing.assert_allclose(later.signals["bit_speed"], table[250:, 1], atol=1e-6)
    assert len(later.speed_reference) == len(later.normal_force) == len(later.time)
    assert later.begin == 24.99
    for start_time in (19.0, 31.99, float("nan")):
        with pytest.raises(ValueError, match=rf"start_time = {start_time} s .* >= 20 and <= 31.98 s"):
            record.since(start_time)
