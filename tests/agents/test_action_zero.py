import json

import numpy as np
import pytest

from agents.endurance import endurance
from agents.pictures.learning import action_zero
from agents.policy.action_zero import ActionZero
from agents.policy.run_folder import SEEDS, TRAINED, read_seeds, shipped
from agents.shipping.action_zero import add_action_zero
from agents.shipping.card import card
from baselines import Constant, SoftTorque
from drillrig_env.evaluation.runner import run
from drillrig_env.evaluation.scores import score
from drillrig_env.evaluation.suites import suite

SOFT = SoftTorque().drive


@pytest.mark.parametrize(("drive", "same"), [(None, Constant()), (SOFT, SoftTorque())], ids=["own", "soft"])
def test_it_is_what_the_drive_does_alone(drive, same):
    policy = ActionZero({"sensors": "surface", "drive": drive and drive.as_dict()})
    rigs = suite("load", 30)
    one, other = (score(run(each, rigs)) for each in (policy, same))
    np.testing.assert_array_equal(one["mitigated"], other["mitigated"])
    np.testing.assert_allclose(one["cost"], other["cost"], atol=1e-9)
    assert ActionZero({}).predict(np.zeros(7, np.float32))[0].tolist() == [0.0]


def test_its_reference_follows_a_target_that_steps():
    rigs = suite("drift", 30)
    one, other = (score(run(each, rigs)) for each in (ActionZero({"sensors": "surface"}), Constant()))
    np.testing.assert_array_equal(one["mitigated"], other["mitigated"])
    assert 0.2 < one["mitigated"].mean() < 0.8


def test_how_long_a_rig_that_drifts_is_held_goes_by_its_own_verdict():
    held = endurance(ActionZero({"sensors": "surface"}), 20, (60.0,), suite_name="drift")
    assert held["60"] > 0.2


@pytest.mark.slow
def test_a_shipped_agent_has_it_on_its_own_rigs(trained):
    about = read_seeds(trained / "ppo")
    suites = about["action_zero"]["suites"]
    assert {name: list(tables) for name, tables in suites.items()} == {
        "default": ["main", "hardness", "others"],
        "load": ["main"],
    }
    alone = score(run(Constant(), suite("load", about["rigs"]["load"])))["mitigated"].mean()
    assert suites["load"]["main"]["mitigated"]["value"] == pytest.approx(alone)
    assert about["action_zero"]["endurance"] == endurance(ActionZero({}), 12)


def test_every_table_of_scores_in_the_card_has_its_row(trained):
    text = card("ppo", trained)
    assert "Action 0 on the same drive and rigs" in text
    assert text.count("| action 0, same drive |") == 4  # by hardness, other scores, every seed, endurance


def test_it_is_put_beside_what_is_there(trained, tmp_path):
    about = read_seeds(trained / "ppo")
    before = {name: value for name, value in about.items() if name != "action_zero"}
    for file in (trained / "ppo").iterdir():
        (tmp_path / file.name).write_bytes(file.read_bytes())
    (tmp_path / SEEDS).write_text(json.dumps(before))
    add_action_zero(tmp_path)
    assert read_seeds(tmp_path) == about
    with pytest.raises(ValueError, match="is not a shipped agent"):
        add_action_zero(tmp_path / "none")


def test_of_learning_curves_it_is_on_the_drive_that_was_trained_on():
    config = {"env_id": "DrillRig-v0", "env_kwargs": {}, "eval_episodes": 50}
    soft = {**config, "env_kwargs": {"drive": SOFT.as_dict(), "sensors": "surface"}}
    assert action_zero(config) < 0.5 < 0.9 < action_zero(soft)


@pytest.mark.parametrize("name", [name for name in shipped() if read_seeds(TRAINED / name)])
def test_every_agent_in_the_package_has_it(name):
    assert read_seeds(TRAINED / name)["action_zero"]["suites"].keys() == read_seeds(TRAINED / name)["rigs"].keys()
