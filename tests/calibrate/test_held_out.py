"""Windows that the fit does not see."""

import numpy as np
import pytest

from drillrig_env import Friction, Rig
from drillrig_env.calibrate.calibration import calibrate
from drillrig_env.calibrate.held_out import split
from drillrig_env.calibrate.projection import Problem
from drillrig_env.calibrate.spread import LEAST_WINDOWS
from drillrig_env.calibrate.unknowns import Unknowns
from drillrig_env.calibrate.windows import Windows
from tests.calibrate.test_calibration import FIXED, STICKING, UNLOADED


@pytest.fixture(scope="module")
def windows():
    return [Windows.of(record, 0.02, length) for record, length in ((STICKING, 1.2), (UNLOADED, 3.0))]


def test_a_share_of_each_record_is_held_out(windows):
    fitted, held = split(windows, 0.2)
    assert [len(one) for one in windows] == [20, 5]
    assert held[0].places.tolist() == [2, 7, 12, 17]
    assert held[1].places.tolist() == [2]
    for whole, one, other in zip(windows, fitted, held, strict=True):
        assert sorted([*one.places, *other.places]) == list(range(len(whole)))
        np.testing.assert_array_equal(other.data, whole.data[other.places])
        np.testing.assert_array_equal(one.forces, whole.forces[one.places])


def test_enough_is_left_to_fit(windows):
    fitted, held = split([windows[1]], 0.5)
    assert (len(fitted[0]), len(held[0])) == (LEAST_WINDOWS, 1)
    fitted, held = split(windows, 0.0)
    assert fitted == windows
    assert [len(one) for one in held] == [0, 0]


def test_some_of_some_keep_their_places(windows):
    some = windows[0].take(np.arange(1, 20, 3)).take(np.array([1, 3]))
    assert some.places.tolist() == [4, 10]
    assert some.whole is windows[0]


def test_starts_are_those_of_the_whole_record(windows):
    unknowns = Unknowns.of(Rig(), Friction(10.0), FIXED)

    def starts(some):
        problem = Problem(list(some), unknowns, [one.noise for one in some])
        problem.begin(np.zeros(len(unknowns.names)))
        problem.residuals(np.zeros(len(unknowns.names)))
        return problem.starts

    fitted, held = split(windows, 0.2)
    whole = starts(windows)
    for some in (fitted, held):
        for expected, one, found in zip(whole, some, starts(some), strict=True):
            np.testing.assert_allclose(found, expected[one.places], atol=1e-4)


def test_a_fit_does_not_see_them():
    fixed = FIXED | dict.fromkeys(("K_T", "mu_k", "mu_s - mu_k", "v_b"))
    found = calibrate([STICKING], None, Friction(10.0), fix=fixed, starts=1)
    (held,) = found.held
    (fitted,) = found.best.problem.windows
    assert len(held) == 1
    assert len(fitted) + 1 == len(fitted.whole)
    assert found.spread.windows == len(fitted)
