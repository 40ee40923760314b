"""Steps across the edges of the stick zone, against the event-split reference."""

import numpy as np
import pytest

from drillrig_env import Friction, Rig
from drillrig_env.model import wound_up
from drillrig_env.reference import radau
from drillrig_env.simulation import simulate
from drillrig_env.stepper.collocation import solve_nodes
from drillrig_env.stepper.kinks import step_through_kinks
from drillrig_env.stepper.ladder import STATE, from_equilibrium, to_states
from drillrig_env.stepper.tables import step_tables
from drillrig_env.stepper.workspace import workspace

RIG, FRICTION, OMEGA_REF = Rig(), Friction(20.0), 2.0
CONTACT = FRICTION.contacts(RIG, OMEGA_REF)[0]
TABLES = step_tables(RIG, 0.1)
LADDER = TABLES.ladders[0]
RUNG = 5
STEP = 0.1 / 2**RUNG


def after(state, seconds):
    return radau(RIG, FRICTION, OMEGA_REF, state, np.array([0.0, seconds]), rtol=1e-9, atol=1e-11)[0]


def stepped(state, zone):
    """A step of STEP through the kinks: whether it was taken, and the state then."""
    y, states, work = np.zeros(STATE), np.zeros(STATE), workspace()[0]
    from_equilibrium(np.append(state, 0.0), CONTACT, LADDER, y)
    reach = solve_nodes(y, zone, CONTACT, LADDER, RUNG, work)
    assert reach < 1.0  # there is a kink on the way
    taken = step_through_kinks(y, zone, CONTACT, LADDER, RUNG, work, reach)
    to_states(y, CONTACT, LADDER, states)
    return taken, states[:7]


def about_to_break_loose():
    """A bit that has crept in the stick zone, a millisecond before it leaves it."""
    wound = wound_up(RIG, FRICTION, OMEGA_REF)
    wound[0] *= 0.99
    times = np.arange(0.0, 0.06, 1e-3)
    states = radau(RIG, FRICTION, OMEGA_REF, wound, times, rtol=1e-9, atol=1e-11)
    return states[np.flatnonzero(states[:, 2] > RIG.omega_s)[0] - 1]


@pytest.mark.parametrize(
    ("state", "zone"),
    [
        (np.array([0.1, -0.5, 0.004, 0.0, 2.0, 0.8, 4.0]), 1),  # slips, and sticks within the step
        (np.array([-0.1, -0.5, -0.004, 0.0, 2.0, 0.8, 4.0]), -1),  # slips backwards, and sticks
        (about_to_break_loose(), 0),  # sticks, and breaks loose
    ],
)
def test_step_across_a_kink_is_the_solution(state, zone):
    taken, found = stepped(state, zone)
    assert taken
    np.testing.assert_allclose(found, after(state, STEP), atol=1e-8)


def test_step_that_begins_with_the_fast_settling_of_a_stick_is_the_solution():
    """The bit is slow to the wrong side, and settles within microseconds: no cubic follows that, but the split does."""
    state = wound_up(RIG, FRICTION, OMEGA_REF)
    state[:2] *= 0.5
    state[2] = -0.5 * RIG.omega_s
    taken, found = stepped(state, 0)
    assert taken
    np.testing.assert_allclose(found, after(state, STEP), atol=1e-8)


def test_state_is_left_as_it_was_where_the_step_cannot_be_taken():
    """From a node that tells of no crossing: the reach is 0 while the bit slips."""
    state = np.array([0.1, -0.5, 0.004, 0.0, 2.0, 0.8, 4.0])
    y, work = np.zeros(STATE), workspace()[0]
    from_equilibrium(np.append(state, 0.0), CONTACT, LADDER, y)
    before = y.copy()
    solve_nodes(y, 1, CONTACT, LADDER, RUNG, work)
    assert not step_through_kinks(y, 1, CONTACT, LADDER, RUNG, work, 0.0)
    np.testing.assert_array_equal(y, before)


@pytest.mark.parametrize(("rig", "force"), [(Rig(L=1e-5), 20.0), (Rig(L=1e-5), 3.0), (Rig(L=1e-7), 30.0)])
def test_a_rig_with_a_mode_too_fast_for_the_series_takes_shorter_steps(rig, force):
    arguments = {"friction": Friction(force), "speed_reference": 2.0, "duration": 3.0, "sample_period": 0.05}
    fast, exact = (simulate(rig, method=method, **arguments) for method in ("fast", "radau"))
    np.testing.assert_allclose(fast.state[:, 2:5], exact.state[:, 2:5], atol=1e-6)
