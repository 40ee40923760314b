import json

import numpy as np
import pytest

from agents import ablations
from agents.ablations import ablate
from agents.policy.absolute_action import REACH, AbsoluteAction, AbsoluteAgent
from agents.policy.environment import batch_of, make_environment
from agents.training.settings import checked_config
from agents.variants import STATISTICS, VARIANTS
from tests.agents.conftest import TINY

BY_NAME = {variant.name: variant for variant in VARIANTS}


def config_of(name):
    return checked_config(BY_NAME[name].training(0, 1000))


def test_each_variant_changes_what_it_says_and_nothing_else():
    shipped = config_of("shipped")
    for name, keys in (
        ("squares", {"reward"}),
        ("large_rewards", {"reward"}),
        ("no_statistics", {"sensors", "noise", "delay"}),
        ("stiff_drive", {"drive"}),
        ("absolute_action", set()),
    ):
        config = config_of(name)
        assert config["hyperparameters"] == shipped["hyperparameters"]
        before, after = shipped["env_kwargs"], config["env_kwargs"]
        assert {key for key in {**before, **after} if before.get(key) != after.get(key)} == keys
    assert config_of("stiff_drive")["env_kwargs"]["drive"] is None
    small, large = (config["env_kwargs"]["reward"] for config in (shipped, config_of("large_rewards")))
    weights = ("variance", "tracking", "action")
    assert [large[name] for name in weights] == pytest.approx([10.0 * small[name] for name in weights])
    assert config_of("squares")["env_kwargs"]["reward"]["tracking_shape"] == "square"
    assert not set(config_of("no_statistics")["env_kwargs"]["sensors"]) & set(STATISTICS)
    assert config_of("surface_no_history")["hyperparameters"]["frame_stack"] == 1


def test_without_statistics_the_surface_is_as_noisy_and_late_as_before():
    kwargs = [config_of(name)["env_kwargs"] for name in ("surface", "surface_no_statistics")]
    whole, less = (batch_of(make_environment("DrillRigSurface-v0", 1, 0, one)).core for one in kwargs)
    assert whole.task.delays == less.task.delays
    kept = [name in less.sensors.names for name in whole.sensors.names]
    np.testing.assert_array_equal(whole._layout["noise"][kept], less._layout["noise"])


def test_absolute_action_is_reached_at_the_slew_limit():
    env = AbsoluteAction(make_environment("DrillRig-v0", 3, 0, {}))
    env.reset()
    core = batch_of(env).core
    before = core.episodes["speed_reference"].copy()
    wanted = core.episodes["speed_target"] + 0.25 * REACH
    env.step(np.full((3, 1), 0.25, np.float32))
    moved = np.clip(wanted - before, -0.2, 0.2)
    np.testing.assert_allclose(core.episodes["speed_reference"] - before, moved, atol=1e-6)
    for _ in range(40):
        env.step(np.full((3, 1), 0.25, np.float32))
    np.testing.assert_allclose(core.episodes["speed_reference"], wanted, atol=1e-6)


def test_agent_with_absolute_action_acts_as_in_training():
    config = config_of("absolute_action")

    class Fixed:
        """Stands for a model: an action that changes with the observation."""

        def predict(self, observation, state=None, episode_start=None, deterministic=True):
            return np.sin(3.0 * observation[:, 2:3]).astype(np.float32), None

    def environment():
        env = make_environment("DrillRig-v0", 4, 0, config["env_kwargs"])
        env.reset()
        return env

    behind, raw = AbsoluteAction(environment()), environment()
    agent = AbsoluteAgent(Fixed(), config)
    for _ in range(50):
        behind.step(Fixed().predict(batch_of(behind).core.observations)[0])
        actions, _ = agent.predict(batch_of(raw).core.observations)
        np.testing.assert_allclose(4.0 * agent.at_slew_limit(8.0).predict(batch_of(raw).core.observations)[0], actions)
        raw.step(actions)
    references = [batch_of(env).core.episodes["speed_reference"] for env in (behind, raw)]
    np.testing.assert_allclose(references[0], references[1], atol=1e-5)


def test_file_is_filled_gone_on_with_and_made_again_after_a_change(tmp_path, monkeypatch):
    output = tmp_path / "agents" / "ablations.json"
    variants = [BY_NAME["absolute_action"], BY_NAME["shipped"]]
    trained = []
    train = ablations._train
    monkeypatch.setattr(ablations, "_train", lambda *given: (trained.append(given[0].name), train(*given))[1])
    first = ablate(variants, 1, 128, 10, output, changes=TINY)
    assert list(first["variants"]) == ["shipped", "absolute_action"]
    ablate(variants, 2, 128, 10, output, changes=TINY)
    assert sorted(trained) == ["absolute_action"] * 2 + ["shipped"] * 2
    second = json.loads(output.read_text())
    assert second["provenance"]["versions"]["numpy"]
    assert second["variants"]["shipped"]["runs"]["0"] == first["variants"]["shipped"]["runs"]["0"]
    assert set(second["variants"]["shipped"]["runs"]["1"]["scores"]) == {
        "mitigated",
        "below",
        "above",
        "time_to_calm",
        "cost",
    }
    ablate(variants[1:], 1, 256, 10, output, changes=TINY)
    assert trained[4:] == ["shipped"]
    assert list(json.loads(output.read_text())["variants"]["shipped"]["runs"]) == ["0"]


def test_impossible_numbers_are_refused(tmp_path, capsys):
    with pytest.raises(SystemExit):
        ablations.main(["--seeds", "0", "--output", str(tmp_path / "file.json")])
    assert "--seeds: '0' is not allowed" in capsys.readouterr().err
    assert not (tmp_path / "file.json").exists()
