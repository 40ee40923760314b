import numpy as np
import pytest

from drillrig_env import Friction, Rig, simulate, simulate_batch
from drillrig_env.model import STATE_NAMES, frictionless_state, state_equations

START = (0.0, 0.0, 2.0, 2.0, 2.0, 0.5, 0.0)


@pytest.mark.parametrize(("method", "tolerance"), [("vode", 2e-5), ("radau", 1e-7)])
def test_methods_agree_through_steps_of_reference_and_force(method, tolerance):
    run = {
        "friction": Friction(20.0),
        "initial_state": START,
        "speed_reference": [(0, 2.0), (2.005, 3.0)],
        "normal_force": [(0, 20.0), (1.2345, 10.0)],
        "duration": 4.0,
        "sample_period": 0.02,
    }
    fast, reference = simulate(**run), simulate(**run, method=method)
    assert np.abs(fast.state - reference.state)[:, :6].max() < tolerance


def test_result_has_named_signals_of_one_length():
    run = simulate(duration=1.0, sample_period=0.25)
    assert run.time.tolist() == [0.0, 0.25, 0.5, 0.75, 1.0]
    assert run.state.shape == (5, 7)
    for column, name in enumerate(STATE_NAMES):
        np.testing.assert_array_equal(getattr(run, name), run.state[:, column])
    assert {len(signal) for signal in run.signals().values()} == {5}
    assert {"time", "bit_speed", "current", "voltage", "torque_into_string", "friction_torque"} <= set(run.signals())


def test_defaults_are_half_a_minute_from_rest_every_hundredth_of_a_second():
    run = simulate()
    np.testing.assert_allclose(run.time, np.arange(3001) / 100.0)
    np.testing.assert_array_equal(run.state[0], frictionless_state(Rig(), 0.0))
    assert set(run.speed_reference) == {2.0}
    assert set(run.normal_force) == {Friction().normal_force}


def test_derived_signals_satisfy_the_state_equations():
    run = simulate(friction=Friction(15.0), initial_state=START, speed_reference=2.0, duration=0.5)
    rig = Rig()
    for x, voltage, torque in zip(run.state, run.voltage, run.friction_torque, strict=True):
        rate = state_equations(x, 2.0, torque, rig)
        assert rig.L * rate[5] == pytest.approx(voltage - rig.R * x[5] - rig.eta * rig.K_E * x[4])


def test_samples_do_not_depend_on_where_they_are_taken():
    coarse = simulate(friction=Friction(20.0), initial_state=START, duration=10.0, sample_period=0.5)
    fine = simulate(friction=Friction(20.0), initial_state=START, duration=10.0, sample_period=0.02)
    np.testing.assert_allclose(coarse.state, fine.state[::25], atol=1e-6)


def test_signals_follow_the_schedules():
    run = simulate(
        speed_reference=[(0, 1.0), (2, 3.0)], normal_force=[(0, 0.0), (1, 25.0)], duration=3.0, sample_period=0.5
    )
    assert run.speed_reference.tolist() == [1, 1, 1, 1, 3, 3, 3]
    assert run.normal_force.tolist() == [0, 0, 25, 25, 25, 25, 25]


@pytest.mark.parametrize(
    ("arguments", "words"),
    [
        ({"duration": -1.0}, ["duration", "-1.0 s", "> 0"]),
        ({"sample_period": 0.0}, ["sample_period", "0.0 s"]),
        ({"sample_period": 50.0}, ["sample_period", "duration"]),
        ({"method": "euler"}, ["method", "euler", "fast, vode, radau"]),
        ({"speed_reference": -2.0}, ["speed_reference", "-2.0 rad/s", ">= 0"]),
        ({"speed_reference": [(1, 2.0)]}, ["first time", "speed_reference", "s"]),
        ({"normal_force": [(0, 1.0), (0, 2.0)]}, ["times (s) of normal_force", "ascending"]),
        ({"initial_state": [0.0, 1.0]}, ["initial_state", "(2,)", "(7,)"]),
        ({"initial_state": [0, 0, float("nan"), 0, 0, 0, 0]}, ["bit_speed", "nan"]),
        ({"friction": Friction(np.array([1.0, 2.0]))}, ["2 rigs", "simulate_batch"]),
    ],
)
def test_bad_arguments_are_named(arguments, words):
    with pytest.raises(ValueError, match=r".") as caught:
        simulate(**arguments)
    for word in words:
        assert word in str(caught.value)


def test_batch_of_unequal_lengths_is_refused():
    with pytest.raises(ValueError, match=r"number of rigs = \[2, 3\]"):
        simulate_batch(None, Friction(np.ones(2)), speed_reference=np.ones(3))
