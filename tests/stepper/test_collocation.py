"""One solved step: that it obeys the law at its nodes, and where it says that it leaves a piece of it."""

import numpy as np
import pytest
from scipy.integrate import solve_ivp

from drillrig_env import Friction, Rig
from drillrig_env.model import friction_input, jacobian
from drillrig_env.stepper.collocation import solve_nodes
from drillrig_env.stepper.exponentials import RADAU_NODES
from drillrig_env.stepper.ladder import RUNGS
from drillrig_env.stepper.reach import crossing
from drillrig_env.stepper.tables import step_tables
from drillrig_env.stepper.workspace import workspace

RIG, OMEGA_REF = Rig(), 2.0
CONTACT = Friction(20.0).contacts(RIG, OMEGA_REF)[0]
STATIC, KINETIC, OMEGA_S = 20.0 * 0.0485 * 0.5, 20.0 * 0.0485 * 0.306, 1e-3
TABLES = step_tables(RIG, 0.1)


def law(zone, speed):
    if zone == 0:
        return STATIC * speed / OMEGA_S
    return zone * (KINETIC + (STATIC - KINETIC) * np.exp(-zone * speed))


def ladder_of(fine):
    """The ladder, as one whose kinks are met exactly by all steps, or guessed."""
    ladder = TABLES.ladders.copy()
    ladder["fine_from"] = 0 if fine else RUNGS
    return ladder[0]


def solved(y, zone, rung, fine=True):
    work = workspace()[0]
    reach = solve_nodes(np.array([*y, 0.0]), zone, CONTACT, ladder_of(fine), rung, work)
    return reach, work


def exact(y, zone, step):
    """The rig with one piece of the law, continued, and when it leaves its zone, by SciPy."""

    def rates(_, y):
        return jacobian(RIG) @ y + friction_input(RIG) * law(zone, y[2] + OMEGA_REF)

    def leaves(_, y):
        speed = y[2] + OMEGA_REF
        return OMEGA_S - abs(speed) if zone == 0 else zone * speed - OMEGA_S

    return solve_ivp(rates, (0.0, step), y, "Radau", events=leaves, dense_output=True, rtol=1e-10, atol=1e-13)


SLIPPING = np.array([-0.3, -0.8, 0.5, 0.8, 0.2, 0.1, 0.1])
BACKWARDS = np.array([0.6, 1.5, -4.0, -3.5, 0.2, 0.1, 0.1])
SLOWING = np.array([-0.05, -0.2, -1.85, -1.3, 0.2, 0.1, 0.1])  # the bit at 0.15 rad/s, about to stick


@pytest.mark.parametrize(("y", "zone"), [(SLIPPING, 1), (BACKWARDS, -1)])
@pytest.mark.parametrize("rung", [2, 4, 6])
def test_solved_step_follows_the_rig_at_its_nodes(y, zone, rung):
    reach, work = solved(y, zone, rung)
    assert reach == 1.0
    speeds = exact(y, zone, 0.1 / 2**rung).sol(RADAU_NODES * 0.1 / 2**rung)[2] + OMEGA_REF
    np.testing.assert_allclose(work["speed"], speeds, atol=1e-7)
    np.testing.assert_allclose(work["torque"], law(zone, work["speed"]), atol=1e-8)


@pytest.mark.parametrize("rung", [3, 4, 5])
def test_a_kink_is_met_where_the_bit_reaches_the_edge_of_the_stick_zone(rung):
    step = 0.1 / 2**rung
    hit = exact(SLOWING, 1, 0.1).t_events[0]
    reach, _ = solved(SLOWING, 1, rung)
    if hit[0] < step:
        assert reach == pytest.approx(hit[0] / step, abs=2e-4)
    else:
        assert reach == 1.0
    assert 0.0 < hit[0] < 0.05  # it does stick, within the longest of these steps or soon after


def nodes_at(speeds):
    work = workspace()[0]
    work["speed"] = speeds
    return work


@pytest.mark.parametrize(("zone", "edge"), [(1, 1e-3), (-1, -1e-3)])
@pytest.mark.parametrize("share", [0.05, 0.2, 0.6, 0.95])
def test_crossing_of_a_straight_line_is_found_by_guess_and_by_search(zone, edge, share):
    start = edge + zone * 0.4 * share
    work = nodes_at(start - zone * 0.4 * RADAU_NODES)
    for fine in (False, True):
        assert crossing(start, zone, CONTACT, fine, work) == pytest.approx(share, abs=1e-9)


def test_crossing_of_a_curve_is_the_root_of_the_quartic_through_the_nodes():
    """Speed 0.3 - 0.2 s - 0.5 s^2 + 0.1 s^4 reaches 0.001 where it does."""
    curve = np.polynomial.Polynomial([0.3, -0.2, -0.5, 0.0, 0.1])
    root = next(r.real for r in (curve - 1e-3).roots() if abs(r.imag) < 1e-9 and 0 < r.real < 1)
    assert crossing(0.3, 1, CONTACT, True, nodes_at(curve(RADAU_NODES))) == pytest.approx(root, abs=1e-9)
    assert crossing(0.3, 1, CONTACT, False, nodes_at(curve(RADAU_NODES))) == pytest.approx(root, abs=0.1)


@pytest.mark.parametrize("speeds", [(0.09, -0.03, -0.36, -0.72), (0.42, 0.15, -0.05, 0.02)])
def test_a_search_that_leaves_the_step_tells_of_nocrossing(speeds):
    """Newton's method ends at another root of the quartic: past the step's end, and before its beginning."""
    assert 0.0 < crossing(0.3, 1, CONTACT, False, nodes_at(speeds)) < 1.0
    assert crossing(0.3, 1, CONTACT, True, nodes_at(speeds)) == 0.0


@pytest.mark.parametrize("side", [1.0, -1.0])
def test_stick_ends_at_the_edge_that_the_bit_goes_through(side):
    work = nodes_at(side * 1e-2 * RADAU_NODES)
    assert crossing(0.0, 0, CONTACT, True, work) == pytest.approx(0.1, abs=1e-9)


def test_no_crossing_is_told_where_the_step_begins_on_the_other_side():
    assert crossing(5e-4, 1, CONTACT, False, nodes_at(5e-4 - 0.1 * RADAU_NODES)) == 0.0


def test_a_step_too_long_for_a_cubic_torque_holds_nowhere():
    """The law's slope turns the bit round within a step of 0.1 s; the defect of the cubic tells."""
    fast = np.array([-0.8, -0.8, -1.7, 3.0, 0.2, 0.1, 0.1])
    reach, _ = solved(fast, 1, 0)
    assert reach == 0.0
    assert solved(fast, 1, 6)[0] == 1.0
