"""What a critic sees besides: exact, scaled, the same in every form, and nothing of it changes what a policy sees."""

import copy
import pickle
import warnings
from dataclasses import replace

import gymnasium as gym
import numpy as np
import pytest
from gymnasium.utils.env_checker import check_env as check_gymnasium
from stable_baselines3 import PPO
from stable_baselines3.common.env_checker import check_env as check_sb3

from drillrig_env import Fleet, Rig, Scenario, make_sb3
from drillrig_env.env.sensors import LIMIT, SENSORS
from drillrig_env.policy import load

PUSH = np.array([0.4], np.float32)
FLEET = Fleet.around(spread={"string": 2.0, "J_1": 1.5}, count=8)
DRAWN = {"normal_force": (20.0, 10.0), "mu_s": (0.5, 0.25), "mu_k": (0.306, 0.153), "v_b": (1.0, 0.5)}


def by_name(env, seen):
    return dict(zip(env.unwrapped.privileged_channels, np.moveaxis(seen["privileged"], -1, 0), strict=True))


@pytest.mark.parametrize("env_id", ["DrillRig-v0", "DrillRigSurface-v0"])
def test_a_policys_part_is_what_it_sees_without_a_critic(env_id):
    arguments = {"delay": (0, 3), "noise": 1.0, "scenario": Scenario(rigs=FLEET), "duration": 1.0}
    plain, both = (gym.make(env_id, **arguments, privileged=on) for on in (False, True))
    vector = gym.make_vec(env_id, num_envs=2, **arguments, privileged=True, autoreset_mode="SameStep")
    sb3 = make_sb3(2, seed=3, env_id=env_id, **arguments, privileged=True)
    seen, (shown, _), (many, _), shown_too = (
        plain.reset(seed=3)[0],
        both.reset(seed=3),
        vector.reset(seed=3),
        sb3.reset(),
    )
    for step in range(11):
        np.testing.assert_array_equal(seen, shown["policy"])
        np.testing.assert_array_equal(seen, many["policy"][0])
        for part in ("policy", "privileged"):
            np.testing.assert_array_equal(shown[part], many[part][0])
            np.testing.assert_array_equal(many[part], shown_too[part])
        assert both.observation_space.contains(shown)
        assert vector.observation_space.contains(many)
        if step < 10:
            (seen, reward, *_, info), (shown, reward_too, *_, info_too) = (env.step(PUSH) for env in (plain, both))
            assert (reward, info) == (reward_too, info_too)
            many, _, _, _, info = vector.step(np.tile(PUSH, (2, 1)))
            shown_too, _, _, infos = sb3.step(np.tile(PUSH, (2, 1)))
            if step == 9:
                many = info["final_obs"]
                last = [one["terminal_observation"] for one in infos]
                shown_too = {part: np.stack([one[part] for one in last]) for part in last[0]}


def test_it_is_off_unless_it_is_asked_for():
    env = gym.make("DrillRig-v0").unwrapped
    assert isinstance(env.observation_space, gym.spaces.Box)
    assert (env.privileged, env.privileged_channels) == (False, ())
    with pytest.raises(AttributeError, match="privileged cannot be changed"):
        env.privileged = True
    with pytest.raises(ValueError, match="privileged = 'yes' is not allowed; allowed: True or False"):
        gym.make("DrillRig-v0", privileged="yes")


@pytest.mark.parametrize("scenario", ["default", {"wandering": {"time": 2.0}, "target_step": 1.0}])
def test_a_critic_sees_what_is_however_late_and_noisy_a_policy_is(scenario):
    env = gym.make_vec("DrillRigSurface-v0", num_envs=5, privileged=True, delay=(1, 5), noise=3.0, scenario=scenario)
    env.reset(seed=0)
    for _ in range(30):
        seen, *_, info = env.step(np.tile(PUSH, (5, 1)))
    episodes, found = env.core.episodes, by_name(env, seen)
    values = SENSORS["state"].values(seen["privileged"][:, :12])
    for i, name in enumerate(SENSORS["state"].names[:7]):
        np.testing.assert_allclose(values[name], episodes["state"][:, i], atol=3e-6, err_msg=name)
    for name, field in (("bit_speed_mean", "mean"), ("speed_reference", "speed_reference")):
        np.testing.assert_allclose(values[name], episodes[field], atol=3e-6)
    np.testing.assert_allclose(values["bit_speed_deviation"] ** 2, episodes["variance"], atol=1e-5)
    for name, (offset, scale) in DRAWN.items():
        np.testing.assert_allclose(found[name] * scale + offset, info[name], rtol=1e-6)
    np.testing.assert_allclose(found["delay"] * 2.0 + 3.0, info["delay"])
    assert len(found) == 17


def test_rigs_of_a_fleet_are_seen_by_what_they_differ_in():
    rigs = FLEET.members().rigs
    env = gym.make_vec("DrillRig-v0", num_envs=8, privileged=True, scenario=Scenario(rigs=FLEET))
    found = by_name(env, env.reset(seed=0, options={"rig": np.arange(8)})[0])
    assert [name for name in found if name.startswith("rig_")] == [
        "rig_J_1",
        "rig_k_1",
        "rig_k_2",
        "rig_d_1",
        "rig_d_2",
    ]
    for name in ("J_1", "k_2"):
        logs = np.log([getattr(rig, name) / getattr(Rig(), name) for rig in rigs])
        np.testing.assert_allclose(found[f"rig_{name}"], logs / np.abs(logs).max(), rtol=1e-6)
    d_1 = np.array([rig.d_1 - Rig().d_1 for rig in rigs])
    np.testing.assert_allclose(found["rig_d_1"], d_1 / np.abs(d_1).max(), rtol=1e-6)
    nominal, guest = (by_name(env, env.reset(options={"rig": rig})[0]) for rig in (Rig(), Rig(k_2=1e-3)))
    assert all((values == 0.0).all() for name, values in nominal.items() if name.startswith("rig_"))
    assert (guest["rig_k_2"] < -5.0).all()
    assert (guest["rig_J_1"] == 0.0).all()


def test_a_later_fleet_keeps_the_channels():
    env = gym.make("DrillRig-v0", privileged=True, scenario=Scenario(rigs=FLEET)).unwrapped
    env.reset(seed=0)
    wider = Fleet.around(spread={"string": 3.0}, count=8)
    env.scenario = Scenario(rigs=wider)
    seen = by_name(env, env.reset(options={"rig": 3})[0])
    sizes = [abs(np.log(rig.k_1 / Rig().k_1)) for rig in FLEET.members().rigs]
    assert seen["rig_k_1"] == pytest.approx(np.log(wider.members().rigs[3].k_1 / Rig().k_1) / max(sizes), rel=1e-6)
    before = env.step(PUSH)[0]
    assert before["privileged"][-5:] == pytest.approx([seen[name] for name in list(seen)[-5:]])
    with pytest.raises(ValueError, match="a fleet that differs in J_2 is not allowed"):
        env.scenario = Scenario(rigs=[Rig(J_2=0.01)])
    assert env.scenario.rigs == wider
    env.step(PUSH)


@pytest.mark.parametrize("arguments", [{}, {"scenario": "wide"}, {"rig": "field_2500m"}, {"drive": (0.3, 0.2, 0.5)}])
def test_the_scales_are_those_of_the_rig(arguments):
    env = gym.make_vec("DrillRig-v0", num_envs=64, privileged=True, **arguments)
    env.reset(seed=0)
    for _ in range(40):
        seen, *_ = env.step(env.action_space.sample())
    size = np.sqrt((seen["privileged"] ** 2).mean(axis=0))
    assert (size < 5.0).all()
    assert (size[:-1] > 0.1).all()  # but for the delay, which is that of all
    assert np.abs(seen["privileged"]).max() < LIMIT


def test_copies_and_states_go_on_alike():
    env = gym.make("DrillRigSurface-v0", privileged=True, scenario=Scenario(rigs=FLEET)).unwrapped
    env.reset(seed=0)
    env.step(PUSH)
    state = env.get_state()
    others = [copy.deepcopy(env), pickle.loads(pickle.dumps(env))]
    expected = env.step(PUSH)[0]
    env.reset(seed=8, options={"rig": Rig(J_1=0.05)})
    env.set_state(state)
    for other in (*others, env):
        seen = other.step(PUSH)[0]
        for part in ("policy", "privileged"):
            np.testing.assert_array_equal(seen[part], expected[part])
    vector = gym.make_vec("DrillRig-v0", num_envs=2, privileged=True)
    vector.reset(seed=0)
    again = pickle.loads(pickle.dumps(vector))
    first, second = (each.step(np.tile(PUSH, (2, 1)))[0]["privileged"] for each in (vector, again))
    np.testing.assert_array_equal(first, second)
    with pytest.raises(ValueError, match="the state's privileged = True is not allowed; allowed: False"):
        gym.make("DrillRigSurface-v0", scenario=Scenario(rigs=FLEET)).unwrapped.set_state(state)


def test_what_is_shown_may_be_written_into():
    env = gym.make_vec("DrillRig-v0", num_envs=2, privileged=True)
    seen, _ = env.reset(seed=0)
    kept = copy.deepcopy(seen)
    for part in seen.values():
        part[:] = 7.0
    again = env.core.seen
    for part, values in kept.items():
        np.testing.assert_array_equal(again[part], values)


@pytest.mark.parametrize("env_id", ["DrillRig-v0", "DrillRigSurface-v0"])
def test_both_checkers_have_nothing_to_say(env_id):
    with warnings.catch_warnings():
        warnings.simplefilter("error")
        env = gym.make(env_id, privileged=True, scenario=Scenario(rigs=FLEET))
        check_gymnasium(env.unwrapped, skip_render_check=True)
        check_sb3(env.unwrapped)


def test_stable_baselines_learns_from_both_parts():
    model = PPO("MultiInputPolicy", make_sb3(4, seed=0, privileged=True, duration=2.0), n_steps=16, batch_size=32)
    model.learn(256)
    assert model.policy.features_extractor.features_dim == 12 + 17


@pytest.mark.parametrize("name", ["jump_ease", "lqg", "ppo"])
def test_policies_find_their_channels(name):
    plain, both = gym.make("DrillRig-v0"), gym.make("DrillRig-v0", privileged=True)
    policy = load(name, env=both)
    (seen, info), (shown, _) = (env.reset(seed=0) for env in (plain, both))
    if hasattr(policy, "tell"):
        policy.tell(info)
    state = other = None
    for _ in range(5):
        action, state = policy.predict(seen, state)
        action_too, other = policy.predict(shown, other)
        np.testing.assert_array_equal(action, action_too)
        seen, shown = (env.step(action)[0] for env in (plain, both))
    many = gym.make_vec("DrillRig-v0", num_envs=3, privileged=True)
    shown, info = many.reset(seed=0)
    if hasattr(policy, "tell"):
        policy.tell(info)
    assert policy.predict(shown)[0].shape == (3, 1)
    with pytest.raises(ValueError, match=f"{name}: entries of an observation = seen is not allowed; .* 'policy'"):
        policy.predict({"seen": seen})


def test_a_rig_with_scales_of_its_own_shows_its_critic_the_same():
    """Time four times slower and torques twice as large: powers of two, so that the numbers are the same to the bit."""
    time, torque = 4.0, 2.0
    rig = Rig()
    slow = replace(
        rig,
        **{name: getattr(rig, name) * torque * time**2 for name in ("J_1", "J_2", "J_3")},
        **{name: getattr(rig, name) * torque * time for name in ("d_1", "d_2")},
        **{name: getattr(rig, name) * torque for name in ("k_1", "k_2", "K_T", "T_f")},
        C_m=rig.C_m * torque * time,
        K_E=rig.K_E * time,
        k_p=rig.k_p * time,
        L=rig.L * time,
        omega_s=rig.omega_s / time,
    )
    envs = [gym.make("DrillRig-v0", rig=each, privileged=True) for each in (rig, slow)]
    first, second = (env.reset(seed=4)[0]["privileged"] for env in envs)
    np.testing.assert_allclose(first[12:], second[12:], atol=1e-6)


TILTED = Scenario(tilt={"share": 0.3, "turns": (2, 5), "phase": 0.4})


def test_a_critic_sees_how_a_tilted_disc_lies():
    env = gym.make_vec("DrillRig-v0", num_envs=6, privileged=True, scenario=TILTED)
    env.reset(seed=1)
    for _ in range(20):
        seen = env.step(np.tile(PUSH, (6, 1)))[0]
    episodes, found = env.core.episodes, by_name(env, seen)
    angle = episodes["turns"] * episodes["state"][:, 7] + 0.4
    np.testing.assert_allclose(found["tilt_cosine"], np.cos(angle), atol=1e-6)
    np.testing.assert_allclose(found["tilt_sine"], np.sin(angle), atol=1e-6)
    assert set(found["tilt_turns"].tolist()) == {-1.0, 1.0}
    np.testing.assert_array_equal(found["tilt_turns"], (episodes["turns"] - 3.5) / 1.5)


def test_every_form_sees_the_same_disc():
    arguments = {"privileged": True, "scenario": TILTED}
    single = gym.make("DrillRig-v0", **arguments)
    vector = gym.make_vec("DrillRig-v0", num_envs=1, **arguments)
    first, (many, _) = single.reset(seed=4)[0], vector.reset(seed=4)
    for _ in range(3):
        np.testing.assert_array_equal(first["privileged"], many["privileged"][0])
        first, many = single.step(PUSH)[0], vector.step(PUSH[None])[0]


def test_a_disc_may_be_tilted_otherwise_but_not_where_none_is_seen():
    env = gym.make("DrillRig-v0", privileged=True, scenario=TILTED).unwrapped
    env.reset(seed=0)
    env.change(scenario=Scenario(tilt={"share": 0.3, "turns": 2, "phase": 1.4}))
    seen = by_name(env, env.step(PUSH)[0])
    episode = env.core.episodes[0]
    assert seen["tilt_cosine"] == pytest.approx(np.cos(episode["turns"] * episode["state"][7] + 1.4), abs=1e-6)
    state, plain = env.get_state(), gym.make("DrillRig-v0", privileged=True).unwrapped
    plain.reset(seed=0)
    for tilt in (lambda: plain.change(scenario=TILTED), lambda: plain.set_state(state)):
        with pytest.raises(ValueError, match="a tilted disc is not allowed: the privileged observation does not have"):
            tilt()
    assert plain.scenario.tilt is None
