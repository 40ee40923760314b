"""Laws that are told the rig: each is the law of that very rig, and knowing it is worth something."""

import numpy as np
import pytest

from baselines import LQG, JumpEase
from baselines.jump_ease import swing_of_a_ramp
from baselines.told import FirmLQROfRig, JumpEaseOfBit, JumpEaseOfRig, LQGOfRig, LQROfRig
from baselines.tune import tuning_suite
from drillrig_env import Friction, Rig
from drillrig_env.env.core import EpisodeBatch
from drillrig_env.env.generators import first_uniforms
from drillrig_env.evaluation.runner import run
from drillrig_env.evaluation.scores import score
from drillrig_env.fleet import Fleet
from drillrig_env.model import steady_state
from drillrig_env.policy import check_policy
from drillrig_env.scales import Scales
from drillrig_env.stability import basin_depth, critical_speed, fold_speed
from tests.rigs import FIELD

TOLD = (FirmLQROfRig, JumpEaseOfBit, JumpEaseOfRig, LQGOfRig, LQROfRig)
RIGS = (Rig(k_2=0.5, J_1=0.02), Rig(), Rig(k_1=0.8, K_T=0.12, K_E=0.07, J_3=0.03))
FLEET = Fleet(rigs=RIGS)


def on_rig(k, sensors="surface", **env):
    """A batch of one, turning steadily at 3 rad/s on a rig of the fleet."""
    env = {"noise": 0.0, "delay": 0, **env}
    core = EpisodeBatch(1, scenario={"rigs": FLEET, "spread": 0.0}, sensors=sensors, threads=1, **env)
    pins = {"rig": k, "start": "steady", "speed_target": 3.0, "normal_force": 12.0, "load_steps": []}
    core.reset(np.array([0]), first_uniforms(0, 1), pins)
    return core


@pytest.mark.parametrize("kind", TOLD)
def test_each_keeps_the_contract_with_a_fleet_and_without(kind):
    check_policy(kind)
    check_policy(kind, fleet=FLEET)


@pytest.mark.parametrize("kind", [FirmLQROfRig, JumpEaseOfRig, LQGOfRig, LQROfRig])
def test_an_episode_gets_the_law_of_its_own_rig(kind):
    """As a policy that knows no other rig has it, on the same observations."""
    random = np.random.default_rng(0)
    fleet = kind("surface", fleet=FLEET)
    seen = (0.3 * random.standard_normal((20, 3, len(fleet.sensors.names)))).astype(np.float32)
    told = {
        "normal_force": [12.0, 20.0, 8.0],
        "mu_s": [0.5, 0.6, 0.4],
        "mu_k": [0.3, 0.3, 0.25],
        "v_b": [1.0, 0.8, 2.0],
    }
    told = {name: np.array(values) for name, values in told.items()}
    alone = [kind("surface", fleet=Fleet(rigs=(rig,))) for rig in RIGS]
    states = [None] * 4
    for step in range(20):
        fleet.tell({**told, "rig": np.arange(3)})
        together, states[3] = fleet.predict(seen[step], states[3])
        for k, policy in enumerate(alone):
            policy.tell({**{name: values[k] for name, values in told.items()}, "rig": 0})
            own, states[k] = policy.predict(seen[step, k : k + 1], states[k])
            np.testing.assert_allclose(together[k], own[0], atol=1e-6)


@pytest.mark.parametrize("k", [0, 2])
def test_the_filter_of_the_very_rig_finds_state_and_friction_torque(k):
    """From what a drive of the nominal rig reports; a filter of the nominal rig is far off."""
    found = {}
    for kind in (LQG, LQGOfRig):
        core, policy, state = on_rig(k), kind("surface", fleet=FLEET, delay=0), None
        for _ in range(300):
            policy.tell(core.info())
            actions, state = policy.predict(core.observations, state)
            core.step(actions)
        states, level = policy.estimate(state, core.episodes["speed_target"])
        friction = core.friction.single()
        true = steady_state(core.bank.rigs[k], friction, 3.0)
        found[kind] = np.abs(states[0] - true).max(), abs(level[0] - friction.torque(RIGS[k], 3.0))
    assert max(found[LQGOfRig]) < 0.02
    assert max(found[LQG]) > 5.0 * max(found[LQGOfRig])


def test_jump_ease_goes_by_critical_speed_fold_and_basin_of_the_very_rig():
    policy = JumpEaseOfRig("surface", fleet=FLEET)
    names = ("normal_force", "mu_s", "mu_k", "v_b")
    memory = np.zeros((3, policy.memory))
    told = {"mu_s": np.full(3, 0.5), "mu_k": np.full(3, 0.306), "v_b": np.ones(3)}
    told |= {"rig": np.arange(3.0), "normal_force": np.array([20.0, 14.0, 25.0])}
    seen = {name: np.full(3, 1.5) for name in ("speed_reference", "speed_target", "top_speed", "string_torque")}
    policy.desired_reference(seen, told, memory)
    for k, rig in enumerate(RIGS):
        friction = Friction(**{name: float(told[name][k]) for name in names})
        floor = critical_speed(rig, friction) + policy.margin
        rate = policy.of_basin * basin_depth(rig, friction, floor) / swing_of_a_ramp(rig)
        assert memory[k, -3:] == pytest.approx([floor, 1.1 * fold_speed(rig, friction), rate], rel=1e-9)
    before = memory.copy()
    policy.desired_reference(seen, {**told, "normal_force": np.array([20.0, 17.0, 25.0])}, memory)
    changed = (memory[:, -3:-1] != before[:, -3:-1]).all(axis=1)
    assert changed.tolist() == [False, True, False]


def test_on_the_nominal_rig_jump_ease_is_what_it_was():
    suite = tuning_suite("load", 8, 596_000_000)
    ours, theirs = (run(kind("surface"), suite, sensors="surface") for kind in (JumpEaseOfRig, JumpEase))
    np.testing.assert_array_equal(ours.speed_reference, theirs.speed_reference)


@pytest.mark.slow
def test_what_knowing_is_worth():
    """Filter and gains of the very rig are worth much, and a state that is shown is worth more."""
    suite, mitigated = tuning_suite("unknown_hard", 16, 595_000_000), []
    for kind in (LQG, LQGOfRig, LQROfRig):
        policy = kind("surface", fleet=suite.scenario.rigs)
        mitigated.append(score(run(policy, suite, sensors="surface"))["mitigated"].mean())
    assert np.diff(mitigated).min() > 0.03


def test_a_rig_that_is_not_of_the_fleet_is_refused():
    policy = LQGOfRig("surface", fleet=FLEET)
    policy.tell({"rig": [3], "mu_s": [0.5], "mu_k": [0.3], "v_b": [1.0]})
    with pytest.raises(ValueError, match=r"LQGOfRig: rig = 3 is not allowed; allowed: 0 to 2, the fleet"):
        policy.predict(np.zeros((1, len(policy.sensors.names)), dtype=np.float32))


def test_rigs_around_one_of_another_size_are_counted_in_its_scales():
    fleet = Fleet.around(FIELD, spread={"string": 1.5, "inertias": 1.5}, count=3)
    policy, scales = LQROfRig(rig=FIELD, fleet=fleet), Scales.of(FIELD)
    for plant, rig in zip(policy.plants, fleet.members(FIELD).rigs, strict=True):
        for name in ("k_1", "J_3"):
            factor = getattr(rig, name) / getattr(FIELD, name)
            assert getattr(plant, name) == pytest.approx(factor * getattr(policy.plant, name), rel=1e-12)
    assert scales.count(FIELD) == scales.counted == policy.plant


def test_the_hand_is_the_firmer_the_nearer_to_calm():
    """Feedback far from calm as with the one effort alone, at calm as with the other, and between them in between."""
    firm = FirmLQROfRig(fleet=FLEET, effort=30.0, calm_effort=0.3)
    alone = [LQROfRig(fleet=FLEET, effort=effort) for effort in (0.3, 30.0)]
    places, friction = np.zeros(4, dtype=np.intp), Friction(20.0)
    shaking = np.array([0.0, firm.calm, (firm.calm + firm.shaking) / 2.0, 2.0 * firm.shaking])
    found, near, far = (one._feedback(friction, np.full(4, 3.0), places, shaking) for one in (firm, *alone))
    assert not np.allclose(near, far)
    np.testing.assert_allclose(found, [near[0], near[1], (near[2] + far[2]) / 2.0, far[3]], rtol=1e-12)
