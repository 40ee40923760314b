"""A filter under a network: its estimates as channels, while training, after a stop, and where the agent acts."""

from dataclasses import replace

import numpy as np
import pytest

from agents.policy.environment import batch_of, make_environment
from agents.policy.observer import ESTIMATED, estimates_of
from agents.policy.run_folder import load_policy
from agents.shipping.onnx_graph import actor_layers
from agents.training.fine_tuning import load_trainable
from agents.training.hyperparameters import hyperparameters
from agents.training.settings import Training
from agents.training.train import train
from baselines import LQG
from drillrig_env import make_sb3
from drillrig_env.env.sensors import Sensors
from drillrig_env.policy import context_of
from drillrig_env.scales import SLEW_LIMIT, Scales
from tests.agents import tiny

STEPS = 20
CALM = {"stick_slip": 0.0, "steady": 1.0, "speed_target": (4.5, 5.0), "normal_force": (5.0, 10.0), "load_step": 0.0}


def rigs(**changes):
    return make_environment("DrillRigSurface-v0", 3, 0, {"duration": 1.5, **changes}, observer="lqg")


def test_what_is_shown_are_the_filters_estimates_and_then_what_is_measured():
    env = rigs(duration=60.0)
    task = batch_of(env).core.task
    alone, state = LQG(**context_of(task)), None
    shown, starts = env.reset(), np.ones(3, dtype=bool)
    channels = Sensors.named(ESTIMATED).channels
    for _ in range(STEPS):
        measured = shown[:, len(ESTIMATED) :]
        assert np.array_equal(measured, batch_of(env).core.observations)
        _, state = alone.predict(measured, state, starts)
        target = task.sensors.value(measured, "speed_target")
        states, level = alone.estimate(state, target)
        for k, (channel, value) in enumerate(zip(channels, [*states.T, level], strict=True)):
            offset = target if channel.offset == "target" else channel.offset
            assert shown[:, k] == pytest.approx(((value - offset) / channel.scale).clip(-10.0, 10.0), abs=1e-6)
        shown, _, starts, _ = env.step(np.ones((3, 1), dtype=np.float32))


def test_the_filter_finds_the_bit_speed_that_the_surface_does_not_show():
    env = make_environment("DrillRigSurface-v0", 3, 0, {"scenario": CALM}, observer="lqg")
    shown = env.reset()
    for _ in range(300):
        shown, *_ = env.step(np.zeros((3, 1), dtype=np.float32))
    core = batch_of(env).core
    truth = (core.episodes["state"][:, 2] - core.episodes["speed_target"]) / 2.0
    assert shown[:, ESTIMATED.index("bit_speed")] == pytest.approx(truth, abs=0.1)


def test_an_episode_that_begins_is_looked_at_anew_and_one_that_ended_is_shown_to_its_end():
    env = rigs()
    env.reset()
    for _ in range(14):
        shown, *_ = env.step(np.zeros((3, 1), dtype=np.float32))
    before = env.memory.copy()
    shown, _, dones, infos = env.step(np.zeros((3, 1), dtype=np.float32))
    assert dones.all()
    afresh, _ = env.observer.look(shown[:, len(ESTIMATED) :], None, None)
    assert np.array_equal(shown, afresh)
    last = np.stack([info["terminal_observation"] for info in infos])
    assert last.shape == shown.shape
    assert np.array_equal(last, env.observer.look(last[:, len(ESTIMATED) :], before, None)[0])


@pytest.mark.parametrize(("algorithm", "frames"), [("ppo", 1), ("ppo", 3), ("ppo_asymmetric", 1)])
def test_an_agent_acts_as_its_model_does_behind_the_filter(tmp_path, algorithm, frames):
    own = tiny.ASYMMETRIC if algorithm == "ppo_asymmetric" else {**tiny.PPO, "frame_stack": frames}
    env_id = "DrillRigUnknown-v0" if algorithm == "ppo_asymmetric" else "DrillRigSurface-v0"
    values = {"eval_freq": -1, "tensorboard": False, "progress": False, "env_kwargs": {"duration": 3.0}}
    asked = Training(algorithm, env_id, n_timesteps=80, hyperparams={**own, "observer": "lqg"}, **values)
    agent = load_policy(train(replace(asked, run_folder=tmp_path / "run")))
    env = make_environment(env_id, 3, 0, {"duration": 3.0}, frames, observer="lqg")
    shown, starts = env.reset(), np.ones(3, dtype=bool)
    state = memory = None
    for _ in range(40):
        expected, memory = agent.model.predict(shown, memory, starts, deterministic=True)
        measured = batch_of(env).core.observations.copy()
        found, state = agent.predict(measured, state, starts)
        assert np.array_equal(found, expected)
        alone, _ = agent.predict(measured[0], None if state is None else tuple(part[:1] for part in state))
        assert alone.shape == (1,)
        shown, _, starts, _ = env.step(found)
    if algorithm == "ppo":
        again = load_trainable(str(tmp_path / "run"), make_sb3(3, seed=0, env_id=env_id))
        assert again.observation_space.shape == agent.model.observation_space.shape
    with pytest.raises(ValueError, match="looks through a filter of its own rig, and acts on no other"):
        agent.at_slew_limit(SLEW_LIMIT, Scales.of("field_2500m", None))
    with pytest.raises(ValueError, match="the filter `lqg` before the network is not exported"):
        actor_layers(agent)


def test_a_policy_that_estimates_nothing_is_refused():
    with pytest.raises(ValueError, match="observer: policy = z_torque is not allowed; allowed: lqg, or another"):
        make_environment("DrillRigSurface-v0", 1, 0, {}, observer="z_torque")
    with pytest.raises(ValueError, match="observer = 3"):
        hyperparameters("ppo", "DrillRigSurface-v0", {"observer": 3})


def test_an_environment_without_one_shows_no_estimates():
    assert estimates_of(make_environment("DrillRigSurface-v0", 1, 0, {}, 2)) is None
