"""The law that is designed for each rig as it was calibrated: where that is the rig as it is, it is the told one's."""

import numpy as np
import pytest

from baselines.calibrated import LQGCalibrated
from baselines.told import LQGOfRig
from baselines.tune import tuning_suite
from drillrig_env import Rig
from drillrig_env.evaluation.runner import run
from drillrig_env.fleet import Fleet
from drillrig_env.policy import check_policy, make_policy


@pytest.fixture(scope="module")
def suite():
    return tuning_suite("unknown", 2, 594_000_000)


def references(kind, suite, **given):
    policy = kind("surface", fleet=suite.scenario.rigs, **given)
    return run(policy, suite, sensors="surface", duration=10.0).speed_reference


def test_on_rigs_as_they_are_it_acts_as_the_told_one_to_the_last_bit(suite):
    """Rigs and factors of friction that were found, given one by one, are those of the fleet that is played."""
    true = suite.scenario.rigs.members()
    same = Fleet(rigs=true.rigs, friction=tuple(map(tuple, true.friction.tolist())))
    told = references(LQGOfRig, suite)
    np.testing.assert_array_equal(references(LQGCalibrated, suite, found=same), told)
    others = Fleet(rigs=true.rigs, friction=tuple(map(tuple, true.friction[:, ::-1].tolist())))
    assert np.abs(references(LQGCalibrated, suite, found=others) - told).max() > 1e-3


def test_it_is_told_nothing_but_which_rig_it_is_at():
    assert LQGCalibrated.privileged == ("rig",)
    check_policy(LQGCalibrated, found=[Rig()])


def test_it_is_not_designed_on_the_rigs_that_it_plays(suite):
    with pytest.raises(ValueError, match="LQGCalibrated: found is missing; allowed: a Fleet of the rigs as calibrated"):
        make_policy(LQGCalibrated, sensors="surface", fleet=suite.scenario.rigs)
    with pytest.raises(ValueError, match="rigs found = 1 is not allowed; allowed: 2, one for each of the fleet"):
        LQGCalibrated("surface", fleet=suite.scenario.rigs, found=[Rig()])
