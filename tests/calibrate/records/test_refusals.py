"""What is no record of a rig is refused in one sentence that says where, what, and what would help."""

import numpy as np
import pytest

from drillrig_env import Friction, Rig, simulate
from drillrig_env.calibrate.records import parse_map, read_record
from drillrig_env.calibrate.records.motion import is_aliased

RPM = 60.0 / (2.0 * np.pi)
SLOW = np.column_stack([np.arange(20.0), np.arange(20.0), np.arange(20.0)])


def refused(path, words, columns=None, error=ValueError):
    with pytest.raises(error) as caught:
        read_record(path, columns)
    sentence = str(caught.value)
    assert "\n" not in sentence
    for word in [path.name, *words]:
        assert word in sentence, sentence


@pytest.mark.parametrize(
    ("text", "words"),
    [
        ("", ["no columns of numbers", "a header"]),
        ("time,bit_speed\n", ["no columns of numbers"]),
        ("only words\nin some lines\n", ["no columns of numbers"]),
        ("0.0,1.0\n0.1,2.0\n0.2,3.0\n", ["line 1", "header is missing", '--map "#1=time:s"']),
        ("bit_speed,x\n1,2\n2,3\n", ["line 2", "no column is plainly a time", "found: bit_speed, x", "time:s"]),
        ("time,x\n0,1\n1,2\n", ["line 2", "plainly a speed of a disc", "found: time, x", "bit_speed:rpm"]),
        ("time,current\n0,1\n1,2\n", ["plainly a speed of a disc"]),
        ("time,Bit Velocity\n0,1\n1,2\n", ["plainly a speed of a disc", "Bit Velocity"]),
        ("time,bit_speed\n0,0,0,123\n1,0,1,123\n", ["line 2", "4 cells, and 2 names in line 1", "comma both"]),
        ("time,bit_speed\n0,1_0\n1,2\n2,3\n3,4\n", ["line 2, column bit_speed", "'1_0'", "a number, or nothing"]),
        ("time,bit_speed\n0,1\n1,fast\n2,3\n3,4\n", ["line 3, column bit_speed", "'fast'", "1 such cells"]),
        ("time,bit_speed\n0,1\n1,2\n2,3,4\n3,4\n", ["line 4", "3 cells", "allowed: 2"]),
        ("time,bit_speed [N]\n0,1\n1,2\n", ["'N' of column 'bit_speed [N]'", "no unit of bit_speed", "rad/s, rpm"]),
        ("time;speed;bit_speed\n[s];[m];[m/s]\n0;1;1\n1;1;2\n", ["'m/s' of column 'bit_speed'", "rpm"]),
        ("time,bit_speed,bit_rpm\n0,1,2\n1,2,3\n", ["'bit_speed' and 'bit_rpm' are both bit_speed", "=none"]),
        ("time,bit_speed\n0,1\n1,2\n2,3\n", ["3 samples over 2 s are too few", ">= 8"]),
        ("time,bit_speed\nnoon,1\nnoon,2\nnoon,3\n", ["line 2, column time", "'noon' is no time", "10:00:00.25"]),
        ("time,bit_speed\n0,\n1,\n2,\n", ["column bit_speed", "no value in 3 samples"]),
    ],
)
def test_what_is_no_table_of_a_rig(text, words, tmp_path):
    path = tmp_path / "run.csv"
    path.write_text(text)
    refused(path, words)


def test_what_is_no_file_that_can_be_read(tmp_path):
    refused(tmp_path, ["folder"], error=IsADirectoryError)
    for name in ("run.csv", "run.mat", "run.tdms", "run.xlsx"):
        refused(tmp_path / name, [], error=FileNotFoundError)


@pytest.mark.parametrize(
    ("name", "packages"),
    [
        ("run.mat", ["scipy"]),
        ("run.tdms", ["nptdms"]),
        ("run.parquet", ["pandas", "pyarrow"]),
        ("run.xlsx", ["pandas", "openpyxl"]),
    ],
)
def test_what_is_no_file_of_the_format_that_its_name_says(name, packages, tmp_path):
    for package in packages:
        pytest.importorskip(package)
    (tmp_path / name).write_bytes(b"this is no such file" * 20)
    refused(tmp_path / name, [" file that can be read"])


def test_constant_and_still(write, table):
    time, n = table[:, 0], len(table)
    refused(write(("time", "bit_speed"), [time, np.full(n, 3.0)]), ["bit_speed is constant, 3 rad/s from 0 to 12 s"])
    noise = 0.02 * np.random.default_rng(0).standard_normal(n)
    refused(write(("time", "bit_speed", "top_speed"), [time, noise, noise]), ["no motion in bit_speed and top_speed"])


def test_a_sensor_that_is_not_connected_is_left_out(write, table):
    record = read_record(write(("time", "bit_speed", "top_speed"), [table[:, 0], table[:, 1], 0.0 * table[:, 0]]))
    assert list(record.signals) == ["bit_speed"]
    assert "left out: top_speed, which is 0 rad/s at all times" in record.notes


def test_scales_that_no_rig_has(write, table):
    time, bit, top = table.T
    names = ("time", "bit_speed", "top_speed", "speed_reference")
    reference = np.full(len(table), 3.14)
    refused(write(names[:2], [time, bit * RPM]), ["column bit_speed", "65 rad/s", '--map "bit_speed=bit_speed:rpm"'])
    degrees = np.degrees(np.cumsum(bit) * 0.02)
    refused(write(("time", "bit_angle"), [time, degrees]), ["column bit_angle", '--map "bit_angle=bit_angle:deg"'])
    refused(write(names[:3], [time, bit * 8.5, top]), ["bit_speed", "is bit_speed in rpm?", "winds up the string by"])
    refused(write(names, [time, bit * 5, top * 5, reference]), ["top_speed is", "3.14 rad/s", "before the gear"])
    stated = ("time", "bit_speed [rad/s]", "top_speed [rad/s]", "speed_reference")
    refused(write(stated, [time, bit * RPM, top * RPM, reference]), ["is top_speed in rpm?"])
    refused(write(names, [time, bit, top, reference * RPM]), ["is the speed reference in rpm?"])
    refused(write(names, [time, -bit, -top, reference]), ["of opposite sign", "-rpm"])
    turned = {"bit_speed": "bit_speed:-rad/s", "top_speed": "none"}
    record = read_record(write(names, [time, -bit, -top, reference]), turned)
    np.testing.assert_allclose(record.signals["bit_speed"], bit, atol=1e-6)


def test_times_in_another_unit_than_is_written(write, table):
    for factor, unit in ((1e3, "ms"), (1e6, "us")):
        path = write(("time", "bit_speed", "top_speed"), (table * [factor, 1, 1]).T)
        refused(path, ["column time", "periods of stick-slip", "0.02 to 60 s", '--map "time=time:ms"'])
        record = read_record(path, {"time": f"time:{unit}"})
        np.testing.assert_allclose(record.time, table[:, 0], atol=1e-6)
    refused(write(("time [ms]", "bit_speed"), table.T[:2]), ["column time [ms]", "periods of stick-slip"])
    refused(write(("time", "bit_speed"), SLOW.T[:2]), ["a sample each 1 s, and no unit is written", "time:s"])
    assert len(read_record(write(("time [s]", "bit_speed"), SLOW.T[:2])).time) == 20


def test_a_slow_sweep_is_no_record_in_milliseconds(write):
    time = np.arange(0.0, 500.0, 0.5)
    record = read_record(write(("time", "bit_speed"), [time, 5.0 - 4.0 * np.cos(2.0 * np.pi * time / 80.0)]))
    assert len(record.time) == 1000


def test_a_normal_force_below_zero(write, table):
    names, noise = ("time", "bit_speed", "normal_force"), np.sin(table[:, 0])
    record = read_record(write(names, [*table.T[:2], 10.0 + 10.5 * noise]))
    assert record.normal_force.min() == 0.0
    assert any("samples below 0 N are read as 0 N" in note for note in record.notes)
    refused(write(names, [*table.T[:2], -10.0 + noise]), ["normal_force is -11 to -9 N", "normal_force:-N"])


@pytest.mark.parametrize("samples", [2.5, 3.0, 3.5, 5.0, 6.0, 8.0, 20.0])
def test_fewer_than_four_samples_a_period(samples, write):
    period = 2.33
    run = simulate(Rig(), Friction(25.0), speed_reference=3.14, duration=120.0, sample_period=0.01)
    time = np.arange(10.0, 119.0, period / samples)
    bit = np.interp(time, run.time, run.bit_speed)
    path = write(("time [s]", "bit_speed"), [time, bit])
    if samples < 4.0:
        refused(path, ["bit_speed swings from one sample to the next", "four samples or more in a period"])
    else:
        assert len(read_record(path).time) == len(time)


def test_noise_about_a_steady_speed_is_no_alias_and_no_clock_in_another_unit(write):
    rng = np.random.default_rng(0)
    time = np.arange(0.0, 5.0, 0.001)
    for noise in (0.01, 0.05, 0.2):
        speed = 1.0 + noise * rng.standard_normal(len(time))
        assert not is_aliased(speed)
        assert len(read_record(write(("time", "bit_speed"), [time, speed])).time) == len(time)


def test_speeds_that_were_measured_one_after_the_other_are_not_compared(write):
    time = np.arange(0.0, 200.0, 0.05)
    bit, top = np.where(time < 100.0, 5.0 + np.sin(time), np.nan), np.where(time > 50.0, time / 10.0, np.nan)
    top[time < 100.0] = 5.0
    record = read_record(write(("time", "bit_speed", "top_speed"), [time, bit, top]))
    assert np.isnan(record.signals["bit_speed"]).sum() == 2000


@pytest.mark.parametrize(
    ("words", "named"),
    [
        (["Bit_Speed"], ["'Bit_Speed' is not allowed", "COLUMN=QUANTITY:UNIT"]),
        (["=bit_speed:rpm"], ["not allowed"]),
        (["a=bitspeed:rpm"], ["'bitspeed' is not known", "did you mean bit_speed?"]),
        (["a=bit_speed:m/s"], ["'m/s' is no unit of bit_speed", "rad/s, rpm"]),
        (["a=bit_angle:counts/0"], ["no unit of bit_angle", "counts/N"]),
    ],
)
def test_a_map_that_cannot_be_meant(words, named):
    with pytest.raises(ValueError, match=r".") as caught:
        parse_map(words)
    for word in named:
        assert word in str(caught.value)


def test_a_map_names_columns_that_are_there(write, table):
    path = write(("time", "bit_speed", "top_speed"), table.T)
    refused(path, ["column 'bit_sped' is not there", "did you mean bit_speed?"], {"bit_sped": "bit_speed:rpm"})
    refused(path, ["column '#4' is not there"], {"#4": "bit_speed:rpm"})
    refused(path, ["'bit_speed' and 'top_speed' are both bit_speed"], {"#2": "bit_speed", "#3": "bit_speed"})


def test_a_unit_in_brackets_counts_where_a_map_tells_none(write, table):
    record = read_record(write(("t", "Sensor [rpm]"), table.T[:2]), {"Sensor [rpm]": "bit_speed"})
    np.testing.assert_allclose(record.signals["bit_speed"] * RPM, table[:, 1], atol=1e-5)
    refused(write(("t", "Sensor [m/s]"), table.T[:2]), ["'m/s' of column"], {"Sensor [m/s]": "bit_speed"})


def test_a_map_wins_over_names(write, table):
    path = write(("time", "bit_speed", "a=b"), table.T)
    record = read_record(path, parse_map(["a=b=bit_speed:rpm", "BIT_SPEED=top_speed:rad/s"]))
    np.testing.assert_allclose(record.signals["bit_speed"] * RPM, table[:, 2], atol=1e-5)
    np.testing.assert_allclose(record.signals["top_speed"], table[:, 1], atol=1e-6)
    assert "a=b is bit_speed in rpm, as told" in record.notes
    record = read_record(path, {"a=b": "bit_speed:rad/s"})
    assert "left out: bit_speed" in record.notes
