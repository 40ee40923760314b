import subprocess
import sys
from dataclasses import replace

import numpy as np
import pytest

from drillrig_env import Friction, Rig, simulate
from drillrig_env.calibrate.measured import main, reproduce, score_record
from drillrig_env.calibrate.records import Record, read_record
from drillrig_env.cli.simulate import main as simulate_main
from drillrig_env.model import steady_state
from drillrig_env.simulation import SIGNALS

LOADED = {"speed_reference": 3.14, "normal_force": [(0, 0.0), (5, 25.0)]}
ON_THE_COMMAND_LINE = ["--speed-reference", "3.14", "--normal-force", "0:0", "5:25"]
SPEEDS = ("bit_speed", "collar_speed", "top_speed")


def write(path, time, **signals):
    table = np.column_stack([time, *signals.values()])
    np.savetxt(path, table, "%.17g", ",", header=",".join(["time", *signals]), comments="")
    return path


@pytest.fixture
def run():
    return simulate(**LOADED, duration=15.0, sample_period=0.05)


@pytest.fixture
def path(tmp_path, run):
    """What a perfect rig would measure, on a clock that is already running."""
    return write(tmp_path / "run.csv", run.time + 7.0, **{name: getattr(run, name) for name in SPEEDS})


def test_round_trip_is_a_perfect_match(path):
    scores = score_record(read_record(path), **LOADED)
    assert [(s.signal, s.part, s.samples) for s in scores] == [
        (name, part, samples) for name in SPEEDS for part, samples in (("first 10 s", 201), ("whole file", 301))
    ]
    for score in scores:
        assert score.correlation == pytest.approx(1.0, abs=1e-9)
        assert score.amplitude_pulse_level == pytest.approx(0.0, abs=1e-5)


@pytest.mark.parametrize("change", [{"speed_reference": 3.0}, {"normal_force": 25.0}, {"rig": Rig(k_2=0.5)}])
def test_another_rig_or_run_is_no_perfect_match(path, change):
    bit = score_record(read_record(path), **{**LOADED, **change})[1]
    assert bit.correlation < 0.999
    assert bit.amplitude_pulse_level > 1e-4


def test_what_simulate_writes_is_read(tmp_path):
    file = tmp_path / "run.csv"
    assert simulate_main(["--duration", "5", "--csv", str(file)]) == 0
    assert set(SIGNALS) == set(file.read_text().split("\n")[0].split(","))
    assert list(read_record(file).speeds) == ["bit_speed", "collar_speed", "top_speed"]


def test_masked_samples_do_not_count(path, run):
    record = read_record(path)
    bit = record.signals["bit_speed"].copy()
    bit[100:120] = np.nan
    scores = score_record(replace(record, signals={**record.signals, "bit_speed": bit}), **LOADED)
    assert [(score.signal, score.samples) for score in scores[1:4:2]] == [("bit_speed", 281), ("collar_speed", 301)]
    assert scores[1].correlation == pytest.approx(1.0, abs=1e-9)


def test_times_between_samples_of_the_simulation_are_interpolated():
    time = np.array([0.0123456, 0.5, 1.7654321])
    model = reproduce(Record("run", "", time, dict.fromkeys(SPEEDS, time)), **LOADED)
    fine = simulate(**LOADED, duration=1.8, sample_period=1e-4)
    for name in SPEEDS:
        np.testing.assert_allclose(model[name], np.interp(time, fine.time, getattr(fine, name)), atol=5e-3)


def test_steady_start_stays_in_the_steady_rotation_of_the_first_inputs():
    record = Record("run", "", np.linspace(0.0, 2.0, 21), {"bit_speed": np.full(21, 4.0)})
    inputs = {"speed_reference": [(0, 4.0), (1, 5.0)], "normal_force": [(0, 20.0)]}
    bit = reproduce(record, start="steady", **inputs)["bit_speed"]
    np.testing.assert_allclose(bit[:11], steady_state(Rig(), Friction(20.0), 4.0)[2], rtol=1e-9)
    assert bit[20] > 4.1
    assert reproduce(record, start="rest", **inputs)["bit_speed"][0] == 0.0


@pytest.mark.parametrize(
    ("first", "arguments", "words"),
    [
        (0.0, {"start": "steady", "speed_reference": 0.0}, ["first speed_reference", "0.0 rad/s", "> 0"]),
        (0.0, {"start": "steadily", "speed_reference": 1.0}, ["did you mean steady?", "rest"]),
        (-1.0, {"speed_reference": 1.0}, ["first time", "-1.0 s", ">= 0 s"]),
        (0.0, {"speed_reference": [(1, 2.0)]}, ["first time of speed_reference", "1.0 s"]),
    ],
)
def test_what_the_model_cannot_reproduce_is_named(first, arguments, words):
    record = Record("run", "", np.array([first, 1.0]), {"bit_speed": np.zeros(2)})
    with pytest.raises(ValueError, match=r".") as caught:
        reproduce(record, **arguments)
    for word in words:
        assert word in str(caught.value)


def test_command_line_prints_the_table_and_writes_both_signals(path, run, tmp_path):
    output = tmp_path / "both.csv"
    command = [
        sys.executable,
        "-m",
        "drillrig_env.calibrate.measured",
        str(path),
        *ON_THE_COMMAND_LINE,
        "--output",
        str(output),
    ]
    done = subprocess.run(command, capture_output=True, text=True, check=False)
    assert done.returncode == 0
    assert f"{path}: bit_speed is bit_speed in rad/s, as no unit is written" in done.stderr.splitlines()
    lines = done.stdout.splitlines()
    assert lines[0].split() == ["signal", "part", "samples", "P_C", "APL"]
    assert lines[1].split() == ["bit_speed", "first", "10", "s", "201", "1.000", "0.000"]
    assert lines[6].split() == ["top_speed", "whole", "file", "301", "1.000", "0.000"]
    columns = np.genfromtxt(output, delimiter=",", names=True)
    assert columns.dtype.names[:3] == ("time", "bit_speed", "bit_speed_model")
    np.testing.assert_allclose(columns["time"], run.time, atol=1e-9)
    for name in SPEEDS:
        np.testing.assert_allclose(columns[name], getattr(run, name), atol=1e-8)
        np.testing.assert_allclose(columns[f"{name}_model"], getattr(run, name), atol=1e-5)


def test_command_line_takes_rig_friction_start_and_window(path, tmp_path, capsys):
    Rig(k_2=0.5).to_toml(tmp_path / "rig.toml")
    Friction(1.0, mu_s=0.4).to_toml(tmp_path / "friction.toml")
    files = ["--rig", str(tmp_path / "rig.toml"), "--friction", str(tmp_path / "friction.toml")]
    main([str(path), *ON_THE_COMMAND_LINE, *files, "--start", "steady", "--start-time", "12", "--window", "4"])
    early, whole = (line.split() for line in capsys.readouterr().out.splitlines()[1:3])
    record = read_record(path).since(12.0)
    model = {"rig": Rig(k_2=0.5), "friction": Friction(mu_s=0.4), "start": "steady", "window": 4.0}
    score = score_record(record, **LOADED, **model)[1]
    indicators = [f"{score.correlation:.3f}", f"{score.amplitude_pulse_level:.3f}"]
    assert early[:5] == ["bit_speed", "first", "4", "s", "81"]
    assert whole == ["bit_speed", "whole", "file", "201", *indicators]


@pytest.mark.parametrize(
    ("changes", "words"),
    [
        (["--normal-force", "25N"], ["--normal-force", "'25N'", "time:value"]),
        (["--normal-force", "1:2:3"], ["--normal-force", "'1:2:3'"]),
        (["--normal-force", "50:25"], ["first time of normal_force", "50.0 s"]),
        (["--speed-reference", "-1"], ["speed_reference", "-1.0 rad/s"]),
        (["--window", "0"], ["window = 0.0 s", ">= 0.05 s"]),
        (["--start-time", "0"], ["start_time = 0.0 s", ">= 7"]),
        (["--map", "bit_speed=bit_speed:m/s"], ["'m/s' is no unit of bit_speed"]),
        (["--map", "bit=bit_speed:rpm"], ["run.csv", "column 'bit' is not there"]),
        (["--speed-reference", "30"], ["run.csv", "is the speed reference in rpm?"]),
        (["--rig", "no_such_rig.toml"], ["no_such_rig.toml"]),
        (["--output", "run.csv"], ["--output", "the measurement itself"]),
    ],
)
def test_command_line_ends_with_2_and_names_what_is_wrong(path, capsys, monkeypatch, changes, words):
    monkeypatch.chdir(path.parent)
    before = path.read_bytes()
    with pytest.raises(SystemExit) as caught:
        main(["run.csv", *ON_THE_COMMAND_LINE, *changes])
    assert caught.value.code == 2
    message = capsys.readouterr().err.splitlines()[-2]
    for word in words:
        assert word in message
    assert path.read_bytes() == before


def test_inputs_that_were_recorded_need_not_be_told(tmp_path, capsys):
    run = simulate(speed_reference=[(0, 3.14), (8, 2.5)], normal_force=[(0, 0.0), (5, 25.0)], duration=15.0)
    path = tmp_path / "run.csv"
    columns = {"time": run.time, "bit_speed": run.bit_speed, "speed_reference": run.speed_reference}
    table = {**columns, "normal_force": run.normal_force}
    np.savetxt(path, np.column_stack(list(table.values()))[::5], "%.17g", ",", header=",".join(table), comments="")
    assert main([str(path)]) == 0
    assert capsys.readouterr().out.splitlines()[2].split()[-2:] == ["1.000", "0.000"]
    for missing in ("speed_reference", "normal_force"):
        with pytest.raises(SystemExit):
            main([str(path), "--map", f"{missing}=none"])
        assert f"{missing} (" in (told := capsys.readouterr().err.splitlines()[-2])
        assert f"--{missing.replace('_', '-')}" in told


def test_command_line_maps_columns(run, tmp_path, capsys):
    path = tmp_path / "run.txt"
    table = np.column_stack([1e3 * run.time, run.bit_speed * 30.0 / np.pi, run.top_speed])
    np.savetxt(path, table, "%.9g", ";", header="T;Sensor 2;Sensor 3", comments="")
    assert main([str(path), *ON_THE_COMMAND_LINE, "--map", "T=time:ms", "Sensor 2=bit_speed:rpm"]) == 0
    told = capsys.readouterr()
    assert told.out.splitlines()[2].split() == ["bit_speed", "whole", "file", "301", "1.000", "0.000"]
    assert f"{path}: left out: Sensor 3" in told.err.splitlines()
