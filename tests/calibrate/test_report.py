"""What is said of a calibration: how well it follows the records, fitted and held out, and what it means."""

from dataclasses import replace

import numpy as np
import pytest

from drillrig_env import Friction, Rig
from drillrig_env.calibrate import borders as module
from drillrig_env.calibrate.beside import FITTED, HELD_OUT, beside
from drillrig_env.calibrate.borders import LOADS, borders, loads
from drillrig_env.calibrate.calibration import AT_BOUND
from drillrig_env.calibrate.cycles import cycle_rows, cycles, onwards
from drillrig_env.calibrate.fit import FARTHEST
from drillrig_env.calibrate.judged import judged, judged_rows
from drillrig_env.calibrate.meaning import Meaning, meanings
from drillrig_env.calibrate.misfit import Misfit
from drillrig_env.calibrate.pictures.parameters import draw_intervals
from drillrig_env.calibrate.report import Report
from drillrig_env.calibrate.unknowns import OF_FRICTION, OF_RIGS, UNITS
from drillrig_env.engine import Local
from drillrig_env.indicators import amplitude_pulse_level, correlation
from drillrig_env.stability import critical_speed, end_of_stick_slip, stick_slip_orbit
from tests.calibrate.test_calibration import fitted


@pytest.fixture(scope="module")
def parts():
    return beside(fitted())


def test_every_part_of_a_record_has_the_model_beside_it(parts):
    assert [(one.record, one.part, len(one.windows)) for one in parts] == [
        (0, FITTED, 7),
        (0, HELD_OUT, 1),
        (1, FITTED, 4),
        (1, HELD_OUT, 1),
    ]
    for one in parts:
        assert one.shown.shape == one.windows.data.shape
        assert np.std(one.residuals) == pytest.approx(1.0, abs=0.3)


def test_a_model_is_judged_in_windows_that_it_has_not_seen(parts):
    found = judged(fitted(), parts)
    assert len(found) == 4 * 4
    for one in found:
        assert 0.7 < one.off < 1.3
    (bit,) = [one for one in found if (one.part, one.signal, one.windows) == (HELD_OUT, "bit_speed", 1)][:1]
    measured, model = parts[1].windows.data[:, :, 0].ravel(), parts[1].shown[:, :, 0].ravel()
    assert bit.correlation == correlation(measured, model) > 0.999
    assert bit.amplitude_pulse_level == amplitude_pulse_level(measured, model) < 0.02
    voltage = [one for one in found if one.signal == "voltage"]
    assert np.isnan(voltage[0].correlation)  # the drive's own reference is steady: P_C would be that of noise
    assert judged_rows(voltage[:1])[0][3] == "-"


def test_another_rig_is_judged_worse(parts):
    calibration = fitted()
    logs = calibration.best.logs + np.where(np.array(calibration.unknowns.names) == "k_2", 0.1, 0.0)
    other = replace(calibration, best=replace(calibration.best, logs=logs))
    off = [one.off for one in judged(other, beside(other)) if one.part == HELD_OUT and one.signal == "bit_speed"]
    assert min(off) > 2.0


def test_cycles_are_those_of_the_orbit(parts):
    (sticking,) = cycles(fitted(), parts[:1])
    assert cycles(fitted(), parts[2:]) == []  # steps without load are no cycles
    orbit = stick_slip_orbit(Rig(), Friction(20.0), 2.0)
    period, peak, stuck, swing = sticking.features
    assert sticking.count >= 4
    for of in ("measured", "model"):
        assert getattr(period, of) == pytest.approx(orbit.period, rel=0.01)
        assert getattr(stuck, of) == pytest.approx(orbit.stuck, abs=0.05)  # by noise it seems to stick for longer
    assert peak.model == pytest.approx(peak.measured, rel=0.02)
    assert swing.model == pytest.approx(swing.measured, rel=0.1)
    assert [row[2] for row in cycle_rows([sticking])] == [
        "period, s",
        "peak of bit speed, rad/s",
        "stuck, share of the period",
        "swing of current, A",
    ]


def test_windows_go_on_into_those_that_follow(parts):
    held = parts[1].windows
    long = onwards(held, 3)
    (place,) = held.places
    steps = held.data.shape[1]
    np.testing.assert_array_equal(long.data[0, steps : 2 * steps], held.whole.data[place + 1])
    np.testing.assert_array_equal(long.forces[0, :steps], held.forces[0])
    last = onwards(held.whole.take(np.array([len(held.whole) - 1])), 2)
    assert np.isnan(last.data[0, steps:]).all()
    np.testing.assert_array_equal(last.references[0, steps:], held.whole.references[-1])


def test_borders_are_those_of_the_stability_of_each_rig():
    calibration = fitted()
    forces = loads(calibration)
    assert (len(forces), forces[-1]) == (LOADS, calibration.load)
    found = borders(calibration, forces, draws=1)
    for speeds, (rig, friction) in zip(
        (found.best, found.draws[0]), [(calibration.rig, calibration.friction), calibration.rigs()[0]], strict=True
    ):
        pressed = replace(friction, normal_force=forces)
        np.testing.assert_allclose(speeds[0], critical_speed(rig, pressed))
        np.testing.assert_allclose(speeds[1], end_of_stick_slip(rig, pressed).speed)


@pytest.mark.slow
def test_processes_share_the_draws_to_the_last_bit():
    alone, shared = (borders(fitted(), [10.0, 20.0], draws=3, engine=Local(jobs)) for jobs in (1, 2))
    np.testing.assert_array_equal(shared.draws, alone.draws)


@pytest.fixture
def quick(monkeypatch):
    """Borders without the orbits, whose end is half above the critical speed."""
    monkeypatch.setattr(module, "_end", lambda *given: 1.5 * module._critical(*given))


def test_ctrl_c_ends_the_draws(quick):
    def told(done, of):
        if done == 19:
            raise KeyboardInterrupt

    found = borders(fitted(), [20.0], told=told)
    assert (len(found.draws), found.wanted) == (19, 64)


def test_the_meaning_of_a_calibration(quick):
    critical, end = meanings(fitted(), 20.0)
    assert critical.value == pytest.approx(2.6886, abs=0.1)
    assert critical.low < critical.value < critical.high
    assert critical.determined
    assert end.low == pytest.approx(1.5 * critical.low)
    few, _ = meanings(fitted(), 20.0, draws=5)
    assert str(few).endswith("rad/s, too few rigs drawn for an interval (5)")


def test_what_cannot_be_told_of_a_load_is_left_open(monkeypatch):
    def refuses(rig, friction):
        raise FloatingPointError if np.max(friction.normal_force) > 15.0 else ValueError

    monkeypatch.setattr(module, "end_of_stick_slip", refuses)
    found = borders(fitted(), [10.0, 20.0], draws=16)
    assert np.isnan(found.best[1]).all()
    assert np.isfinite(found.best[0]).all()
    assert str(meanings(fitted(), 20.0, draws=16)[1]) == ("end of stick-slip: cannot be told for 16 of 16 rigs drawn")


@pytest.mark.parametrize(
    ("meaning", "words"),
    [
        (Meaning("critical speed", 3.0, 2.9, 3.2), "3.000 rad/s (2.900 to 3.200)"),
        (Meaning("critical speed", 3.0, 1.0, 9.0), "not determined by these records (1 to 9 rad/s)"),
        (Meaning("critical speed", 0.0, 0.0, 0.0), "none, steady rotation is stable at every speed"),
        (Meaning("critical speed", np.inf, np.inf, np.inf), "none, steady rotation is stable at no speed"),
        (Meaning("end of stick-slip", 0.0, 0.0, 0.0), "none, there is no stick-slip"),
        (Meaning("end of stick-slip", 0.0, 0.0, 5.0), "not determined by these records (0 to 5 rad/s)"),
        (Meaning("end of stick-slip", np.nan, np.nan, np.nan, 64, 40), "cannot be told for 24 of 64 rigs drawn"),
    ],
)
def test_a_meaning_in_words(meaning, words):
    assert str(meaning) == f"{meaning.name}: {words}"


def test_what_stands_at_a_bound_is_told(quick):
    calibration = fitted()
    at = np.array(calibration.unknowns.names) == "K_T"
    other = replace(calibration, best=replace(calibration.best, logs=np.where(at, -FARTHEST, calibration.best.logs)))
    assert [row[4] for row in other.rows() if row[0] == "K_T"] == [AT_BOUND]
    assert AT_BOUND not in [row[4] for row in calibration.rows()]
    report = replace(Report.of(calibration, "line", draws=0), calibration=other)
    assert report.sentences()[-1].startswith("At a bound, 30 times off where the fit began: K_T; ")
    assert report.summary()["parameters"]["K_T"]["known"] == AT_BOUND
    legend = draw_intervals(other).figure.legends[0].get_texts()
    assert AT_BOUND in [text.get_text() for text in legend]


def test_a_report_has_all_of_it(quick):
    report = Report.of(fitted(), "drillrig calibrate a.csv", draws=16)
    assert [title for title, _, _ in report.tables()] == [
        "Parameters",
        "How well the model follows the records",
        "Cycles of vibration",
    ]
    assert len(report.sentences()) == 2
    told = report.summary()
    assert told["held_out"] == 2
    assert {one["part"] for one in told["judged"]} == {FITTED, HELD_OUT}
    assert told["cycles"][0]["features"][0]["name"] == "period"
    critical = told["map"]["critical speed"]
    assert len(critical["value"]) == len(told["map"]["normal_force"]) == LOADS
    assert critical["low"][-1] == told["means"]["critical speed"]["low"] < critical["value"][-1]
    assert told["means"]["critical speed"]["determined"] is True


def test_where_the_model_does_not_follow_the_records_the_table_says_so():
    good = Report.of(fitted(), "", draws=2)
    bad = replace(good, misfits=[Misfit("run.csv", "current", 0.5, 0.02)])
    assert good.tables()[0][0] == "Parameters"
    assert "do not believe these intervals" in bad.tables()[0][0]
    assert bad.sentences()[0].startswith("run.csv: the model is off current by 0.5 A")


def test_every_parameter_that_has_a_unit_is_told_with_it():
    assert {name for name, unit in UNITS.items() if not unit} == {"eta", "mu_k", "mu_s - mu_k"}
    assert set(UNITS) >= {*OF_RIGS, *OF_FRICTION}
    assert (UNITS["J_1"], UNITS["v_b"]) == ("kg m^2", "s/rad")
