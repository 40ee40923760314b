"""The choice of a law of friction, on twins whose law is known."""

from dataclasses import replace

import numpy as np
import pytest

from drillrig_env import Friction, Rig, simulate
from drillrig_env.calibrate import command
from drillrig_env.calibrate.calibration import calibrate
from drillrig_env.calibrate.laws import (
    LawScore,
    _alike,
    choose_law,
    law_rows,
    law_words,
    starts_of_all,
    with_viscous_part,
)
from drillrig_env.calibrate.records import Record
from tests.calibrate.test_calibration import FIXED, NOISE, STICKING, UNLOADED, csv_of

OF_FRICTION = {name: value for name, value in FIXED.items() if name not in ("C_1", "v_b", "mu_k", "mu_s - mu_k")}
OF_FRICTION |= dict.fromkeys(("k_2", "J_2", "K_T"))
"""Only the friction is looked for."""


def twin(law, v_b, seed=0, duration=36.0, rig=None):
    friction = Friction(20.0, v_b=v_b, law=law)
    run = simulate(rig, friction, None, [(0, 2.0), (0.5 * duration, 3.0)], duration, 0.02)
    random = np.random.default_rng(seed)
    signals = {name: getattr(run, name) + size * random.standard_normal(len(run.time)) for name, size in NOISE.items()}
    return Record("twin.csv", "", run.time, signals, run.speed_reference, run.normal_force)


@pytest.mark.parametrize(
    ("law", "v_b"),
    [
        ("gaussian", 0.6),
        pytest.param("exponential", 1.0, marks=pytest.mark.slow),
        pytest.param("linear", 0.3, marks=pytest.mark.slow),
    ],
)
def test_the_law_of_a_twin_is_chosen(law, v_b):
    fixed = OF_FRICTION | {"C_1": None}
    found = choose_law([twin(law, v_b)], None, Friction(10.0), fix=fixed, starts=1, held_out=0.3)
    assert found.friction.law == law
    assert found.laws[0].law == law
    assert found.laws[0].held_out == pytest.approx(1.0, abs=0.15)
    assert found.laws[0].fitted == pytest.approx(1.0, abs=0.15)
    assert {one.law for one in found.laws} == {"exponential", "gaussian", "linear"}
    for one in found.laws[1:]:
        assert one.told_apart
        assert one.behind == pytest.approx(one.held_out - found.laws[0].held_out)
    assert law_words(found.laws) == f"law of friction: {law}, the best in windows held out"
    low, high = found.interval("v_b")
    assert 0.98 * low < v_b < 1.02 * high


def test_laws_that_the_bit_never_slips_enough_to_tell_are_not_told_apart():
    friction = Friction(20.0, v_b=0.01)  # falls by a tenth within the speeds that are seen: all laws but one are lines
    run = simulate(None, friction, None, [(0, 2.0), (9, 3.0), (18, 2.5), (27, 3.5)], 36.0, 0.02)
    random = np.random.default_rng(1)
    signals = {name: getattr(run, name) + size * random.standard_normal(len(run.time)) for name, size in NOISE.items()}
    record = Record("twin.csv", "", run.time, signals, run.speed_reference, run.normal_force)
    fixed = OF_FRICTION | dict.fromkeys(("C_1", "mu_s - mu_k"))
    found = choose_law([record], None, replace(friction, v_b=0.011), fix=fixed, starts=1, held_out=0.3)
    alike = [one for one in found.laws[1:] if not one.told_apart]
    assert alike
    assert f"but no better than {alike[0].law}" in law_words(found.laws)


def test_a_viscous_part_is_found_where_there_is_one_and_small_where_there_is_none():
    rig = replace(Rig(), C_1=0.01)
    for true, held in ((rig, (0.008, 0.0125)), (Rig(), (0.0, 0.002))):
        found = calibrate(
            [twin("exponential", 1.0, rig=true)],
            with_viscous_part(Rig()),
            Friction(10.0),
            fix=OF_FRICTION,
            starts=1,
        )
        low, high = held
        assert low < found.rig.C_1 < high
    assert with_viscous_part(rig) == rig


def test_other_laws_begin_where_they_fall_at_the_same_speed():
    known = Friction(1.0, v_b=2.0)
    rig = Rig(omega_s=1e-6)
    for law in ("exponential", "gaussian", "linear"):
        other = _alike(known, law)
        speed = np.log(2.0) / 2.0
        assert other.torque(rig, speed) == pytest.approx(known.torque(rig, speed), rel=2e-3)


def test_what_is_said_of_the_laws():
    scores = [
        LawScore("gaussian", 1.0, 1.01, 0.0, 0.0),
        LawScore("linear", 1.1, 1.02, 0.01, 0.05),
        LawScore("exponential", 1.3, 2.02, 1.01, 0.2),
    ]
    assert law_words(scores) == (
        "law of friction: gaussian, the best in windows held out, but no better than linear within the noise"
    )
    assert law_words(scores[:1]) == "law of friction: gaussian; no other was fitted"
    assert [row[0] for row in law_rows(scores)] == ["gaussian", "linear", "exponential"]
    assert law_rows(scores)[2][3] == "1.010 +- 0.200"
    assert starts_of_all(24) == 32
    assert starts_of_all(1) == 3


@pytest.mark.parametrize(
    ("records", "options"), [([UNLOADED], {}), ([STICKING], {"held_out": 0.0}), ([STICKING], {"held_out": 0.15})]
)
def test_too_little_to_choose_by_is_refused(records, options):
    with pytest.raises(ValueError, match="windows under load are held out, too few to choose a law of friction by"):
        choose_law(records, None, Friction(10.0), fix=FIXED, starts=1, **options)


def test_the_command_begins_with_the_law_that_is_asked_for(tmp_path, capsys, monkeypatch):
    csv_of(STICKING, tmp_path / "run.csv")
    seen = []

    def fitted(records, rig, friction, **_):
        seen.append((rig, friction))
        raise ValueError("seen")

    for name in ("calibrate", "choose_law"):
        monkeypatch.setattr(f"drillrig_env.calibrate.fit_of_command.{name}", fitted)
    for words in ([], ["--law", "gaussian"], ["--viscous"], ["--law", "auto"], ["--law", "auto", "--fix", "C_1"]):
        with pytest.raises(SystemExit):
            command.main([str(tmp_path / "run.csv"), *words])
    assert [friction.law for _, friction in seen] == ["exponential", "gaussian", *["exponential"] * 3]
    assert [rig.C_1 > 0.0 for rig, _ in seen] == [False, False, True, True, False]
    for words in (["--viscous", "--fix", "C_1"], ["--law", "gausian"]):
        with pytest.raises(SystemExit):
            command.main([str(tmp_path / "run.csv"), *words])
    said = capsys.readouterr().err
    assert "--viscous looks for C_1, which --fix holds; give one of them" in said
    assert "did you mean gaussian" in said
