import numpy as np
import pytest

from drillrig_env import Friction, Rig, simulate
from drillrig_env.model import steady_state
from drillrig_env.stability import critical_speed, fold_speed
from drillrig_env.stability.vibration_map import (
    BISTABLE,
    CALM,
    VIBRATING,
    load_step_margin,
    region_map,
    simulated_map,
    vibrates,
)

RIG = Rig()


def test_simulated_map_agrees_with_the_curves_away_from_them():
    speeds, forces = np.linspace(0.8, 6.0, 25), np.linspace(4.0, 30.0, 20)
    by_curves, by_simulation = (f(RIG, Friction(), speeds, forces) for f in (region_map, simulated_map))
    frictions = Friction(forces)
    distance = np.minimum(
        np.abs(speeds / critical_speed(RIG, frictions)[:, None] - 1),
        np.abs(speeds / fold_speed(RIG, frictions)[:, None] - 1),
    )
    clear = distance > 0.03
    np.testing.assert_array_equal(by_simulation.region[clear], by_curves.region[clear])
    assert {CALM, BISTABLE, VIBRATING} == set(by_curves.region[clear])


def test_regions_of_known_points():
    found = region_map(RIG, Friction(), np.array([1.5, 2.5, 3.5]), np.array([0.5, 10.0]))
    assert found.region.tolist() == [[CALM, CALM, CALM], [VIBRATING, BISTABLE, CALM]]


def test_load_step_margin_is_the_step_that_knocks_a_rig_out():
    margin = load_step_margin(RIG, Friction(), np.array([1.5, 3.0, 8.0]), np.array([10.0]), largest_step=25.0)[0]
    assert margin[0] == 0.0
    assert margin[2] == np.inf
    for step, sticks in ((margin[1] * 1.02, True), (margin[1] * 0.97, False)):
        start = steady_state(RIG, Friction(10.0), 3.0)
        run = simulate(friction=Friction(10.0 + step), initial_state=start, speed_reference=3.0, duration=60)
        assert (np.ptp(run.bit_speed[-1000:]) > 0.6) == sticks


def test_impossible_grids_are_refused():
    with pytest.raises(ValueError, match="forces"):
        simulated_map(RIG, Friction(), np.array([1.0]), np.array([0.0]))
    with pytest.raises(ValueError, match="largest_step = -1"):
        load_step_margin(RIG, Friction(), np.array([1.0]), np.array([1.0]), largest_step=-1.0)


def test_margin_is_found_to_a_256th_of_the_largest_step():
    margins = load_step_margin(RIG, Friction(), np.linspace(2.4, 4.0, 6), np.array([5.0]), largest_step=25.6)[0]
    tenths = margins / 0.1
    np.testing.assert_allclose(tenths, np.round(tenths), atol=1e-9)
    assert np.any(np.round(tenths) % 2 == 1)


@pytest.mark.parametrize(("speed", "nudge", "shakes"), [(3.2, 0.01, False), (2.6, 0.0, False), (2.6, 0.01, True)])
def test_vibrates_sees_what_grows_from_unstable_rotation(speed, nudge, shakes):
    """Just below the critical speed, 2.688 rad/s at 20 N, a nudge grows slowly: after 50 s it still looks calm."""
    state = steady_state(RIG, Friction(20.0), speed)
    state[2] += nudge
    found = vibrates(RIG, Friction(20.0), np.array([speed]), state[None], 50.0)
    assert found.tolist() == [shakes]
    run = simulate(None, Friction(20.0), state, speed, duration=50.0)
    assert np.ptp(run.bit_speed[-1000:]) < 0.2 * speed


def test_vibrates_needs_time_to_tell():
    with pytest.raises(ValueError, match=r"duration = 40.0 s .*> 40"):
        vibrates(RIG, Friction(20.0), np.array([3.0]), steady_state(RIG, Friction(20.0), 3.0)[None], 40.0)


def test_rows_are_forces_and_columns_speeds():
    speeds, forces = np.array([1.0, 6.0, 7.0]), np.array([2.0, 30.0])
    for made in (region_map, simulated_map):
        found = made(RIG, Friction(), speeds, forces)
        assert found.region.tolist() == [[CALM, CALM, CALM], [VIBRATING, BISTABLE, CALM]]
        np.testing.assert_array_equal(found.speed_reference, speeds)
        np.testing.assert_array_equal(found.normal_force, forces)


@pytest.mark.parametrize(("beyond", "shakes"), [(0.01, False), (-0.01, True)])
def test_vibrates_tells_growth_from_decay_close_to_the_critical_speed(beyond, shakes):
    """The nudge is still there after 100 s, a few per cent smaller or larger."""
    speed = critical_speed(RIG, Friction(20.0)) + beyond
    state = steady_state(RIG, Friction(20.0), speed)
    state[2] += 0.01
    assert vibrates(RIG, Friction(20.0), np.array([speed]), state[None], 100.0).tolist() == [shakes]


@pytest.mark.parametrize(("nudge", "shakes"), [(0.9, False), (1.033, True)])
def test_vibrates_looks_at_the_last_ten_seconds(nudge, shakes):
    """The larger swing dies out as well, but its index falls below 0.1 only within those ten seconds."""
    speed, friction = 2.9, Friction(20.0)
    state = steady_state(RIG, friction, speed)
    state[2] += nudge
    assert vibrates(RIG, friction, np.array([speed]), state[None], 41.0).tolist() == [shakes]
    late = simulate(RIG, friction, state, speed, duration=41.0, sample_period=0.1).bit_speed[-100:]
    assert [np.ptp(part) > 0.2 * part.mean() for part in (late, late[50:])] == [shakes, False]
