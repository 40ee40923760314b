import subprocess
import sys

import numpy as np
import pytest

from drillrig_env import Friction, Rig, simulate
from drillrig_env.calibrate.measured import Measurement, main, read_measurement, reproduce, score_measurement
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
    scores = score_measurement(read_measurement(path), **LOADED)
    assert [(s.signal, s.part, s.samples) for s in scores] == [
        (name, part, samples) for name in SPEEDS for part, samples in (("first 10 s", 201), ("whole file", 301))
    ]
    for score in scores:
        assert score.correlation == pytest.approx(1.0, abs=1e-9)
        assert score.amplitude_pulse_level == pytest.approx(0.0, abs=1e-5)


@pytest.mark.parametrize("change", [{"speed_reference": 3.0}, {"normal_force": 25.0}, {"rig": Rig(k_2=0.5)}])
def test_another_rig_or_run_is_no_perfect_match(path, change):
    bit = score_measurement(read_measurement(path), **{**LOADED, **change})[1]
    assert bit.correlation < 0.999
    assert bit.amplitude_pulse_level > 1e-4


def test_what_simulate_writes_is_read_and_what_has_no_speed_is_passed_over(tmp_path):
    file = tmp_path / "run.csv"
    assert simulate_main(["--duration", "5", "--csv", str(file)]) == 0
    assert set(SIGNALS) == set(file.read_text().split("\n")[0].split(","))
    measured = read_measurement(file)
    assert list(measured.signals) == ["bit_speed", "collar_speed", "top_speed"]
    file.write_text("time,current\n0,1\n1,1\n")
    with pytest.raises(ValueError, match="no speed beside time"):
        read_measurement(file)


def test_columns_in_any_order_quotes_spaces_empty_lines_and_the_first_sample_as_zero(tmp_path):
    path = tmp_path / "run.csv"
    path.write_bytes(b'\xef\xbb\xbf"top_speed", time\r\n 1.5,20\r\n\r\n2.5 ,"20.5"\r\n')
    measurement = read_measurement(path)
    assert measurement.time.tolist() == [0.0, 0.5]
    assert {name: signal.tolist() for name, signal in measurement.signals.items()} == {"top_speed": [1.5, 2.5]}


def test_start_time_is_on_the_clock_of_the_file(tmp_path):
    path = write(tmp_path / "run.csv", [20.0, 21.0, 22.0, 23.0], bit_speed=[0.0, 1.0, 2.0, 3.0])
    measurement = read_measurement(path, start_time=20.5)
    assert measurement.time.tolist() == [0.5, 1.5, 2.5]
    assert measurement.signals["bit_speed"].tolist() == [1.0, 2.0, 3.0]
    for start_time in (19.0, 22.5, float("nan")):
        with pytest.raises(ValueError, match=rf"run\.csv: start_time = {start_time} s .* >= 20.0 and <= 22.0 s"):
            read_measurement(path, start_time)


@pytest.mark.parametrize(
    ("text", "words"),
    [
        ("", ["line 1, column 1", "header", "time, bit_speed"]),
        ("0.0,1.0\n0.1,2.0\n", ["line 1, column 1", "header"]),
        ("bit_speed\n1.0\n2.0\n", ["line 1, column time", "missing", "bit_speed"]),
        ("time\n0.0\n0.1\n", ["line 1, column 2", "no speed", "bit_speed, collar_speed, top_speed"]),
        ("time,bitspeed\n0,1\n1,2\n", ["line 1, column 2", "'bitspeed'", "did you mean bit_speed?"]),
        ("time;bit_speed\n0;1\n1;2\n", ["line 1, column 1", "'time;bit_speed'", "allowed: time, "]),
        ("\ntime,bit_speed,time\n0,1,0\n1,2,1\n", ["line 2, column 3", "time is there twice"]),
        ("time,bit_speed\n0,1\n1,fast\n", ["line 3, column bit_speed", "'fast'", "finite number"]),
        ("time,bit_speed\n0,1\n\n1,nan\n", ["line 4, column bit_speed", "'nan'", "finite number"]),
        ("time,bit_speed\n0,1\ninf,1\n", ["line 3, column time", "'inf'", "finite number"]),
        ("time,bit_speed\n0,\n1,2\n", ["line 2, column bit_speed", "''", "finite number"]),
        ("time,bit_speed\n0,1\n1,2\xb5\n", ["line 3, column bit_speed", "finite number"]),
        ("time,bit_speed\n0,1\n1\n", ["line 3, column bit_speed", "no cell", "2"]),
        ("time,bit_speed\n0,1\n1,2,3\n", ["line 3, column 3", "too many", "2"]),
        ('time,bit_speed\n0,"1\n1,2,3\n', ["line 3, column 3", "too many"]),
        ("time,bit_speed\n0,1\n1,2\n1,3\n", ["line 4, column time", "1.0 s", "> 1.0 s"]),
        ("bit_speed,time\n1,5\n\n2,4\n", ["line 4, column time", "4.0 s", "> 5.0 s"]),
        ("time,bit_speed\n", ["line 1, column time", "samples in the file: 0", ">= 2"]),
        ("time,bit_speed\n0,1\n", ["line 2, column time", "samples in the file: 1", ">= 2"]),
    ],
)
def test_bad_file_names_line_and_column(tmp_path, text, words):
    path = tmp_path / "bad.csv"
    path.write_text(text, encoding="latin-1")
    with pytest.raises(ValueError, match=r"bad\.csv, line \d+, column \w+: ") as caught:
        read_measurement(path)
    for word in words:
        assert word in str(caught.value)


def test_times_between_samples_of_the_simulation_are_interpolated():
    time = np.array([0.0123456, 0.5, 1.7654321])
    model = reproduce(Measurement(time, dict.fromkeys(SPEEDS, time)), **LOADED)
    fine = simulate(**LOADED, duration=1.8, sample_period=1e-4)
    for name in SPEEDS:
        np.testing.assert_allclose(model[name], np.interp(time, fine.time, getattr(fine, name)), atol=5e-3)


def test_steady_start_stays_in_the_steady_rotation_of_the_first_inputs():
    measurement = Measurement(np.linspace(0.0, 2.0, 21), {"bit_speed": np.full(21, 4.0)})
    inputs = {"speed_reference": [(0, 4.0), (1, 5.0)], "normal_force": [(0, 20.0)]}
    bit = reproduce(measurement, start="steady", **inputs)["bit_speed"]
    np.testing.assert_allclose(bit[:11], steady_state(Rig(), Friction(20.0), 4.0)[2], rtol=1e-9)
    assert bit[20] > 4.1
    assert reproduce(measurement, start="rest", **inputs)["bit_speed"][0] == 0.0


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
    measurement = Measurement(np.array([first, 1.0]), {"bit_speed": np.zeros(2)})
    with pytest.raises(ValueError, match=r".") as caught:
        reproduce(measurement, **arguments)
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
    assert (done.returncode, done.stderr) == (0, "")
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
    measurement = read_measurement(path, start_time=12.0)
    model = {"rig": Rig(k_2=0.5), "friction": Friction(mu_s=0.4), "start": "steady", "window": 4.0}
    score = score_measurement(measurement, **LOADED, **model)[1]
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
        (["--start-time", "0"], ["start_time = 0.0 s", ">= 7.0"]),
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
    message = capsys.readouterr().err.splitlines()[0]
    for word in words:
        assert word in message
    assert path.read_bytes() == before
