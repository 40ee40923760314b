import warnings
from dataclasses import replace

import pytest

from drillrig_env import Friction, Rig
from drillrig_env.cli.info import main
from drillrig_env.stability import critical_speed, fold_speed, stick_slip_orbit
from tests.rigs import scaled

_WINDOW = {"L": 0.07, "k_p": 0.08, "k_i": 7.4, "K_E": 0.0835, "d_2": 0.0036, "d_1": 0.95, "J_3": 2.7, "J_1": 0.147,
           "J_2": 0.0077, "k_1": 0.0106, "k_2": 18.0}  # fmt: skip
"""A drive that shakes by itself but in a window of friction slopes."""


def number(text, name):
    line = next(line for line in text.splitlines() if line.startswith(f"{name} "))
    return float(line.split()[1])


@pytest.mark.parametrize("force", [10.0, 20.0])
def test_critical_speed_and_fold_are_those_of_the_rig_at_the_normal_force(force, capsys):
    assert main(["--normal-force", str(force)]) == 0
    text = capsys.readouterr().out
    friction = Friction(force)
    assert number(text, "omega_c") == pytest.approx(critical_speed(Rig(), friction), abs=5e-4)
    assert number(text, "fold") == pytest.approx(fold_speed(Rig(), friction), abs=5e-4)
    assert "table 4.1" in text
    assert "identified" in text
    assert "0.4291, 1.822" in text


def test_orbit_at_a_speed_reference(capsys):
    main(["--speed-reference", "2"])
    text = capsys.readouterr().out
    orbit = stick_slip_orbit(Rig(), Friction(), 2.0)
    assert number(text, "period") == pytest.approx(orbit.period, abs=5e-4)
    assert number(text, "stuck") == pytest.approx(orbit.stuck, abs=5e-4)
    main(["--speed-reference", "9"])
    assert "at 9 rad/s: " in capsys.readouterr().out


def test_a_rig_without_stick_slip_says_so(capsys):
    assert main(["--normal-force", "0"]) == 0
    text = capsys.readouterr().out
    assert "no stick-slip: friction is too weak" in text


def test_files_are_written_and_never_over_others(tmp_path, capsys):
    rig, friction = tmp_path / "rig.toml", tmp_path / "friction.toml"
    assert main(["--write", str(rig), "--write-friction", str(friction), "--normal-force", "25"]) == 0
    assert Rig.of(rig) == Rig()
    assert Friction.of(friction).normal_force == 25.0
    with pytest.raises(SystemExit) as end:
        main(["--write", str(rig)])
    assert end.value.code == 2
    assert f"{rig} is there already" in capsys.readouterr().err


def test_impossible_numbers_are_refused_with_unit_and_range(capsys):
    for words, said in (
        (["--normal-force", "-1"], "argument --normal-force: '-1' is not allowed; allowed: >= 0 N"),
        (["--normal-force", "much"], "argument --normal-force: 'much' is not allowed; allowed: >= 0 N"),
        (["--speed-reference", "0"], "argument --speed-reference: '0' is not allowed; allowed: > 0 rad/s"),
    ):
        with pytest.raises(SystemExit) as end:
            main(words)
        assert end.value.code == 2
        assert said in capsys.readouterr().err


@pytest.mark.parametrize(
    ("change", "said"),
    [
        ({"J_1": 1e-5}, "a load under which stick-slip is found and can be followed"),
        ({"r_1": 700.0}, "fold          ?              rad/s      end_of_stick_slip: N_1 = 10 N is not allowed"),
        (
            {"J_1": 1e200},
            "fold          ?              rad/s      Rig: J_1 = 1e+200 kg m^2 is beyond what can be computed",
        ),
        (
            {"K_T": 1e-300},
            "fold          ?              rad/s      Rig: K_T = 1e-300 N m/A is beyond what can be computed",
        ),
        ({"k_p": 0.0, "k_i": 30.0, "K_E": 0.0}, "no speed is stable"),
        (_WINDOW, "critical_slope: this rig is stable for friction slopes from -0.947191 to -0.942761 N m s/rad"),
    ],
)
def test_what_cannot_be_told_of_a_rig_is_a_sentence_beside_what_can(change, said, tmp_path, capsys):
    Rig(**change).to_toml(tmp_path / "rig.toml")
    with warnings.catch_warnings():
        warnings.simplefilter("error")
        assert main(["--rig", str(tmp_path / "rig.toml"), "--normal-force", "10", "--speed-reference", "1"]) == 0
    printed = capsys.readouterr().out
    assert said in printed
    assert "impedance" in printed
    assert "at 1 rad/s: " in printed or "at 1 rad/s:\n" in printed


def test_numbers_keep_their_digits_on_a_rig_of_micronewtons(tmp_path, capsys):
    sized = ("J_1", "J_2", "J_3", "k_1", "k_2", "d_1", "d_2", "T_f", "C_m", "K_T", "r_1")
    Rig(**{name: 1e-6 * getattr(Rig(), name) for name in sized}).to_toml(tmp_path / "rig.toml")
    main([])
    own = capsys.readouterr().out
    main(["--rig", str(tmp_path / "rig.toml")])
    text = capsys.readouterr().out
    for name, factor in (("impedance", 1e-6), ("slope_min", 1e-6), ("omega_c", 1.0), ("fold", 1.0)):
        assert number(text, name) == pytest.approx(factor * number(own, name), rel=1e-3)


def test_friction_is_the_rigs_own_and_said_to_be(tmp_path, capsys):
    rig = scaled(time=0.25, torque=2.0)
    rig = replace(rig, r_1=rig.r_1 / 2.0)  # which the force makes up for
    rig.to_toml(tmp_path / "rig.toml")
    main([])
    own = capsys.readouterr().out
    main(["--rig", str(tmp_path / "rig.toml"), "--write-friction", str(tmp_path / "friction.toml")])
    capsys.readouterr()
    for words in ([], ["--friction", str(tmp_path / "friction.toml")]):
        main(["--rig", str(tmp_path / "rig.toml"), *words])
        text = capsys.readouterr().out
        assert ("friction: the chapter's, in the scales of the rig; " in text) == (not words)
        assert number(text, "normal_force") == pytest.approx(2.0 * number(own, "normal_force"))
        for name in ("v_b", "slope_min", "omega_c", "fold"):
            factor = {"v_b": 0.25, "slope_min": 0.5}.get(name, 4.0)
            assert number(text, name) == pytest.approx(factor * number(own, name), rel=1e-3)
    assert "friction: the chapter's; --friction FILE takes another" in own
