import pytest
from torch import nn

from agents.policy.environment import scaled_arguments
from agents.training.hyperparameters import HYPERPARAMETER_FILES, algorithm_arguments, hyperparameters, read_pairs
from agents.training.schedules import policy_kwargs, schedule
from agents.training.settings import Training, checked_config
from drillrig_env.scales import Scales
from tests.rigs import FIELD, scaled

OF_UNKNOWN = HYPERPARAMETER_FILES / "unknown" / "ppo.yml"


@pytest.mark.parametrize("env_id", ["DrillRig-v0", "DrillRigSurface-v0"])
@pytest.mark.parametrize("algorithm", ["ppo", "sac", "ppo_lstm"])
def test_files_are_complete_and_changes_go_in(algorithm, env_id):
    if algorithm == "ppo_lstm":
        pytest.importorskip("sb3_contrib")
    chosen = hyperparameters(algorithm, env_id, {"gamma": 0.9, "n_timesteps": 1e3})
    assert chosen["gamma"] == 0.9
    assert chosen["n_timesteps"] == 1000
    assert isinstance(chosen["n_envs"], int)
    assert callable(algorithm_arguments(chosen)["learning_rate"])


@pytest.mark.parametrize("folder", ["alone", "soft_drive"])
@pytest.mark.parametrize("algorithm", ["ppo", "sac"])
def test_files_without_imitation_hold_only_keys_that_rl_zoo3_knows(folder, algorithm):
    chosen = hyperparameters(algorithm, "DrillRig-v0", file=HYPERPARAMETER_FILES / folder / f"{algorithm}.yml")
    assert not {"imitation", "critic_iterations", "staggered", "anchor"} & set(chosen)


def test_pairs_of_a_command_line():
    assert read_pairs(["gamma:0.98", "scenario:{spread: 0.1}"]) == {"gamma": 0.98, "scenario": {"spread": 0.1}}
    for text in ("gamma", "gamma:"):
        with pytest.raises(ValueError, match=f"'{text}' is not allowed; allowed: NAME:VALUE"):
            read_pairs([text])


def test_schedules():
    assert schedule("lin_4e-4")(0.25) == pytest.approx(1e-4)
    assert schedule("0.1") == 0.1
    with pytest.raises(ValueError, match="allowed: a number > 0, or lin_"):
        schedule("cos_3")


def test_network_as_text():
    read = policy_kwargs("dict(net_arch=dict(pi=[64], vf=[32, 32]), activation_fn=nn.ReLU, log_std_init=-1)")
    assert read == {"net_arch": {"pi": [64], "vf": [32, 32]}, "activation_fn": nn.ReLU, "log_std_init": -1}
    for text in ("dict(net_arch=__import__('os'))", "print()", "dict(activation_fn=nn.Rel)", "[64", "dict([64])"):
        with pytest.raises(ValueError, match="policy_kwargs = "):
            policy_kwargs(text)


@pytest.mark.parametrize("changes", [{"imitation.rounds": 2}, {"imitation": {"rounds": 2}}], ids=["dot", "mapping"])
def test_a_part_of_what_is_imitated_is_changed_alone(changes):
    own, changed = (hyperparameters("ppo_asymmetric", "DrillRigUnknown-v0", one) for one in ({}, changes))
    assert own["imitation"]["rounds"] != 2
    assert changed == {**own, "imitation": {**own["imitation"], "rounds": 2}}
    assert hyperparameters("ppo_asymmetric", "DrillRigUnknown-v0", {"imitation": None})["imitation"] is None
    with pytest.raises(ValueError, match="did you mean rounds"):
        hyperparameters("ppo", "DrillRig-v0", {"imitation.round": 2})
    with pytest.raises(ValueError, match=r"imitation\.rounds: nothing is imitated here; allowed: imitation as a whole"):
        hyperparameters("ppo", "DrillRig-v0", {"imitation": None, "imitation.rounds": 2})


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


@pytest.mark.parametrize(
    ("algorithm", "changes", "message"),
    [
        ("ppo", {"policy_kwargs": 7}, "policy_kwargs = 7 is not allowed"),
        ("ppo", {"policy_kwargs": None}, "policy_kwargs = None is not allowed"),
        ("ppo", {"ent_coef": "auto"}, "ent_coef = 'auto' is not a number; allowed: >= 0"),
        ("ppo", {"learning_rate": 1e300}, "learning_rate = 1e[+]300 is not allowed; allowed: > 0 and <= 1"),
        ("ppo", {"learning_rate": "lin_1e300"}, "allowed: > 0 and <= 1, or lin_<number>, which falls to zero"),
        ("ppo", {"learning_rate": "lin_x"}, "learning_rate = lin_x is not allowed"),
        ("ppo_asymmetric", {"imitation.learning_rate": 2.0}, "learning_rate = 2.0 is not allowed"),
        ("ppo_lstm", {"policy_kwargs": {"lstm_kwargs": {"bidirectional": True}}}, r"allowed: dict\(dropout=SHARE\)"),
        ("ppo_lstm", {"policy_kwargs": {"lstm_kwargs": {"dropout": 2.0}}}, "dropout = 2.0 is not allowed"),
        ("ppo_lstm", {"policy_kwargs": {"lstm_hidden_size": -8}}, "lstm_hidden_size = -8 is not allowed"),
    ],
)
def test_settings_that_only_learning_would_stumble_over_are_refused(algorithm, changes, message):
    env_id = "DrillRigUnknown-v0" if algorithm == "ppo_asymmetric" else "DrillRig-v0"
    with pytest.raises(ValueError, match=message):
        hyperparameters(algorithm, env_id, changes)


def test_numbers_as_people_write_them():
    found = read_pairs(["a:1e-3", "b:{c: 3e2, d: -1E+9}", "e:1.5e4", "f:12", "g:1.0e-3", "h:0x10", "i:e5"])
    numbers = {"a": 1e-3, "b": {"c": 3e2, "d": -1e9}, "e": 1.5e4, "f": 12, "g": 1e-3, "h": 16}
    assert found == {**numbers, "i": "e5"}
    assert type(found["f"]) is int


@pytest.mark.parametrize("seed", [2_000_000, 3_000_000_000])
def test_fleets_that_are_judged_on_are_not_trained_on(seed):
    ours, theirs = ({"rigs": {"spread": {"string": 2.0}, "count": 4, "seed": one}} for one in (0, seed))
    for changes in (
        {"env_kwargs": {"scenario": theirs}},
        {"env_kwargs": {"scenario": ours}, "hyperparams": {"curriculum": {"scenarios": [theirs], "share": 0.5}}},
    ):
        training = Training("ppo", "DrillRigUnknown-v0", conf_file=OF_UNKNOWN, **changes)
        with pytest.raises(ValueError, match=rf"seed of the fleet = {seed} is not allowed; allowed: 0 to 999999"):
            checked_config(training)


@pytest.mark.parametrize("value", ["much", -1.0, float("nan")])
def test_a_largest_reference_that_is_no_speed_is_named(value):
    with pytest.raises(ValueError, match=r"largest_reference = .* is not a.*; allowed: > 0"):
        checked_config(Training("ppo", env_kwargs={"largest_reference": value}))


def test_a_recipe_goes_with_the_rig_that_is_trained_on():
    """Files of hyperparameters have the chapter rig's numbers; those of the command line are taken as they are."""
    rig = scaled(time=0.5, torque=4.0)
    plain = checked_config(Training("ppo"))["env_kwargs"]
    own = checked_config(Training("ppo", env_kwargs={"rig": rig}))["env_kwargs"]
    low, high = plain["scenario"]["normal_force"]
    assert own["scenario"]["normal_force"] == [low, high]  # at four times the radius
    own = checked_config(Training("ppo", env_kwargs={"rig": FIELD, "slew_limit": 7.0}))["env_kwargs"]
    force = Scales.of(FIELD).force
    assert own["scenario"]["normal_force"] == [low * force, high * force]
    assert own["scenario"]["spread"] == plain["scenario"]["spread"]
    assert own["slew_limit"] == 7.0
    found = scaled_arguments(
        {"drive": [0.4, 0.1], "slew_limit": 1.0, "reward": {"time_constant": 2.0}, "duration": 30.0}, Scales.of(rig)
    )
    assert found["drive"] == {"k_p": 0.2, "k_i": 0.1, "back_emf_share": 0.0}
    assert (found["slew_limit"], found["reward"], found["duration"]) == (4.0, {"time_constant": 1.0}, 15.0)
