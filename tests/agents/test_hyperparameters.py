import pytest

from agents.hyperparameters import algorithm_arguments, hyperparameters, schedule


@pytest.mark.parametrize("algorithm", ["ppo", "sac"])
def test_files_are_complete_and_changes_go_in(algorithm):
    chosen = hyperparameters(algorithm, "DrillRig-v0", {"gamma": 0.9, "n_timesteps": 1e3})
    assert chosen["gamma"] == 0.9
    assert chosen["n_timesteps"] == 1000
    assert isinstance(chosen["n_envs"], int)
    assert callable(algorithm_arguments(chosen)["learning_rate"])


def test_schedules():
    assert schedule("lin_4e-4")(0.25) == pytest.approx(1e-4)
    assert schedule("0.1") == 0.1
    with pytest.raises(ValueError, match="allowed: a number, or lin_"):
        schedule("cos_3")


@pytest.mark.parametrize(
    ("arguments", "message"),
    [
        (("ppo", "DrillRig-v0", {"learning_rat": 1}), "did you mean learning_rate"),
        (("ppo", "DrillRig-v1", {}), "did you mean DrillRig-v0"),
        (("pppo", "DrillRig-v0", {}), "did you mean ppo"),
        (("sac", "DrillRig-v0", {"n_envs": 0}), "n_envs = 0"),
    ],
)
def test_unknown_names_are_refused(arguments, message):
    with pytest.raises(ValueError, match=message):
        hyperparameters(*arguments)
