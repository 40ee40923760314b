import pytest

from drillrig_env import Friction, Rig
from drillrig_env.cli.info import main
from drillrig_env.stability import critical_speed, fold_speed, stick_slip_orbit


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
    assert "0.429, 1.822" in text


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
    assert "friction is too weak for stick-slip" in text


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


@pytest.mark.filterwarnings("ignore::RuntimeWarning")  # what is too far apart overflows
@pytest.mark.parametrize(
    ("change", "code", "said"),
    [({"J_1": 1e-5}, 0, "harmonic balance: no orbit"), ({"J_1": 1e200}, 0, "harmonic balance: no orbit")],
)
def test_a_rig_beyond_what_can_be_computed_ends_in_a_sentence(change, code, said, tmp_path, capsys):
    Rig(**change).to_toml(tmp_path / "rig.toml")
    assert main(["--rig", str(tmp_path / "rig.toml")]) == code
    printed = capsys.readouterr()
    assert said in printed.out + printed.err
    assert "impedance" in printed.out
