"""The flow and the return to the section, against the event-split reference and their own composition."""

import numpy as np
import pytest

from drillrig_env import Friction, Rig, simulate
from drillrig_env.model import state_equations, steady_state, wound_up
from drillrig_env.reference import radau
from drillrig_env.stability.return_map import flow, next_crossings

RIGS = [Rig(), Rig(T_r2=0.1, k_p=2.0)]
FRICTION = Friction(20.0)
STATES = np.random.default_rng(3).normal(size=(6, 7)) * [0.3, 1.0, 3.0, 3.0, 3.0, 1.0, 1.0]


@pytest.mark.parametrize(("rig", "time"), [(RIGS[0], 0.03), (RIGS[1], 0.05), (RIGS[0], 0.1234567)])
def test_flow_is_the_solution_at_any_time(rig, time):
    expected = radau(rig, FRICTION, 2.0, STATES[0], np.array([0.0, time]), rtol=1e-9, atol=1e-11)[0]
    np.testing.assert_allclose(flow(rig, FRICTION, 2.0, STATES[:1], time)[0], expected, atol=2e-7)


def test_flow_over_no_time_is_nothing_and_over_two_times_their_sum():
    np.testing.assert_allclose(flow(RIGS[0], FRICTION, 2.0, STATES, 0.0), STATES, atol=1e-14)
    there = flow(RIGS[0], FRICTION, 2.0, flow(RIGS[0], FRICTION, 2.0, STATES, 0.3), 0.4)
    np.testing.assert_allclose(there, flow(RIGS[0], FRICTION, 2.0, STATES, 0.7), atol=1e-7)


@pytest.mark.parametrize("rig", RIGS)
@pytest.mark.parametrize("time", [0.0, 0.05, 0.1])
def test_the_last_fraction_of_a_microsecond_goes_at_the_rates_of_the_model(rig, time):
    before, after = (flow(rig, FRICTION, 2.0, STATES, time + rest) for rest in (0.0, 1e-7))
    for x, y in zip(before, after, strict=True):
        rates = state_equations(x, 2.0, FRICTION.torque(rig, x[2]), rig)
        np.testing.assert_allclose((y - x) / 1e-7, rates, rtol=1e-5, atol=1e-6)


def test_flow_leaves_its_argument_alone():
    before = STATES.copy()
    flow(RIGS[0], FRICTION, 2.0, STATES, 0.2)
    next_crossings(RIGS[0], FRICTION, 2.0, STATES)
    np.testing.assert_array_equal(STATES, before)


@pytest.mark.parametrize("rig", RIGS)
def test_crossing_is_the_first_place_where_the_bit_speeds_up_through_the_reference(rig):
    start = wound_up(rig, FRICTION, 2.0)
    found, times = next_crossings(rig, FRICTION, 2.0, start[None])
    assert found[0, 2] == pytest.approx(2.0, abs=1e-9)
    run = simulate(rig, FRICTION, start, 2.0, duration=float(times[0]) + 0.5, sample_period=1e-3)
    above = run.bit_speed >= 2.0
    first = np.flatnonzero(above[1:] & ~above[:-1])[0]
    assert run.time[first] <= times[0] <= run.time[first + 1]
    np.testing.assert_allclose(flow(rig, FRICTION, 2.0, start[None], float(times[0]))[0], found[0], atol=1e-8)


def test_next_crossing_from_a_crossing_is_a_whole_cycle_later():
    """The section point itself does not count again; the bit must fall below the reference first."""
    point, _ = next_crossings(RIGS[0], FRICTION, 2.0, wound_up(RIGS[0], FRICTION, 2.0)[None])
    for _ in range(12):
        point, times = next_crossings(RIGS[0], FRICTION, 2.0, point)
    assert times[0] == pytest.approx(2.4, abs=0.1)


def test_each_state_has_its_own_crossing():
    together, times = next_crossings(RIGS[0], FRICTION, 2.0, STATES)
    for x, end, time in zip(STATES, together, times, strict=True):
        alone, at = next_crossings(RIGS[0], FRICTION, 2.0, x[None])
        np.testing.assert_array_equal(alone[0], end)
        assert at[0] == time


def test_a_bit_that_never_breaks_loose_has_no_crossing():
    _, times = next_crossings(RIGS[0], Friction(1e4), 2.0, np.zeros((1, 7)))
    assert np.isnan(times[0])


def test_steady_rotation_flows_on():
    state = steady_state(RIGS[1], FRICTION, 4.0)
    np.testing.assert_allclose(flow(RIGS[1], FRICTION, 4.0, state[None], 3.21)[0], state, atol=1e-8)
