"""The motor's circuit and speed loop as records tell them without a simulation."""

from dataclasses import replace

import numpy as np
import pytest

from drillrig_env import Friction, Rig
from drillrig_env.calibrate import calibrate
from drillrig_env.calibrate.circuit import circuit_of
from drillrig_env.calibrate.fit import fit
from drillrig_env.calibrate.projection import Problem
from drillrig_env.calibrate.records import read_record
from drillrig_env.calibrate.search import Search
from drillrig_env.calibrate.unknowns import Unknowns
from drillrig_env.calibrate.windows import Windows
from tests.calibrate.test_calibration import twin

TRUE = replace(Rig(), L=0.0055, R=0.46, K_E=0.061, k_p=2.6, k_i=2.4)
MOVING = twin([(0, 2.0), (4, 4.5), (9, 3.0)], 10.0, 15.0, rig=TRUE)
CIRCUIT = ("L", "R", "K_E", "k_p", "k_i")


def told(record=MOVING, fix=None, weigh=None, period=0.02):
    """What the records tell of the true values, as ratios to them, by name."""
    unknowns = Unknowns.of(Rig(), Friction(10.0), fix, weigh)
    logs = circuit_of([Windows.of(record, period, 3.0)], unknowns)
    return None if logs is None else unknowns.values(logs) | {"logs": logs}


def test_the_circuit_and_the_loop_come_out_roughly_without_a_start():
    found = told()
    assert {name: found[name] / getattr(TRUE, name) for name in CIRCUIT} == pytest.approx(
        {"L": 1.0, "R": 1.0, "K_E": 1.0, "k_p": 1.0, "k_i": 1.0}, rel=0.6
    )
    assert found["R"] == pytest.approx(TRUE.R, rel=0.02)
    assert found["K_E"] == pytest.approx(TRUE.K_E, rel=0.02)


def test_they_come_out_right_where_samples_are_fine_and_without_noise():
    record = twin([(0, 2.0), (4, 4.5), (9, 3.0)], 10.0, 15.0, noise=0.0, rig=TRUE, period=0.001)
    found = told(record, period=0.001)
    for name in CIRCUIT:
        assert found[name] == pytest.approx(getattr(TRUE, name), rel=0.01), name


def test_what_is_not_of_the_circuit_stays_where_the_fit_begins():
    found = told()
    for name in ("J_1", "J_2", "J_3", "k_2", "K_T", "T_f"):
        assert found[name] == getattr(Rig(), name)
    assert found["mu_k"] == pytest.approx(Friction(10.0).mu_k)


def test_a_gain_that_is_held_is_taken_for_what_it_is():
    found = told(fix={"k_p": 2.6, "R": 0.46})
    assert found["k_i"] == pytest.approx(2.4, rel=0.1)
    assert found["L"] == pytest.approx(0.0055, rel=0.6)
    assert "k_p" not in found


def test_what_is_weighed_stays_near_its_weight():
    found = told(weigh={"R": 0.01, "k_i": 0.02})
    assert found["R"] == pytest.approx(Rig().R * np.exp(0.03))
    assert found["k_i"] == pytest.approx(Rig().k_i * np.exp(0.06))


@pytest.mark.parametrize("missing", ["voltage", "current", "top_speed"])
def test_records_without_a_voltage_a_current_or_a_speed_tell_nothing(missing):
    assert told(replace(MOVING, signals={k: v for k, v in MOVING.signals.items() if k != missing})) is None


def test_nothing_is_told_where_all_of_it_is_held():
    assert told(fix=dict.fromkeys(CIRCUIT)) is None


def test_the_second_start_has_it_and_a_single_one_does_not():
    places = []

    class Asked(Search):
        def each(self, solve, problem, steps, some):
            places.extend(some)
            raise AskedError

    class AskedError(Exception):
        pass

    windows = Windows.of(MOVING, 0.02, 3.0)
    problem = Problem([windows], Unknowns.of(Rig(), Friction(10.0)), [windows.noise])
    for starts in (1, 3):
        places.clear()
        with pytest.raises(AskedError):
            fit(problem, starts, 0, search=Asked())
        assert len(places) == starts
        assert not places[0].any()
    np.testing.assert_array_equal(places[1], told()["logs"])
    with pytest.raises(AskedError):
        places.clear() or fit(problem, 3, 0, search=Asked(), begin=np.full(len(problem.unknowns.names), 0.01))
    assert not np.array_equal(places[1], told()["logs"])


@pytest.mark.slow
def test_an_inductance_several_times_off_is_found_from_two_starts():
    records = [read_record(f"docs/twin/{name}.csv") for name in ("steps", "sweep", "stick_slip")]
    found = calibrate(records, None, Friction(24.0), fix={"J_1": 0.041}, starts=2)
    truth = Rig.from_toml("docs/twin/truth.toml")
    for name, low, high in ((name, *found.interval(name, 0.99)) for name in ("J_3", "L", "k_p", "K_T")):
        assert low < getattr(truth, name) < high, name
