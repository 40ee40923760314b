import gymnasium
import pytest
import torch
from stable_baselines3 import PPO, SAC

import drillrig_env
from agents.training.hyperparameters import hyperparameters
from agents.training.settings import checked_config
from agents.variants import COMPARISONS

CONFIGS = {name: {one.name: checked_config(one.training) for one in make()} for name, make in COMPARISONS.items()}
ABLATIONS = CONFIGS["ablations"]


def flat(config, within=""):
    """The entries of a config that fix a training, by the path to each; the scenario's and the imitation's apart."""
    found = {}
    for key, value in config.items():
        if key in ("scenario", "imitation") and value:
            found |= flat(value, f"{key}.")
        else:
            found[within + key] = value
    return found


def changed(name):
    """What a variant changes: the paths of its entries that the recipe has otherwise."""
    both = [
        flat(config["env_kwargs"])
        | flat({key: value for key, value in config["hyperparameters"].items() if key != "env_kwargs"})
        for config in (ABLATIONS["recipe"], ABLATIONS[name])
    ]
    return {path for path in {**both[0], **both[1]} if both[0].get(path) != both[1].get(path)}


def test_one_variant_is_the_recipe_of_ppo_but_for_its_length():
    config, recipe = ABLATIONS["shipped_draws"], hyperparameters("ppo", "DrillRig-v0")
    assert config["env_kwargs"] == recipe["env_kwargs"]
    apart = {"n_timesteps": None, "env_kwargs": None}
    assert {**config["hyperparameters"], **apart} == {**recipe, **apart}


@pytest.mark.parametrize(
    ("names", "paths"),
    [
        (("sum",), {"reward"}),
        (("no_warm_up",), {"critic_iterations"}),
        (("candidates_1", "candidates_3"), {"scenario.candidates"}),
        (("frames_1", "frames_4"), {"frame_stack"}),
        (("load_0", "load_30"), {"scenario.load_step"}),
        (("default_draws",), {"scenario.normal_force", "scenario.spread"}),
        (("shipped_draws",), {"scenario.normal_force", "scenario.spread", "scenario.candidates"}),
        (("anchor",), {"anchor"}),
        (("gamma_98", "gamma_99"), {"gamma"}),
        (("narrow", "wide_network"), {"policy_kwargs"}),
        (("less_exploration",), {"imitation.log_std"}),
    ],
)
def test_a_variant_changes_its_piece_and_nothing_else(names, paths):
    assert all(changed(name) == paths for name in names)


def test_who_does_not_imitate_has_a_fresh_actor_that_explores_more():
    chosen = ABLATIONS["alone"]["hyperparameters"]
    assert chosen["imitation"] is None
    assert chosen["critic_iterations"] == 0
    assert "log_std_init=-0.5" in chosen["policy_kwargs"]
    assert changed("alone_sum") == changed("alone") | {"reward"}


def test_all_are_on_the_rigs_own_drive():
    assert not any(config["env_kwargs"].get("drive") for group in CONFIGS.values() for config in group.values())


def test_a_newcomer_sets_nothing():
    for name, config in CONFIGS["newcomer"].items():
        assert set(config["hyperparameters"]) == {"n_envs", "n_timesteps", "policy"}
        assert config["env_kwargs"] == ({"reward": "phases"} if "phases" in name else {})


@pytest.mark.slow
@pytest.mark.parametrize(("algorithm", "steps"), [(PPO, 2048), (SAC, 110)])
def test_one_rig_for_training_is_what_gymnasium_makes(algorithm, steps):
    """So that a newcomer's training on `gymnasium.make` can go on from checkpoints like any other."""
    made, ours = (
        algorithm("MlpPolicy", env, seed=0, device="cpu").learn(steps).policy.state_dict()
        for env in (gymnasium.make("DrillRig-v0"), drillrig_env.make_sb3(1))
    )
    assert all(torch.equal(made[name], ours[name]) for name in made)
