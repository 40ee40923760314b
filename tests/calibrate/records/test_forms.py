"""One record, written as loggers write it, is read as the same record in every form."""

from datetime import datetime, timedelta

import numpy as np
import pytest
from scipy.io import savemat

from drillrig_env.calibrate.records import read_record

RPM = 60.0 / (2.0 * np.pi)
NAMES = ("time", "bit_speed", "top_speed")
UNITS = ("time [s]", "bit_speed [rad/s]", "top_speed [rad/s]")
ISO, GERMAN, US = "2024-05-17T", "17.05.2024 ", "5/17/2024 "


def clock(seconds, fraction="."):
    return f"{int(seconds // 3600) % 24:02d}:{int(seconds // 60) % 60:02d}:{seconds % 60:09.6f}".replace(".", fraction)


def stamps(time, date="", begin=10 * 3600.0, fraction="."):
    return [date + clock(begin + t, fraction) for t in time]


def as_python_writes(time):
    """Without a fraction where there is none."""
    return [str(datetime(2024, 5, 17, 10) + timedelta(seconds=round(t, 6))) for t in time]


def with_summer_ending(time):
    """The clock is put back an hour amid the record, and its zone says so."""
    return [f"2024-10-27T{clock(3 * 3600 - 5 + t - 3600 * (t >= 5))}+0{1 + (t < 5)}:00" for t in time]


def past_midnight(time):
    return [f"2024-02-{28 if t < 5 else 29} {clock(86395 + t)}" for t in time]


def same(record, table, names=("bit_speed", "top_speed")):
    np.testing.assert_allclose(record.time, table[:, 0] - table[0, 0], atol=1e-6)
    assert list(record.signals) == list(names)
    for name in names:
        np.testing.assert_allclose(record.signals[name], table[:, NAMES.index(name)], atol=2e-6)


FORMS = {
    "commas": {},
    "semicolons": {"separator": ";"},
    "tabs": {"separator": "\t"},
    "bars": {"separator": "|"},
    "blanks": {"separator": "   "},
    "a comma and a blank": {"separator": ", "},
    "decimal comma": {"separator": ";", "decimal": ","},
    "decimal comma and tabs": {"separator": "\t", "decimal": ","},
    "decimal comma and blanks": {"separator": "  ", "decimal": ","},
    "decimal comma in quotes": {"quote": '"', "decimal": ","},
    "quotes": {"quote": '"'},
    "byte-order mark": {"encoding": "utf-8-sig"},
    "UTF-16": {"encoding": "utf-16"},
    "UTF-16 without a mark, little end first": {"encoding": "utf-16-le"},
    "UTF-16 without a mark, big end first": {"encoding": "utf-16-be"},
    "CRLF": {"end": "\r\n"},
    "CR": {"end": "\r"},
    "empty lines": {"end": "\n\n"},
    "comments above": {"above": ["# rig 7, measured in May", "% by nobody"]},
    "lines above that are no comments": {"above": ["Rig;7", "Measured in May", ""]},
    "a line above with as many cells": {"above": ["TOA5,CR1000,50"]},
    "units in a row of their own": {"below": ["s,rad/s,rad/s"]},
    "units in brackets in a row of their own": {"below": ["[s],[rad/s],[rad/s]"]},
    "units and another row": {"below": ["s,rad/s,rad/s", "Smp,Smp,Avg"]},
}


@pytest.mark.parametrize("form", FORMS)
def test_text(form, write, table):
    same(read_record(write(NAMES, table.T, **FORMS[form])), table)


@pytest.mark.parametrize("seed", range(40))
def test_any_combination_of_forms(seed, write, table):
    rng = np.random.default_rng(seed)
    separator, decimal = [(",", "."), (";", "."), (";", ","), ("\t", ","), ("|", "."), ("  ", ",")][rng.integers(6)]
    factors = np.array([[1.0, 1e3][rng.integers(2)], [1.0, RPM][rng.integers(2)], [1.0, 6.0 * RPM][rng.integers(2)]])
    pairs = [("s", "ms"), ("rad/s", "rpm"), ("rad/s", "°/s")]
    units = [pair[int(factor > 1.0)] for pair, factor in zip(pairs, factors, strict=True)]
    order = rng.permutation(3)
    in_names = rng.random() < 0.5
    names = [f"{NAMES[k]}[{units[k]}]" if in_names else NAMES[k] for k in order]
    path = write(
        names,
        (table * factors)[:, order].T,
        separator=separator,
        decimal=decimal,
        encoding=str(rng.choice(["utf-8", "utf-8-sig", "utf-16", "utf-16-be", "cp1252"])),
        end=str(rng.choice(["\n", "\r\n", "\r"])),
        above=["# rig 7", "", "Measured in May"][: rng.integers(4)],
        below=[] if in_names else [separator.join(units[k] for k in order)],
        quote='"' if separator == ";" and rng.random() < 0.5 else "",
    )
    record = read_record(path)
    np.testing.assert_allclose(record.time, table[:, 0], atol=1e-6)
    np.testing.assert_allclose(record.signals["bit_speed"], table[:, 1], atol=2e-6)
    np.testing.assert_allclose(record.signals["top_speed"], table[:, 2], atol=2e-6)


SPELLINGS = {
    "units in brackets": (UNITS, (1, 1, 1)),
    "units in parentheses": (("Time (s)", "Bit Speed (rad/s)", "Top Speed (rad/s)"), (1, 1, 1)),
    "capitals and blanks": ((" TIME", "Bit_Speed ", "TopSpeed"), (1, 1, 1)),
    "rpm": (("t [s]", "Bit RPM", "top_speed_rpm"), (1, RPM, RPM)),
    "turns a minute": (("t_s", "bit_speed [1/min]", "Top-Speed (U/min)"), (1, RPM, RPM)),
    "degrees": (("elapsed", "bit_speed_deg_s", "top speed [°/s]"), (1, 6 * RPM, 6 * RPM)),
    "turns a second": (("time / s", "bit_speed in rev/s", "top_speed rps"), (1, RPM / 60, RPM / 60)),
    "milliseconds": (("t_ms", "omega_bit", "omega_top"), (1e3, 1, 1)),
    "microseconds": (("Time (µs)", "omega_bit", "omega_top"), (1e6, 1, 1)),
    "minutes": (("Zeit [min]", "bit_speed", "top_speed"), (1 / 60, 1, 1)),
    "since 1970": (("timestamp", "bit_speed", "top_speed"), (1, 1, 1)),
}


@pytest.mark.parametrize("spelling", SPELLINGS)
@pytest.mark.parametrize("encoding", ["utf-8", "cp1252"])
def test_names_and_units(spelling, encoding, write, table):
    names, factors = SPELLINGS[spelling]
    columns = table * factors
    if spelling == "minutes" or "second" in spelling:
        columns = np.round(columns, 6)
        table = columns / factors
    if spelling == "since 1970":
        columns[:, 0] += 1.7e9
    record = read_record(write(names, columns.T, encoding=encoding))
    np.testing.assert_allclose(record.time, table[:, 0], atol=4e-5)
    np.testing.assert_allclose(record.signals["bit_speed"], table[:, 1], atol=4e-6)
    np.testing.assert_allclose(record.signals["top_speed"], table[:, 2], atol=4e-6)


@pytest.mark.parametrize(
    "written",
    [
        lambda time: stamps(time),
        lambda time: stamps(time, begin=86395.0),
        lambda time: stamps(time, ISO),
        lambda time: [f"{stamp}Z" for stamp in stamps(time, ISO)],
        lambda time: [f"{stamp}+02:00" for stamp in stamps(time, ISO)],
        lambda time: stamps(time, "2024-05-17 "),
        lambda time: stamps(time, "2024/05/17 "),
        lambda time: stamps(time, GERMAN, fraction=","),
        lambda time: stamps(time, US),
        lambda time: [f"{stamp} AM" for stamp in stamps(time, US)],
        lambda time: [stamp.lstrip("0") for stamp in stamps(time, begin=35990.0)],
        lambda time: [f"{int(t // 60):02d}:{t % 60:09.6f}" for t in time + 50.0],
        past_midnight,
        as_python_writes,
        with_summer_ending,
    ],
)
def test_time_stamps(written, write, table):
    same(read_record(write(NAMES, [written(table[:, 0]), *table.T[1:]], separator=";")), table)


def test_a_day_and_a_month_that_could_be_either_make_the_shorter_record(write, table):
    for before, after in (("01/02/2024 ", "02/02/2024 "), ("01/02/2024 ", "01/03/2024 ")):
        time = [(before if t < 5 else after) + clock(86395 + t) for t in table[:, 0]]
        same(read_record(write(NAMES, [time, *table.T[1:]])), table)


def test_a_header_that_is_a_comment_and_none_at_all(write, table, tmp_path):
    np.savetxt(tmp_path / "a.txt", table, "%.6f", header=" ".join(NAMES))
    same(read_record(tmp_path / "a.txt"), table)
    np.savetxt(tmp_path / "b.txt", table, "%.6f")
    same(read_record(tmp_path / "b.txt", {"#1": "time:s", "#2": "bit_speed", "#3": "top_speed:rad/s"}), table)


LABVIEW = (
    "LabVIEW Measurement\t\nSeparator\tTab\nDate\t2024/05/17\nTime\t10:00:00,1234\n***End_of_Header***\t\n\t\n"
    "Channels\t2\t\t\nSamples\t601\t601\t\nTime\t10:00:00\t10:00:00\t\nDelta_X\t0,02\t0,02\n***End_of_Header***\t\t\t"
)
CAMPBELL = (
    '"TOA5","CR","CR1000"\n"TIMESTAMP","BitSpeed","TopSpeed","WOB"\n"TS","rad/s","rad/s","kN"\n"","Smp","Avg","Avg"'
)


def test_files_of_known_loggers(write, table):
    names = ("X_Value", "Bit Speed", "Top Speed", "Comment")
    path = write(names, table.T, separator="\t", decimal=",", above=LABVIEW.split("\n"))
    same(read_record(path), table)
    columns = [as_python_writes(table[:, 0]), *table.T[1:], np.full(len(table), 0.025)]
    record = read_record(write((), columns, above=CAMPBELL.split("\n")))
    same(record, table)
    assert set(record.normal_force) == {25.0}
    assert not any("dropped" in note for note in record.notes)
    same(read_record(write(NAMES, table.T, separator=";", decimal=",", above=["sep=;"])), table)


def test_columns_of_other_things_are_listed_and_left_out(write, table):
    index, state = [str(i) for i in range(len(table))], ["ok", "warm"] * 300 + ["ok"]
    names = ("", "time", "bit_speed", "state", "oil temperature [°C]", "top_speed", "torque", "")
    columns = [index, table[:, 0], table[:, 1], state, table[:, 1], table[:, 2], table[:, 0], [""] * len(table)]
    record = read_record(write(names, columns))
    same(record, table)
    assert "left out: #1, state, oil temperature [°C], torque" in record.notes


def test_all_that_a_rig_has_and_its_inputs(run, tmp_path):
    path = tmp_path / "run.csv"
    table = np.column_stack(list(run.signals().values()))
    np.savetxt(path, table, "%.17g", ",", header=",".join(run.signals()), comments="")
    record = read_record(path)
    for name in ("bit_speed", "collar_speed", "top_speed", "current", "voltage", "torque_into_string"):
        np.testing.assert_array_equal(record.signals[name], run.signals()[name])
    np.testing.assert_array_equal(record.speed_reference, run.speed_reference)
    np.testing.assert_array_equal(record.normal_force, run.normal_force)
    assert len(record.digest) == 64
    assert "left out: twist_12, twist_23, speed_error_integral, friction_torque" in record.notes


def test_quantities_in_the_units_of_the_field(write, table):
    n = len(table)
    names = ("time", "top_rpm", "WOB [klbf]", "rpm_setpoint", "string torque [kft.lb]", "motor current [mA]", "voltage")
    columns = [table[:, 0], table[:, 2] * RPM, np.full(n, 2.0), np.full(n, 30.0), *[np.linspace(1.0, 2.0, n)] * 3]
    record = read_record(write(names, columns, separator=";"))
    np.testing.assert_allclose(record.normal_force, 8896.443230521)
    np.testing.assert_allclose(record.speed_reference, np.pi)
    assert record.signals["torque_into_string"][-1] == pytest.approx(2.0 * 1355.8179483)
    assert record.signals["current"][-1] == pytest.approx(2e-3)
    assert record.signals["voltage"][-1] == 2.0


def test_values_that_are_missing_are_masked_and_inputs_go_on(write, table):
    columns = [[f"{value:.6f}" for value in column] for column in [*table.T, np.full(len(table), 3.14)]]
    for row, cell in enumerate(("", "NaN", "N/A", "inf", "-999.25", "Over")):
        columns[1][100 + row] = cell
    columns[3][50] = ""
    record = read_record(write((*NAMES, "speed_reference"), columns))
    masked = np.flatnonzero(np.isnan(record.signals["bit_speed"]))
    assert masked.tolist() == [100, 101, 102, 103, 104, 105]
    assert "bit_speed: 6 samples without a value, 'Over' among them" in record.notes
    assert set(record.speed_reference) == {3.14}


def test_lines_that_end_too_early_and_headers_in_between(write, table):
    path = write(NAMES, table.T)
    lines = path.read_text().split("\n")
    lines[300:300] = [lines[0], "# the logger went on", ""]
    lines[-2] = lines[-2].rpartition(",")[0]
    path.write_text("\n".join(lines))
    record = read_record(path)
    np.testing.assert_allclose(record.signals["bit_speed"], table[:, 1], atol=1e-6)
    assert np.flatnonzero(np.isnan(record.signals["top_speed"])).tolist() == [600]
    assert "lines that end too early: 1, the first is line 605" in record.notes
    assert not any("dropped" in note for note in record.notes)


def test_a_cell_with_two_numbers_holds_none(write, table):
    columns = [[f"{value:.6f}" for value in column] for column in table.T]
    columns[1][300] = "1.5 2.5"
    record = read_record(write(NAMES, columns))
    assert np.flatnonzero(np.isnan(record.signals["bit_speed"])).tolist() == [300]


def test_numbers_in_every_form_of_writing(write, table):
    columns = [
        [f"{value:{form}}" for value in column] for column, form in zip(table.T, ("g", ".9e", "+.9E"), strict=True)
    ]
    same(read_record(write(NAMES, columns, separator="\t")), table)


def test_more_lines_than_are_read_at_once(tmp_path, table, monkeypatch):
    monkeypatch.setattr("drillrig_env.calibrate.records.text._PIECE", 1000)
    path = tmp_path / "run.csv"
    np.savetxt(path, table, "%.6f", ";", header=";".join(NAMES), comments="")
    same(read_record(path), table)
    text = path.read_text().replace(f"{table[321, 1]:.6f}", "?", 1)
    path.write_text(text)
    place = int(np.flatnonzero(np.isnan(read_record(path).signals["bit_speed"]))[0])
    assert table[place, 1] == table[321, 1]


@pytest.mark.parametrize("compressed", [True, False])
def test_matlab(table, tmp_path, compressed):
    time, bit, top = table.T
    forms = [
        ({"time": time, "bit_speed": bit, "top_speed": top, "rate": 50.0, "rig": "seven"}, None),
        ({"run": {"t": time[:, None], "omega_bit": bit, "top": {"top_rpm": top * RPM}}, "more": np.arange(7.0)}, None),
        ({"data": table.T}, {"data(1)": "time:s", "data(2)": "bit_speed", "data(3)": "top_speed:rad/s"}),
        ({"data": table}, {"data(1)": "time:s", "data(2)": "bit_speed", "data(3)": "top_speed:rad/s"}),
    ]
    for content, columns in forms:
        savemat(tmp_path / "run.mat", content, do_compression=compressed)
        same(read_record(tmp_path / "run.mat", columns), table)


def test_parquet_and_excel(table, tmp_path):
    pandas = pytest.importorskip("pandas")
    pytest.importorskip("pyarrow")
    pytest.importorskip("openpyxl")
    frame = pandas.DataFrame(table * [1e3, RPM, 1], columns=["t [ms]", "bit_rpm", "top_speed"])
    dated = frame.drop(columns="t [ms]").set_index(
        pandas.Timestamp("2024-05-17 23:59:55") + pandas.to_timedelta(table[:, 0], "s")
    )
    frame["state"] = "ok"
    for each in (frame, dated):
        each.to_parquet(tmp_path / "run.parquet")
        each.to_excel(tmp_path / "run.xlsx")
        for name in ("run.parquet", "run.xlsx"):
            same(read_record(tmp_path / name), table)
    dated.tz_localize("Europe/Berlin").to_parquet(tmp_path / "run.parquet")
    same(read_record(tmp_path / "run.parquet"), table)


def test_tdms(table, tmp_path):
    nptdms = pytest.importorskip("nptdms")
    time, bit, top = table.T
    dates = np.datetime64("2024-05-17T10:00:00", "us") + np.round(time * 1e6).astype("m8[us]")
    waveform = {"wf_increment": 0.02, "wf_start_offset": 0.0, "unit_string": "rpm"}
    forms = [
        [("Time", time, {}), ("Bit Speed", bit, {}), ("Top Speed", top, {})],
        [("Time", dates, {}), ("Bit Speed", bit * RPM, {"NI_UnitDescription": "rpm"}), ("omega_top", top, {})],
        [("Bit Speed", bit * RPM, waveform), ("Top Speed", top * RPM, waveform), ("oil", np.arange(9.0), {})],
    ]
    for form in forms:
        with nptdms.TdmsWriter(tmp_path / "run.tdms") as file:
            file.write_segment([nptdms.ChannelObject("run", *channel) for channel in form])
        same(read_record(tmp_path / "run.tdms"), table)


@pytest.mark.parametrize(
    ("name", "package", "what"),
    [
        ("run.tdms", "nptdms", "a TDMS file needs npTDMS"),
        ("run.parquet", "pandas", "a Parquet file needs pandas and pyarrow"),
        ("run.xlsx", "pandas", "an Excel file needs pandas and openpyxl"),
    ],
)
def test_a_format_whose_package_is_missing_says_what_to_install(name, package, what, tmp_path, monkeypatch):
    monkeypatch.setitem(__import__("sys").modules, package, None)
    (tmp_path / name).write_bytes(b"")
    with pytest.raises(ImportError, match=rf"{what}; in a clone of DrillRig: pip install -e '.\[records\]'"):
        read_record(tmp_path / name)
