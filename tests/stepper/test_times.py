"""Sample times: exact, none lost to rounding, none finer than doubles are."""

from fractions import Fraction

import numpy as np
import pytest

from drillrig_env import Friction, Rig, simulate, simulate_batch
from drillrig_env.reference import radau
from drillrig_env.stepper.times import _FINEST, sample_count, step_of

START = np.array([0.0, 0.0, 2.5, 2.0, 2.0, 0.5, 0.0])


@pytest.mark.parametrize("rate", [9, 240, 700, 7001, 11_025, 96_000])
def test_an_hour_has_all_its_samples(rate):
    assert sample_count("here", 3600.0, 1.0 / rate) == 3600 * rate


@pytest.mark.parametrize("duration", [0.5, 8.0, 4096.0])
def test_the_shortest_period_that_an_error_allows_is_taken(duration):
    finest = _FINEST * float(np.spacing(duration))
    assert sample_count("here", duration, finest) == duration / finest
    with pytest.raises(ValueError, match="allowed: >= "):
        sample_count("here", duration, finest * (1.0 - 1e-9))


@pytest.mark.parametrize("rate", [90, 700, 12_345])
def test_sample_times_are_whole_periods_within_one_rounding(rate):
    run = simulate(sample_period=1.0 / rate, duration=30.0)
    for k in (1, 17, 3 * rate + 1, len(run.time) - 1):
        exact = k * Fraction(1.0 / rate)
        assert abs(Fraction(float(run.time[k])) - exact) <= Fraction(float(np.spacing(run.time[k]))) / 2


@pytest.mark.parametrize("rate", [130, 900, 11_025, 96_000])
def test_states_belong_to_their_times(rate):
    """Whole seconds are whole numbers of these periods: the states then are those of a run sampled every 0.05 s."""
    arguments = {"friction": Friction(24.0), "initial_state": START, "speed_reference": 2.2, "duration": 12.0}
    fine = simulate(sample_period=1.0 / rate, **arguments)
    coarse = simulate(sample_period=0.05, **arguments)
    np.testing.assert_allclose(fine.state[::rate, 2:5], coarse.state[::20, 2:5], atol=1e-6)
    batch = simulate_batch(None, Friction(24.0), START, 2.2, 12.0, sample_period=1.0 / rate)
    np.testing.assert_array_equal(batch[0], fine.state)


@pytest.mark.parametrize(
    "rate", [300, 44_100, *(pytest.param(rate, marks=pytest.mark.slow) for rate in (7000, 48_000))]
)
def test_states_of_twenty_seconds_are_those_of_radau_at_their_times(rate):
    friction = Friction(21.0, 0.48, 0.31, 1.1)
    run = simulate(None, friction, START, 1.9, duration=20.0, sample_period=1.0 / rate)
    places = np.linspace(0, 20 * rate, 12).astype(int)
    expected = radau(Rig(), friction, 1.9, START, run.time[places], rtol=1e-9, atol=1e-11)
    np.testing.assert_allclose(run.state[places[1:], 2:5], expected[:, 2:5], atol=1e-6)


def test_samples_of_an_hour_lie_within_one_rounding_of_whole_periods():
    run = simulate(friction=Friction(0.0), duration=3600.0, sample_period=1.0 / 300)
    for k in (1, 7, 99_991, 1_079_999, 1_080_000):
        exact = k * Fraction(1.0 / 300)
        assert abs(Fraction(float(run.time[k])) - exact) <= Fraction(float(np.spacing(run.time[k]))) / 2


@pytest.mark.parametrize("period", [3e-9, 7e-10, 2e-11, 1e-13])
def test_change_over_the_shortest_periods_is_that_of_the_present_rate(period):
    states = simulate(friction=Friction(24.0), initial_state=START, duration=50 * period, sample_period=period).state
    assert len(states) == 51
    rig, friction = Rig(), Friction(24.0)
    rate = (-rig.d_1 * 0.5 - friction.torque(rig, 2.5)) / rig.J_1
    assert states[-1, 2] - 2.5 == pytest.approx(50 * period * rate, rel=1e-4, abs=50 * 4e-16)


def test_periods_that_doubles_do_not_resolve_are_refused():
    for run in (simulate, simulate_batch):
        with pytest.raises(ValueError, match=r"sample_period = 1e-15 s is not allowed; allowed: >= 1\.4e-14"):
            run(duration=10.0, sample_period=1e-15)


def test_periods_of_more_steps_than_can_be_counted_are_refused():
    for run in (simulate, simulate_batch):
        with pytest.raises(ValueError, match=r"sample_period = 1e\+307 s is not allowed; allowed: <= 1e\+11"):
            run(duration=1e308, sample_period=1e307)


@pytest.mark.parametrize("first", [0.71828182, 1.0 + 1e-12, 1.0 + 3e-10, 1.0 - 3e-10])
def test_switches_off_the_grid_are_taken_where_they_are(first):
    """The second half of a run is that of a run which begins there."""
    whole = simulate(
        friction=Friction(15.0), initial_state=START, speed_reference=[(0.0, 2.5), (first, 3.5)], duration=3.0
    )
    before = simulate(
        friction=Friction(15.0), initial_state=START, speed_reference=2.5, duration=first, sample_period=first / 8
    )
    after = simulate(
        friction=Friction(15.0),
        initial_state=before.state[-1],
        speed_reference=3.5,
        duration=3.0 - first,
        sample_period=(3.0 - first) / 50,
    )
    np.testing.assert_allclose(whole.state[-1], after.state[-1], atol=1e-7)


def test_steps_are_no_longer_than_the_rig_allows():
    assert step_of(Rig(), 0.1) == (1, 0.1)
    assert step_of(Rig(), 0.1 + 0.2) == (3, (0.1 + 0.2) / 3)
    assert step_of(Rig(k_1=17.9, k_2=5.9), 0.1) == (4, 0.025)  # four times faster
    assert step_of(Rig(k_1=1.1175 / 16, k_2=0.3659 / 16), 0.3) == (1, 0.3)
