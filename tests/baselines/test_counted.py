"""Laws with the chapter's numbers on rigs of other sizes: the chapter's rig scaled, and rigs of their own."""

from dataclasses import replace

import numpy as np
import pytest

from baselines import BASELINES, Constant, JumpEase, SoftTorque, ZTorque
from baselines.counted import CountedLaw
from drillrig_env import Drive, Friction, Rig, Task
from drillrig_env.env.sensors import SENSORS
from drillrig_env.evaluation.runner import run
from drillrig_env.evaluation.scores import score
from drillrig_env.evaluation.suites import suite
from drillrig_env.policy import check_policy, context_of, load, make_policy
from drillrig_env.scales import Scales
from tests.rigs import FAST, FIELD, scaled

FIELD_AT_ITS_SPEEDS = {"rig": FIELD, "largest_reference": 50.0}
RIGS = {"fast": {"rig": FAST}, "field": {"rig": FIELD}, "field at its speeds": FIELD_AT_ITS_SPEEDS}


def played(name, rigs, sensors="state", rig=None):
    """100 control steps of a policy that is made for a rig, over the suite `default` of that rig."""
    task = Task.for_rig(rig, sensors=sensors)
    short = replace(suite("default", rigs, task.scales), env={"duration": 100 * task.control_period})
    return run(make_policy(name, **{**context_of(task), "sensors": sensors}), short, sensors=sensors, rig=rig)


@pytest.mark.parametrize("name", [name for name in BASELINES if name != "mppi"])
def test_a_baseline_acts_alike_on_the_chapters_rig_scaled_bit_for_bit(name):
    time, torque = 0.25, 2.0**12
    ours, theirs = played(name, 6, rig=scaled(time, torque)), played(name, 6)
    np.testing.assert_array_equal(ours.speed_reference * time, theirs.speed_reference)
    np.testing.assert_array_equal(ours.reward, theirs.reward)


def test_late_sensors_and_planning_scale_too():
    for name, sensors, rigs in (("lqg", "surface", 6), ("mppi", "state", 1)):
        ours, theirs = played(name, rigs, sensors, rig=scaled(4.0, 0.5)), played(name, rigs, sensors)
        np.testing.assert_array_equal(ours.speed_reference * 4.0, theirs.speed_reference)


LEAST = {"lqg": 0.9, "z_torque": 0.85, "jump_ease": 0.5}
QUICK = (("lqg", "fast"), ("z_torque", "field at its speeds"), ("jump_ease", "field"))


@pytest.mark.parametrize(
    ("name", "rig"),
    [pytest.param(name, rig, marks=() if (name, rig) in QUICK else pytest.mark.slow) for name in LEAST for rig in RIGS],
)
def test_most_rigs_of_other_sizes_are_mitigated(name, rig):
    given = RIGS[rig]
    task = Task.for_rig(**given)
    episodes = run(make_policy(name, **context_of(task)), suite("default", 60, task.scales), **given)
    assert score(episodes)["mitigated"].mean() >= LEAST[name]


@pytest.mark.parametrize("given", RIGS.values(), ids=RIGS)
def test_policies_know_their_environment_and_keep_the_contract(given):
    for name in ("lqg", "jump_ease", "feed_forward_start"):
        policy = make_policy(name, **given)
        env = policy.make_env()
        assert env.unwrapped.task == Task.for_rig(**given)
        assert context_of(load(name, env=env).task) == context_of(policy.task)
        check_policy(name, **given)


def test_what_a_law_sees_is_counted_and_what_it_wants_turned_back():
    class Law(CountedLaw):
        def desired_reference(self, seen, privileged, memory):
            self.seen = seen
            return seen["speed_target"] + 1.0

    policy = Law(SENSORS["state"].names, FIELD, largest_reference=50.0)
    assert policy.rig == FIELD
    assert policy.plant == Scales.of(FIELD, 50.0).counted
    env = policy.make_env()
    observation, info = env.reset(seed=0)
    action = policy.predict(observation)[0]
    assert policy.seen["speed_target"] == pytest.approx(info["speed_target"] / 5.0)
    assert policy.seen["bit_speed"] == pytest.approx(info["bit_speed"] / 5.0, abs=1e-6)
    wanted = (info["speed_target"] + 5.0 - info["speed_reference"]) / (policy.slew_limit * policy.task.control_period)
    assert action[0] == pytest.approx(np.clip(wanted, -1.0, 1.0))


def test_counted_rig_of_a_field_string_is_about_the_chapters():
    counted = Scales.of(FIELD, 50.0).counted
    for name in ("J_1", "J_2", "k_1", "k_2", "r_1"):
        assert 0.3 < getattr(counted, name) / getattr(Rig(), name) < 3.0
    assert counted.impedance == pytest.approx(Rig().impedance)


def test_a_soft_drive_is_set_in_the_units_of_its_rig():
    for time, torque in ((2.0, 8.0), (0.25, 0.5)):
        own, soft = SoftTorque().drive, SoftTorque(rig=scaled(time, torque)).drive
        assert soft == Drive(own.k_p * time, own.k_i, own.back_emf_share)


def test_gains_that_are_given_count_in_the_scales_of_the_rig():
    law = ZTorque(rig=FIELD, gain=5.0)
    assert (law.gain, law.time_constant) == (5.0, ZTorque().time_constant)
    assert JumpEase(rig=FIELD).margin == JumpEase().margin


def test_a_law_in_physical_units_sees_them_on_every_rig():
    assert not issubclass(Constant, CountedLaw)
    friction = Scales.of(FIELD, 50.0).friction
    assert friction.torque(FIELD, 1e-9) < friction.torque(FIELD, 1e-3)
    assert Friction(friction.normal_force).normal_force == pytest.approx(2108.6, rel=1e-3)


def test_a_finer_control_period_is_what_filters_go_by():
    law, finer = ZTorque(), ZTorque(control_period=0.05)
    assert (law.each_step(0.4), law.followed(2.0)) == (0.4, 1.0 - np.exp(-0.05))
    assert 1.0 - (1.0 - finer.each_step(0.4)) ** 2 == pytest.approx(0.4)
    assert finer.period == 0.05
    shares = []
    for period in (0.1, 0.05):
        episodes = run(make_policy("lqg", control_period=period), suite("default", 20), control_period=period)
        shares.append(score(episodes)["mitigated"].mean())
    assert shares[1] >= 0.85 * shares[0]
