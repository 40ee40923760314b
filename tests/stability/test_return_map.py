"""The return to the section, against the event-split reference, and its derivative, against differences."""

import numpy as np
import pytest

from drillrig_env import Friction, Rig, simulate
from drillrig_env.model import frictionless_state, state_equations, steady_state, wound_up
from drillrig_env.reference import radau
from drillrig_env.stability.multipliers import OFF_SECTION
from drillrig_env.stability.return_map import ReturnMap
from drillrig_env.stepper.units import units_of
from tests.rigs import FAST, FIELD

CASES = {
    "chapter": (Rig(), Friction(20.0), 2.0),
    "torque on the collars": (Rig(T_r2=0.1, k_p=2.0), Friction(20.0), 2.0),
    "laboratory": (FAST, Friction(10.0, v_b=1.0 / 6.5), 13.0),
    "field": (FIELD, Friction(9000.0, 1.0, 0.6, 0.2), 8.0),
}
RIG, FRICTION, SPEED = CASES["chapter"]
RETURNS = ReturnMap(RIG, FRICTION)
cases = pytest.mark.parametrize(("rig", "friction", "speed"), CASES.values(), ids=CASES)


def settled(rig, friction, speed, returns=8):
    state = wound_up(rig, friction, speed).reshape(7)
    for _ in range(returns):
        state = ReturnMap(rig, friction)(state, speed, with_derivative=False).state
    return state


@cases
def test_passage_is_the_solution_at_its_time(rig, friction, speed):
    state = settled(rig, friction, speed)
    passage = ReturnMap(rig, friction)(state, speed)
    expected = radau(rig, friction, speed, state, np.array([0.0, passage.time]), rtol=1e-10, atol=1e-12)[-1]
    np.testing.assert_allclose(passage.state / units_of(rig).states, expected / units_of(rig).states, atol=1e-6)
    assert passage.state[2] == pytest.approx(speed, rel=1e-14)
    torque = friction.torque(rig, speed)
    rates = np.array(state_equations(passage.state, speed, torque, rig)) / units_of(rig).states
    np.testing.assert_allclose(passage.rates, rates, rtol=1e-6, atol=1e-6)


@cases
def test_derivative_agrees_with_differences_of_the_return(rig, friction, speed):
    """By each state off the section and by the speed reference, for states counted from the equilibrium."""
    returns, units = ReturnMap(rig, friction), units_of(rig)
    counted = settled(rig, friction, speed) - frictionless_state(rig, speed)

    def there(change, speed):
        rest = frictionless_state(rig, speed)
        return (returns(rest + counted + change * units.states, speed, False).state - rest) / units.states

    found = returns(counted + frictionless_state(rig, speed), speed).slopes
    h = 2e-4
    for column in OFF_SECTION:
        step = h * np.eye(7)[column]
        difference = (there(step, speed) - there(-step, speed)) / (2 * h)
        np.testing.assert_allclose(found[:, column], difference, atol=3e-6)
    step = h * units.speed
    difference = (there(0.0 * counted, speed + step) - there(0.0 * counted, speed - step)) / (2 * h)
    np.testing.assert_allclose(found[:, 7], difference, atol=3e-6)
    assert np.abs(found[2]).max() < 1e-12


def test_share_in_the_stick_zone_is_that_of_a_trajectory():
    state = settled(*CASES["chapter"])
    passage = RETURNS(state, SPEED)
    run = simulate(RIG, FRICTION, state, SPEED, duration=float(passage.time), sample_period=1e-4)
    assert passage.stuck == pytest.approx(np.mean(np.abs(run.bit_speed) < RIG.omega_s), abs=2e-4)


def test_the_section_point_itself_does_not_count_again():
    state = settled(RIG, FRICTION, SPEED, 12)
    assert RETURNS(state, SPEED, False).time == pytest.approx(2.46, abs=0.01)


def test_without_the_derivative_the_passage_is_the_same():
    state = settled(RIG, FRICTION, SPEED, 2)
    with_it, without = (RETURNS(state, SPEED, wanted) for wanted in (True, False))
    np.testing.assert_array_equal(with_it.state, without.state)
    assert with_it.time == without.time
    before = state.copy()
    RETURNS(state, SPEED)
    np.testing.assert_array_equal(state, before)


def test_a_bit_that_never_breaks_loose_has_no_passage():
    assert ReturnMap(RIG, Friction(1e6))(np.zeros(7), SPEED) is None


def test_steady_rotation_has_none_either():
    friction = Friction(20.0)
    assert RETURNS(steady_state(RIG, friction, 4.0), 4.0) is None


def test_a_stick_zone_left_very_slowly_is_left():
    """Within a shortest step the bit speed there grows by less than rounding shows."""
    friction = Friction(20.0)
    assert ReturnMap(RIG, friction)(wound_up(RIG, friction, 0.002).reshape(7), 0.002) is not None
