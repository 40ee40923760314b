"""The tables against exact solutions of the linear rig, and the ladder that they are put on."""

import numpy as np
import pytest
from scipy.integrate import solve_ivp
from scipy.linalg import expm

from drillrig_env import Drive, Friction, Rig
from drillrig_env.model import friction_input, frictionless_state, jacobian, torque_into_string
from drillrig_env.stepper import tables
from drillrig_env.stepper.exponentials import NODES, POWERS_FROM_NODES, RADAU_NODES
from drillrig_env.stepper.ladder import (
    LADDER,
    RUNG,
    SAMPLED_RUNGS,
    SAMPLES_OF_RUNGS,
    STATE,
    UNIT_RUNG,
    UNITS,
    from_equilibrium,
    rows_of,
    to_states,
)
from drillrig_env.stepper.rungs import longest_rungs
from drillrig_env.stepper.tables import build_tables, step_tables

RIG = Rig(T_r2=0.05)
TABLES = step_tables(RIG, 0.08)
LADDER_OF_RIG = TABLES.ladders[0]
Y = np.array([-0.4, -1.3, 2.0, 1.0, 3.0, 0.3, 0.4])
CUBIC = np.array([0.3, -0.2, 0.5, 0.7])


def torque(share):
    """A cubic of the share of a step, N m."""
    return np.polynomial.polynomial.polyval(share, CUBIC)


def solution(step, shares):
    """The rig from Y under that torque, by SciPy."""
    rates = lambda t, y: jacobian(RIG) @ y + friction_input(RIG) * torque(t / step)  # noqa: E731
    solved = solve_ivp(rates, (0.0, step), Y, "Radau", t_eval=step * np.asarray(shares), rtol=1e-11, atol=1e-13)
    return solved.y.T


def test_nodes_are_the_radau_points_of_the_books():
    """Hairer & Wanner, Solving Ordinary Differential Equations II: the right Radau points of order 4."""
    expected = [0.08858795951270394, 0.4094668644407347, 0.787659461760847, 1.0]
    np.testing.assert_allclose(RADAU_NODES, expected, atol=1e-14)
    np.testing.assert_allclose(POWERS_FROM_NODES @ torque(RADAU_NODES), CUBIC, atol=1e-12)


@pytest.mark.parametrize("rung", [0, 1, 4])
def test_state_at_the_end_and_speed_at_the_nodes_are_exact_for_a_cubic_torque(rung):
    table, step = LADDER_OF_RIG["rungs"][rung], 0.08 / 2**rung
    at_nodes = solution(step, RADAU_NODES)
    end = Y @ table["state_from_state"] + torque(RADAU_NODES) @ table["state_from_torque"]
    np.testing.assert_allclose(end[:7], at_nodes[-1], atol=1e-8)
    assert end[7:].tolist() == [0.0] * (STATE - 7)
    speeds = Y @ table["node_from_state"] + table["node_from_torque"] @ torque(RADAU_NODES)
    np.testing.assert_allclose(speeds, at_nodes[:, 2], atol=1e-8)


@pytest.mark.parametrize("rung", range(SAMPLED_RUNGS))
def test_samples_lie_at_equal_distances_the_last_at_the_end(rung):
    table, (before, count) = LADDER_OF_RIG["sampling"], rows_of.py_func(rung)
    states = solution(0.08 / 2**rung, np.arange(1, count + 1) / count)
    for name, expected in (("speed", states[:, 2]), ("torque", torque_into_string(RIG, states))):
        from_state, from_torque = (
            table[f"{name}_from_{source}"][before * length :][: count * length].reshape(length, count)
            for source, length in (("state", 7), ("torque", NODES))
        )
        found = Y @ from_state + torque(RADAU_NODES) @ from_torque
        np.testing.assert_allclose(found, expected, atol=1e-8)
    assert LADDER_OF_RIG["torque_row"][:7] @ Y == pytest.approx(torque_into_string(RIG, Y))


def test_tables_of_samples_lie_one_after_the_other():
    found = [rows_of.py_func(rung) for rung in range(SAMPLED_RUNGS)]
    assert found == [(0, 16), (16, 8), (24, 4), (28, 2)]
    assert found[-1][0] + found[-1][1] == SAMPLES_OF_RUNGS


def test_rungs_are_halves_down_to_one_unit():
    assert len(LADDER_OF_RIG["rungs"]) == UNIT_RUNG + 1
    assert 2**UNIT_RUNG == UNITS
    np.testing.assert_allclose(LADDER_OF_RIG["rate_from_state"][:, :7], jacobian(RIG).T * 0.08)
    np.testing.assert_allclose(LADDER_OF_RIG["rate_from_torque"][:7], friction_input(RIG) * 0.08)
    for rung in (0, 1, UNIT_RUNG):
        table, expected = LADDER_OF_RIG["rungs"][rung], expm(jacobian(RIG) * (0.08 / 2**rung))
        np.testing.assert_allclose(table["state_from_state"][:, :7], expected.T, atol=1e-12)


@pytest.mark.parametrize("rig", [RIG, Rig(T_f=0.3)])
@pytest.mark.parametrize("speed", [0.0, 1.0, 7.3])
def test_states_are_counted_from_the_frictionless_equilibrium(rig, speed):
    contact, ladder = Friction(20.0).contacts(rig, speed)[0], step_tables(rig, 0.1).ladders[0]
    states, y = np.zeros(STATE), np.zeros(STATE)
    to_states(y, contact, ladder, states)
    np.testing.assert_allclose(states[:7], frictionless_state(rig, speed), atol=1e-12)
    from_equilibrium(states, contact, ladder, y)
    np.testing.assert_allclose(y, 0.0, atol=1e-12)
    from_equilibrium(states + np.array([*Y, 0.0]), contact, ladder, y)
    np.testing.assert_allclose(y[:7], Y, atol=1e-12)


def test_tolerance_scales_the_bounds_on_the_errors_of_a_step():
    usual, coarse = step_tables(RIG, 0.1), step_tables(RIG, 0.1, 1e-4)
    for name in ("largest_defect", "newton_tolerance"):
        np.testing.assert_allclose(coarse.ladders[name], 100.0 * usual.ladders[name])
    np.testing.assert_array_equal(coarse.ladders["rungs"], usual.ladders["rungs"])


def test_tables_are_built_once_and_cannot_be_written():
    built = step_tables(RIG, 0.08)
    assert step_tables(RIG, 0.08) is built
    assert not built.ladders.flags.writeable


@pytest.mark.parametrize("tolerance", [1e-7, 1e-3])
def test_ends_of_the_range_of_tolerances_are_allowed_and_beyond_is_not(tolerance):
    assert step_tables(RIG, 0.1, tolerance).period == 0.1
    with pytest.raises(ValueError, match="tolerance"):
        step_tables(RIG, 0.1, tolerance * (0.99 if tolerance < 1e-5 else 1.01))


def test_shapes_hold_all_nodes():
    assert RUNG["node_from_torque"].shape == (NODES, NODES)


def test_a_rig_takes_no_more_than_40_kilobytes():
    assert LADDER.itemsize <= 40_000


def test_rigs_side_by_side_have_the_tables_that_they_have_by_themselves():
    rigs = RIG, Rig(J_1=0.05), Rig(L=1e-8)
    beside = build_tables(rigs, 0.08)
    for number, rig in enumerate(rigs):
        alone = step_tables(rig, 0.08).ladders[0]
        for name in LADDER.names:
            if name not in ("number", "make_shortest", "shortest", "below", "above"):  # places
                np.testing.assert_array_equal(beside.ladders[number][name], alone[name])
    assert beside.ladders["number"].tolist() == list(range(len(beside.ladders)))


def test_tables_that_are_known_are_taken_and_only_the_others_made(monkeypatch):
    rigs, drive = (Rig(), RIG, Rig(J_1=0.05)), Drive(k_p=1.0, k_i=0.5)
    known, anew, softer = build_tables(rigs[:2], 0.08), build_tables(rigs, 0.08), build_tables(rigs, 0.08, drive=drive)
    made = list[float]()
    monkeypatch.setattr(tables, "longest_rungs", lambda *given: made.append(given[2]) or longest_rungs(*given))
    beside = build_tables(rigs, 0.08, known=known)
    assert len(made) == 2  # the third rig, and the second one's disc 2 in stick
    other = build_tables(rigs, 0.08, drive=drive, known=known)
    assert len(made) == 2 + len(other.ladders)
    for name in LADDER.names:
        if name not in ("make_shortest", "shortest"):
            np.testing.assert_array_equal(beside.ladders[name], anew.ladders[name])
            np.testing.assert_array_equal(other.ladders[name], softer.ladders[name])
    assert not beside.ladders["shortest"].any()
