"""What a calibration is given and cannot use is said in a sentence, before anything is fitted."""

from dataclasses import replace

import numpy as np
import pytest

from drillrig_env import Friction, Rig
from drillrig_env.calibrate import command
from drillrig_env.calibrate.beside import beside
from drillrig_env.calibrate.calibration import calibrate
from drillrig_env.calibrate.misfit import misfit_words, misfits
from drillrig_env.calibrate.result import check_free
from drillrig_env.calibrate.unknowns import OF_FRICTION, OF_RIGS, Unknowns
from drillrig_env.calibrate.windows import Windows
from tests.calibrate.test_calibration import FIXED, STICKING, UNLOADED, csv_of, twin

ALL_FIXED = dict.fromkeys((*OF_RIGS, *OF_FRICTION))
FEW = {name: None for name in ALL_FIXED if name not in ("k_2", "J_2")}
NOWHERE = np.full(len(STICKING.time), np.nan)


def fails(*_):
    raise AssertionError("it is to be refused before any fit")


@pytest.mark.parametrize(
    ("record", "arguments", "words"),
    [
        (STICKING, {"weigh": {"J_1": 0.02}}, "J_1 is fixed and weighed"),
        (STICKING, {"weigh": {"k_2": 2.0}}, "weigh k_2 = 2.0 is not allowed; allowed: > 0 and < 1, such as 0.02"),
        (STICKING, {"weigh": {"k_2": 0.0}}, "weigh k_2 = 0.0 is not allowed"),
        (STICKING, {"weigh": {"k_2": np.nan}}, "weigh k_2 = nan is not allowed"),
        (STICKING, {"fix": {}, "weigh": {"T_r2": 0.1}}, "T_r2 is weighed, but 0"),
        (STICKING, {"fix": ALL_FIXED}, "every parameter is fixed or 0"),
        (STICKING, {"window": 9.0}, "number of windows = 2 is not allowed; allowed: >= 4, here of 9 s"),
        (STICKING, {"window": -1.0}, "window = -1.0 s is not allowed"),
        (replace(STICKING, signals=dict.fromkeys(STICKING.signals, NOWHERE)), {}, "twin.csv: no signal has a sample"),
        (replace(STICKING, speed_reference=NOWHERE), {}, "twin.csv: speed_reference = nan rad/s .* finite throughout"),
        (replace(STICKING, speed_reference=-STICKING.speed_reference), {}, "speed_reference = -2.0 rad/s .* >= 0"),
        (replace(STICKING, normal_force=-STICKING.normal_force), {}, "normal_force = -20.0 N .* turns a column round"),
    ],
)
def test_what_is_given_wrong_is_refused_before_the_fit(record, arguments, words, monkeypatch):
    monkeypatch.setattr("drillrig_env.calibrate.calibration.fit", fails)
    with pytest.raises(ValueError, match=words):
        calibrate([record], None, Friction(10.0), **{"fix": FIXED, "starts": 1, **arguments})


def test_a_parameter_may_be_fixed_at_zero():
    unknowns = Unknowns.of(Rig(), Friction(10.0), {"K_E": 0.0, "mu_s - mu_k": 0.0})
    rig, friction = unknowns.at(np.zeros(len(unknowns.names)))
    assert rig.K_E == 0.0
    assert friction.mu_s == friction.mu_k
    name, value = command._fixed("K_E=0")
    assert (name, value) == ("K_E", 0.0)


def test_a_signal_without_samples_is_left_out():
    record = replace(STICKING, signals={**STICKING.signals, "top_speed": NOWHERE})
    assert Windows.of(record, 0.02, 3.0).names == ("bit_speed", "current", "voltage")


def test_noise_takes_no_input_below_zero():
    noise = 0.1 * np.random.default_rng(0).standard_normal(len(STICKING.time))
    noisy = replace(STICKING, speed_reference=STICKING.speed_reference + noise, normal_force=noise)
    windows = Windows.of(noisy, 0.02, 3.0)
    assert windows.forces.min() == 0.0
    assert windows.forces.max() > 0.0
    assert windows.references.min() > 0.0


def test_what_nothing_presses_on_may_be_weighed():
    found = calibrate([UNLOADED], None, Friction(10.0), fix=FEW | {"d_2": None}, weigh={"k_2": 0.1}, starts=1)
    assert set(found.unknowns.names) == {"k_2", "J_2"}


def test_friction_comes_out_at_the_load_of_the_records():
    loaded = calibrate([UNLOADED, STICKING], None, Friction(10.0), fix=FEW, starts=1)
    assert loaded.load == loaded.friction.normal_force == 20.0
    unloaded = calibrate([UNLOADED], None, Friction(10.0), fix=FEW, starts=1)
    assert unloaded.load == 0.0
    assert unloaded.friction.normal_force == 10.0


def test_what_the_model_does_not_follow_is_told():
    good = calibrate([STICKING, UNLOADED], None, Friction(10.0), fix=FEW, starts=1)
    assert misfit_words(misfits(good, beside(good))) == []
    other = twin(2.0, 20.0, 24.0, rig=replace(Rig(), k_2=1.15 * Rig().k_2, J_2=1.3 * Rig().J_2))
    mixed = calibrate([STICKING, replace(other, source="other.csv")], None, Friction(10.0), fix=FEW, starts=1)
    found = misfits(mixed, beside(mixed))
    assert "other.csv" in {one.source for one in found}
    assert all(one.left > 1.5 * one.noise for one in found)
    *lines, why = misfit_words(found)
    assert any("other.csv: the model is off bit_speed by " in line for line in lines)
    assert "different rigs" in why


def test_moments_that_the_fit_passes_over_are_a_misfit_too():
    good = calibrate([STICKING, UNLOADED], None, Friction(10.0), fix=FEW, starts=1)
    parts = beside(good)
    shown = parts[2].shown.copy()
    shown[:, ::50, 2] += 0.3  # of 0.02 A of noise, in a sample of 50
    (found,) = misfits(good, [*parts[:2], replace(parts[2], shown=shown), parts[3]])
    assert found.signal == "current"


def told(words, capsys):
    with pytest.raises(SystemExit):
        command.main(words)
    return capsys.readouterr().err


def test_inputs_of_the_command_line_are_for_records_without_them(tmp_path, capsys):
    csv_of(UNLOADED, tmp_path / "with.csv")
    np.savetxt(
        tmp_path / "without.csv",
        np.column_stack([STICKING.time, STICKING.signals["bit_speed"]]),
        delimiter=",",
        header="time,bit_speed",
        comments="",
    )
    inputs = ["--normal-force", "20", "--speed-reference", "2"]
    assert "every record has a column of it" in told([str(tmp_path / "with.csv"), "--look", *inputs], capsys)
    assert "the speed_reference is missing" in told([str(tmp_path / "without.csv"), "--look"], capsys)
    read = [command.read_record(tmp_path / name) for name in ("with.csv", "without.csv")]
    options = command.argparse.Namespace(speed_reference=[(0.0, 2.0), (5.0, 3.0)], normal_force=[(0.0, 20.0)])
    with_, without = command._with_inputs(read, options)
    np.testing.assert_allclose(with_.normal_force, 0.0)
    np.testing.assert_allclose(without.normal_force, 20.0)
    np.testing.assert_array_equal(without.speed_reference, np.where(without.time < 5.0 - 1e-9, 2.0, 3.0))


def test_a_folder_with_anything_else_in_it_is_not_written_over(tmp_path):
    folder = tmp_path / "mine"
    folder.mkdir()
    (folder / "rig.toml").write_text("")
    check_free(folder, overwrite=True)
    (folder / "thesis.tex").write_text("")
    with pytest.raises(FileExistsError, match=r"holds thesis\.tex, which is no part of a result"):
        check_free(folder, overwrite=True)
    with pytest.raises(FileExistsError, match=r"holds thesis\.tex"):
        check_free(folder / "thesis.tex", overwrite=True)
