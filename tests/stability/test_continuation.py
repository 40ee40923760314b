"""Following a branch of orbits: what cannot be followed from its first point on is lost there."""

from types import SimpleNamespace

import numpy as np
import pytest

from drillrig_env import Friction, Rig
from drillrig_env.stability import continuation
from drillrig_env.stability.continuation import end_of_branch
from drillrig_env.stability.return_map import ReturnMap

POINTS = {
    "none": None,
    "falls": SimpleNamespace(rises=False, is_stable=True),
    "is unstable": SimpleNamespace(rises=True, is_stable=False),
}


@pytest.mark.parametrize("point", POINTS.values(), ids=POINTS)
def test_a_branch_that_is_no_stable_one_on_its_way_up_is_lost_where_it_is(point, monkeypatch):
    monkeypatch.setattr(continuation, "_corrected", lambda *_: point)
    returns, orbit = ReturnMap(Rig(), Friction(10.0)), SimpleNamespace(state=np.zeros(7))
    assert end_of_branch(returns, 2.5, orbit) == (2.5, "lost")
