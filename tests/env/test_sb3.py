"""The form for Stable-Baselines3 beyond its steps: what is pinned, what is reported, frames."""

import gymnasium as gym
import numpy as np
import pytest

import drillrig_env
from drillrig_env.env.sensors import SENSORS

HOLD = np.zeros((2, 1), np.float32)


def test_sb3_reports_the_end_of_an_episode():
    env = drillrig_env.make_sb3(2, seed=0, duration=0.5)
    env.reset()
    total = np.zeros(2)
    for _ in range(5):
        _, rewards, dones, infos = env.step(HOLD)
        total += rewards
    assert dones.all()
    for i, info in enumerate(infos):
        assert info["TimeLimit.truncated"]
        assert info["terminal_observation"].shape == (len(SENSORS["state"].channels),)
        assert info["episode"]["l"] == 5
        assert info["episode"]["r"] == pytest.approx(total[i], rel=1e-5)


def test_what_is_pinned_holds_for_every_episode_until_it_is_pinned_anew():
    env = drillrig_env.make_sb3(2, seed=0, duration=0.2)
    forces = []

    def play():
        for _ in range(4):
            env.step(HOLD)
        forces.append(env.core.episodes["normal_force"].tolist())

    env.set_options({"normal_force": 13.0, "load_steps": []})
    env.reset()
    play()
    env.set_options({"normal_force": [11.0, 12.0], "load_steps": []})
    play()
    env.reset()
    play()
    env.set_options()
    play()
    assert forces[:3] == [[13.0, 13.0], [11.0, 12.0], [11.0, 12.0]]
    assert len({*forces[3], 11.0, 12.0, 13.0}) == 5


@pytest.mark.parametrize("pins", [None, {}, [{}, {}, {}]], ids=["as made", "none for all", "none for each"])
def test_rigs_of_which_nothing_is_pinned_begin_together(pins, monkeypatch):
    env = drillrig_env.make_sb3(3, seed=0, duration=0.2)
    if pins is not None:
        env.set_options(pins)
    begun, reset = [], env.core.reset
    monkeypatch.setattr(env.core, "reset", lambda rigs, *given: (begun.append(len(rigs)), reset(rigs, *given)))
    env.reset()
    for _ in range(2):
        env.step(np.zeros((3, 1)))
    assert begun == [3, 3]


def test_a_list_pins_each_rig_with_its_own():
    env = drillrig_env.make_sb3(2, seed=0, duration=0.2)
    env.set_options([{"normal_force": 11.0, "load_steps": [(0.1, 3.0)]}, {"load_steps": []}])
    env.reset()
    drawn = env.core.episodes["normal_force"][1]
    assert env.core.episodes["normal_force"][0] == 11.0
    for _ in range(2):
        env.step(HOLD)
    env.step(HOLD)
    assert env.core.episodes["normal_force"][0] == 11.0
    assert env.core.episodes["normal_force"][1] != drawn


def test_pins_of_some_rigs_are_drawn_as_the_single_form_draws_them():
    env = drillrig_env.make_sb3(2, seed=7)
    env.set_options([{"normal_force": 11.0}, {}])
    seen = env.reset()
    np.testing.assert_array_equal(seen[0], gym.make("DrillRig-v0").reset(seed=7, options={"normal_force": 11.0})[0])
    np.testing.assert_array_equal(seen[1], gym.make("DrillRig-v0").reset(seed=8)[0])


def test_frames_of_all_rigs():
    pytest.importorskip("pygame", reason="rendering needs the extra `render` (pygame-ce)")
    env, alone = (
        drillrig_env.make_sb3(2, seed=4, render_mode="rgb_array"),
        gym.make("DrillRig-v0", render_mode="rgb_array"),
    )
    env.reset()
    alone.reset(seed=5)
    for _ in range(3):
        env.step(HOLD)
        alone.step(HOLD[1])
    frames = env.get_images()
    np.testing.assert_array_equal(frames[1], alone.render())
    assert env.render(mode="rgb_array").shape[2] == 3
    assert list(drillrig_env.make_sb3(2).get_images()) == [None, None]


def test_shorter_episodes():
    env = drillrig_env.make_sb3(2, seed=0, max_episode_steps=3)
    env.reset()
    for k in range(6):
        _, _, dones, infos = env.step(HOLD)
        assert dones.all() == (k in (2, 5))
    assert infos[0]["episode"]["l"] == 3
