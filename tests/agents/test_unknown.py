"""Tries where nobody knows the rig: each changes one piece of the recipe, and all are scored on other rigs."""

import pytest

pytest.importorskip("sb3_contrib")

from agents.compared import evaluate
from agents.training.settings import checked_config
from agents.training.validation_rigs import of_validation
from agents.unknown import BESIDE, TRIES
from drillrig_env.env.scenario import Scenario
from drillrig_env.evaluation.suites import suite
from drillrig_env.fleet import Fleet
from drillrig_env.rig import Rig
from drillrig_env.seeds import EVALUATION_FLEETS, TRAINING_FLEETS, VALIDATION_FLEETS

CONFIGS = {one.name: checked_config(one.setting().training) for one in TRIES}
PIECES = {
    "firm": {"imitation"},
    "fitted": {"imitation"},
    "imitation": {"critic_iterations", "n_timesteps"},
    "alone": {"imitation", "critic_iterations", "policy_kwargs"},
    "through_estimates": {"estimates", "through_estimates", "critic_iterations", "n_timesteps"},
    "estimates": {"estimates"},
    "observer": {"observer"},
    "observer_of_fleet": {"observer"},
    "untold": {"critic_told"},
    "on_target": {"reward"},
    "together": {"reward", "imitation", "estimates"},
    "tuned": {"imitation", "learning_rate", "gamma", "gae_lambda", "n_epochs", "batch_size", "target_kl"},
    "frames_8": {"frame_stack"},
    "frames_20": set(),
    "frames_40": {"frame_stack"},
    "nominal": {"rigs", "spread"},
    "curriculum": {"curriculum"},
}


def flat(config):
    hyperparameters = {name: value for name, value in config["hyperparameters"].items() if name != "env_kwargs"}
    environment = {**config["env_kwargs"], **config["env_kwargs"]["scenario"]}
    del environment["scenario"]
    return hyperparameters | environment


@pytest.mark.parametrize("name", PIECES)
def test_a_try_changes_its_piece_and_nothing_else(name):
    recipe = CONFIGS["frames_20" if name.startswith("frames") else "memory"]
    one, other = flat(CONFIGS[name]), flat(recipe)
    assert {key for key in {**one, **other} if one.get(key) != other.get(key)} == PIECES[name]


def test_every_try_learns_from_a_training_fleet_and_the_same_draws():
    assert set(CONFIGS) == {*PIECES, "memory"}
    for name, config in CONFIGS.items():
        scenario = Scenario.named(config["env_kwargs"]["scenario"])
        assert (scenario.load_step, scenario.stick_slip) == (0.3, 0.85)
        if name == "nominal":
            assert (scenario.rigs, scenario.spread) == (None, 0.2)
        else:
            assert scenario.rigs.seed in TRAINING_FLEETS
            assert scenario.spread == 0.0


def test_settings_are_chosen_by_other_rigs_than_those_learnt_and_judged_on():
    for seed in (0, EVALUATION_FLEETS.start):
        spread = Scenario(rigs=Fleet.around(spread={"string": 2.0}, count=400, seed=seed), spread=0.0)
        chosen = of_validation(spread)
        assert chosen.rigs.seed in VALIDATION_FLEETS
        assert chosen.rigs.count == 256
        assert chosen.rigs.spread == spread.rigs.spread
        assert chosen.spread == 0.0
    for scenario in (Scenario(), Scenario(rigs=Fleet(rigs=(Rig(), Rig(J_1=0.06))))):
        assert of_validation(scenario) == scenario


def test_policies_beside_are_made_for_the_fleet_that_they_are_scored_on(monkeypatch):
    found = {name: evaluate(name, "surface", 2, 1, ("unknown",))["unknown"]["mitigated"] for name in BESIDE}
    told = found["baselines/told.py:LQROfRig"]
    assert told == max(found.values())
    assert told >= 0.9 > found["constant"]
    assert suite("unknown", 2).scenario.rigs.seed in EVALUATION_FLEETS
