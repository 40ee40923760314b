import numpy as np
import pytest

from drillrig_env import Friction, Rig, simulate
from drillrig_env.cli.own_rig import Usual
from drillrig_env.cli.simulate import main
from drillrig_env.scales import Scales
from tests.rigs import TWO_WINDOWS, scaled


def test_signals_are_those_of_simulate(tmp_path, capsys):
    Rig(k_1=0.9).to_toml(tmp_path / "rig.toml")
    path = tmp_path / "new" / "run.csv"
    words = ["--rig", str(tmp_path / "rig.toml"), "--speed-reference", "0:2", "1:3", "--normal-force", "20"]
    assert main([*words, "--duration", "2", "--csv", str(path)]) == 0
    rig = Rig(k_1=0.9)
    run = simulate(rig, Scales.of(rig).friction, None, [(0, 2.0), (1, 3.0)], 2.0, 0.0102, normal_force=20.0)
    table = np.genfromtxt(path, delimiter=",", names=True)
    assert list(table.dtype.names) == list(run.signals())
    for name, values in run.signals().items():
        np.testing.assert_allclose(table[name], values, rtol=1e-9, atol=1e-12)
    assert str(path) in capsys.readouterr().out


@pytest.mark.parametrize(("speed", "verdict"), [("1.5", "not calm"), ("4", "calm")])
def test_summary_tells_stick_slip_from_calm_rotation(speed, verdict, capsys):
    assert main(["--speed-reference", speed, "--duration", "60", "--normal-force", "0:0", "40:10"]) == 0
    said = capsys.readouterr().out
    assert f"last 10 s: {verdict}; " in said
    assert "critical speed at N_1 = 10 N: 1.99" in said


@pytest.mark.parametrize(("suffix", "change"), [("png", {}), ("svg", {}), ("png", TWO_WINDOWS)])
def test_picture_is_drawn(suffix, change, tmp_path):
    pytest.importorskip("matplotlib", reason="pictures need the extra `plot`")
    path = tmp_path / f"run.{suffix}"
    Rig(**change).to_toml(tmp_path / "rig.toml")
    assert main(["--rig", str(tmp_path / "rig.toml"), "--duration", "5", "--picture", str(path)]) == 0
    assert path.stat().st_size > 5000


@pytest.mark.parametrize(
    ("words", "said"),
    [
        (["--duration", "0"], "argument --duration: '0' is not allowed; allowed: > 0 s"),
        (["--duration", "inf"], "argument --duration: 'inf' is not allowed; allowed: > 0 s"),
        (
            ["--speed-reference", "fast"],
            "argument --speed-reference: 'fast' is not allowed; allowed: a number",
        ),
        (["--speed-reference", "-1"], "speed_reference = -1.0 rad/s is not allowed; allowed: >= 0 rad/s"),
        (["--normal-force", "5:3"], "first time of normal_force = 5.0 s is not allowed"),
        (["--picture", "run.gif"], "--picture run.gif is not allowed; allowed: a name that ends in .png"),
        (["--friction", "nosuch.toml"], "argument --friction: friction: there is no file nosuch.toml"),
        (["--rigs", "3"], "unknown argument --rigs; did you mean --rig?"),
    ],
)
def test_what_is_not_allowed_is_refused_in_a_sentence(words, said, capsys):
    with pytest.raises(SystemExit) as end:
        main(words)
    assert end.value.code == 2
    error = capsys.readouterr().err
    assert error.startswith("drillrig simulate: error: ")
    assert said in error


def test_a_file_that_cannot_be_written_ends_with_code_1(tmp_path, capsys):
    (tmp_path / "file").write_text("")
    assert main(["--duration", "1", "--csv", str(tmp_path / "file" / "run.csv")]) == 1
    assert "error: " in capsys.readouterr().err


@pytest.mark.parametrize(
    ("change", "words", "said"),
    [
        ({}, ["--normal-force", "1e4"], "last 10 s: stuck; bit speed"),
        (
            {"J_1": 1e-12, "J_2": 1e-12, "J_3": 1e-12},
            ["--duration", "0.1", "--sample-period", "0.01"],
            "hold 1 samples; allowed: >= 20)",
        ),
        (
            {"J_1": 1e20, "J_2": 1e20, "J_3": 1e20},
            [],
            "calm or not: ? (Rig: J_2 = 1e+20 kg m^2 is beyond what can be computed",
        ),
        (
            {"L": 0.26, "k_p": 0.0, "k_i": 3.5, "K_E": 0.0, "d_2": 0.0013, "d_1": 0.0076},
            ["--duration", "5"],
            "critical speed at N_1 = 10 N: none, no speed is stable",
        ),
        (
            TWO_WINDOWS,
            [],
            "critical speed at N_1 = 10 N: ? (critical_speed: with N_1 = 10 N this rig is stable at speeds from",
        ),
    ],
)
def test_what_cannot_be_told_of_a_run_is_said_and_not_made_up(change, words, said, tmp_path, capsys):
    Rig(**change).to_toml(tmp_path / "rig.toml")
    usual = ["--duration", "12", "--normal-force", "10", "--speed-reference", "2"]
    assert main(["--rig", str(tmp_path / "rig.toml"), *usual, *words]) == 0
    assert said in capsys.readouterr().out


@pytest.mark.parametrize("factor", [1.0, 0.125, 32.0])
def test_what_is_not_given_belongs_to_the_rig_and_is_said(factor, tmp_path, capsys):
    scaled(time=factor, torque=4.0).to_toml(tmp_path / "rig.toml")
    path = tmp_path / "run.csv"
    assert main(["--rig", str(tmp_path / "rig.toml"), "--csv", str(path)]) == 0
    said = capsys.readouterr().out
    usual = Usual.of(tmp_path / "rig.toml")
    assert usual.speed_reference == pytest.approx(2.0 / factor, rel=5e-3)
    assert usual.duration == pytest.approx(60.0 * factor, rel=5e-3)
    assert usual.sample_period == pytest.approx(0.01 * factor, rel=5e-3)
    assert said.startswith(
        f"the chapter's, in the scales of the rig: normal_force = 10 N, v_b = {factor:.4g} s/rad, speed_reference = "
        f"{usual.speed_reference:g} rad/s, duration = {usual.duration:g} s, sample_period = {usual.sample_period:g} s\n"
    )
    assert "not calm; bit speed" in said
    table = np.genfromtxt(path, delimiter=",", names=True)
    assert len(table) == pytest.approx(6000, abs=60)
    assert table["normal_force"][-1] == usual.friction.normal_force
    assert table["speed_reference"][-1] == usual.speed_reference


def test_what_is_given_is_not_said_to_be_the_rigs(tmp_path, capsys):
    Friction(5.0, v_b=0.7).to_toml(tmp_path / "friction.toml")
    words = ["--speed-reference", "3", "--duration", "5", "--sample-period", "0.02"]
    main(["--normal-force", "12", "--duration", "5"])
    assert capsys.readouterr().out.startswith(
        "the chapter's: v_b = 1 s/rad, speed_reference = 2 rad/s, sample_period = 0.01 s\n"
    )
    main(["--friction", str(tmp_path / "friction.toml"), *words])
    assert capsys.readouterr().out.startswith("last 5 s: ")


def test_the_chapters_rig_and_one_without_scales_are_run_as_ever():
    for rig in (None, Rig(J_1=1e22)):
        usual = Usual.of(rig)
        assert (usual.speed_reference, usual.duration, usual.sample_period) == (2.0, 60.0, 0.01)
        np.testing.assert_array_equal(usual.friction.as_array(), Friction().as_array())
        assert usual.whose == "the chapter's"
