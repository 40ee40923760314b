"""The shortest steps: made when they are needed, right, and the same for whoever asks."""

from concurrent.futures import ThreadPoolExecutor

import numpy as np
import pytest
from scipy.linalg import expm

from drillrig_env import Friction, Rig
from drillrig_env.jit.compiled import compiled
from drillrig_env.model import jacobian
from drillrig_env.stepper import shortest
from drillrig_env.stepper.batch import advance_batch
from drillrig_env.stepper.finite import NotFiniteError
from drillrig_env.stepper.ladder import DEPTH, RUNGS, UNIT_RUNG, table_of
from drillrig_env.stepper.tables import TOLERANCE, build_tables, step_tables

RIGS = Rig(), Rig(J_1=0.05, L=0.01), Rig(R=3.0, L=4e-9)
LIGHTNING = Rig(R=3.0, L=4e-9)  # an armature so fast that a landing takes the shortest steps


@compiled
def _entry(ladders, number, rung):
    """An entry of the tables of a rung, as a kernel finds it."""
    table = table_of(ladders[number], rung)
    return table.state_from_state[2, 2], table.node_from_torque[3, 3]


@compiled
def _states(ladders, number, rung, out):
    table = table_of(ladders[number], rung)
    for i in range(7):
        for k in range(7):
            out[i, k] = table.state_from_state[k, i]


def test_nothing_is_made_before_a_kernel_asks_and_then_for_that_rig_alone():
    tables = build_tables(RIGS, 0.1)
    _entry(tables.ladders, 1, UNIT_RUNG)
    assert tables.ladders["shortest"].tolist() == [0, 0, 0]
    found = _entry(tables.ladders, 1, UNIT_RUNG + 1)
    made = tables.ladders["shortest"].tolist()
    assert (made[0], made[2]) == (0, 0)
    assert made[1] != 0
    assert _entry(tables.ladders, 1, UNIT_RUNG + 1) == found
    assert tables.ladders["shortest"].tolist() == made


@pytest.mark.parametrize("number", range(len(RIGS)))
@pytest.mark.parametrize("rung", [UNIT_RUNG, UNIT_RUNG + 1, 25, RUNGS - 1])
def test_they_go_on_where_the_longer_ones_end(number, rung):
    """A kernel finds the flow over the step of the very rung, each half as long as the one before."""
    tables, found = build_tables(RIGS, 0.1), np.empty((7, 7))
    _states(tables.ladders, number, rung, found)
    np.testing.assert_allclose(found[:5, :5], expm(jacobian(RIGS[number]) * 0.1 / 2**rung)[:5, :5], atol=1e-12)


def test_threads_that_ask_at_once_find_the_same():
    tables = build_tables(RIGS, 0.1)
    with ThreadPoolExecutor(8) as pool:
        found = list(pool.map(lambda k: _entry(tables.ladders, k % 3, UNIT_RUNG + 1 + k // 3 % DEPTH), range(300)))
    for k in range(66, 300):
        assert found[k] == found[k - 66]


def test_whether_they_were_there_before_changes_no_bit():
    run = lambda: advance_batch(LIGHTNING, Friction(20.0), np.zeros((1, 7)), 2.0, periods=40)  # noqa: E731
    step_tables.cache_clear()
    first, ladders = run(), step_tables(LIGHTNING, 0.1, TOLERANCE, None).ladders
    assert ladders["shortest"][0] != 0  # they were needed
    np.testing.assert_array_equal(run(), first)


def test_where_they_cannot_be_made_the_rig_is_lost_and_no_number_is_wrong(monkeypatch):
    def without_memory(*_):
        raise MemoryError

    step_tables.cache_clear()
    monkeypatch.setattr(shortest, "shortest_rungs", without_memory)
    with pytest.raises(NotFiniteError, match="is not known"):
        advance_batch(LIGHTNING, Friction(20.0), np.zeros((1, 7)), 2.0, periods=40)
    monkeypatch.undo()
    assert np.isfinite(advance_batch(LIGHTNING, Friction(20.0), np.zeros((1, 7)), 2.0, periods=40)).all()
