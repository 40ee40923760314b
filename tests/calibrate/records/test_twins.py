"""Twins: runs of the simulator with everything that a logger does to them, read back."""

import numpy as np
import pytest

from drillrig_env import Friction, simulate
from drillrig_env.calibrate.records import read_record


@pytest.mark.parametrize("rate", [10, 50, 200, 1000])
def test_a_twin_is_what_it_was_but_for_noise(rate, write):
    run = simulate(friction=Friction(25.0), speed_reference=3.14, duration=30.0, sample_period=1.0 / 1000.0)
    each = slice(None, None, 1000 // rate)
    rng = np.random.default_rng(rate)
    time, bit, top = run.time[each], run.bit_speed[each], run.top_speed[each]
    angle = np.concatenate([[0.0], np.cumsum(0.5e-3 * (run.collar_speed[1:] + run.collar_speed[:-1]))])[each]
    n = len(time)
    written = {
        "Time [ms]": 1e3 * (time + 40.0),
        "Bit [rpm]": 30.0 / np.pi * (bit + 0.02 * rng.standard_normal(n)),
        "Top [rpm]": np.round(30.0 / np.pi * top),  # a display of whole turns a minute
        "Encoder": np.mod(np.floor(angle * 4096 / (2.0 * np.pi)), 4096),
        "WOB [N]": np.full(n, 25.0),
        "Oil [°C]": np.full(n, 60.0),
    }
    hit = np.zeros(n, dtype=bool)
    hit[rng.choice(np.arange(20, n - 20, 10), n // 100 + 1, replace=False)] = True
    written["Bit [rpm]"][hit] = 3000.0
    kept = np.ones(n, dtype=bool)
    kept[n // 2 : n // 2 + n // 15] = False
    rows = np.flatnonzero(kept)
    late = rows[np.argsort(np.arange(len(rows)) + 2.5 * rng.random(len(rows)))]
    path = write(list(written), [column[late] for column in written.values()], separator=";", decimal=",")
    told = {"Bit [rpm]": "bit_speed", "Top [rpm]": "top_speed", "Encoder": "collar_angle:counts/4096"}
    record = read_record(path, told)

    np.testing.assert_allclose(record.time, time[kept], atol=1e-6)
    assert np.array_equal(np.isnan(record.signals["bit_speed"]), hit[kept])
    assert np.nanstd(record.signals["bit_speed"] - bit[kept]) < 0.025
    assert np.abs(record.signals["top_speed"] - top[kept]).max() < 0.06
    collars = record.signals["collar_speed"] - run.collar_speed[each][kept]
    assert np.nanpercentile(np.abs(collars), 98.0) < (0.35 if rate == 10 else 0.1)
    assert set(record.normal_force) == {25.0}
    assert "left out: Oil [°C]" in record.notes
    assert any(note.startswith("gaps: 1, the longest of 2") for note in record.notes)
