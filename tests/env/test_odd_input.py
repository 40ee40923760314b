"""What is asked wrongly gets one sentence: what is wrong, and what is allowed."""

import gymnasium as gym
import numpy as np
import pytest
from gymnasium.error import ResetNeeded

import drillrig_env

FORMS = {
    "single": lambda **kwargs: gym.make("DrillRig-v0", **kwargs).unwrapped,
    "vector": lambda **kwargs: gym.make_vec("DrillRig-v0", num_envs=2, **kwargs),
    "sb3": lambda **kwargs: drillrig_env.make_sb3(2, seed=0, **kwargs),
}


@pytest.fixture(params=FORMS)
def make(request):
    return FORMS[request.param]


def begin(env, options):
    """Begin an episode with options, as each form takes them."""
    if hasattr(env, "set_options"):
        env.set_options(options)
        env.reset()
    else:
        env.reset(seed=0, options=options)


def test_unknown_keyword_argument_is_a_type_error_as_in_python(make):
    with pytest.raises(TypeError, match=r"unexpected keyword argument 'sensor'.*; did you mean sensors\?"):
        make(sensor="state")
    with pytest.raises(ValueError, match=r"unknown field 'sensor' of the task; did you mean sensors\?"):
        make(task={"sensor": "state"})


@pytest.mark.parametrize(
    ("arguments", "sentence"),
    [
        ({"rig": ""}, "rig: '' is no file that can be read"),
        ({"reward": "."}, "reward: '.' is no file that can be read"),
        ({"sensors": [["bit_speed"]]}, "unknown channel ..bit_speed"),
        ({"sensors": np.array(1.0)}, "sensors = array.* allowed: state, encoders, surface, or names"),
        ({"noise": [1.0, 2.0]}, r"noise = \[1.0, 2.0\] is not allowed"),
        ({"noise": np.array([1.0])}, "noise = array.* is not allowed"),
        ({"noise": {"top_speed": [1.0]}}, r"top_speed = \[1.0\] rad/s is not allowed; allowed: >= 0"),
        ({"drive": np.array(1.0)}, "drive = 1.0 is not allowed; allowed: a Drive"),
    ],
)
def test_arguments(make, arguments, sentence):
    with pytest.raises(ValueError, match=sentence):
        make(**arguments)


@pytest.mark.parametrize("mode", [None, 2, "same_step", ["SameStep"]])
def test_autoreset_mode(mode):
    with pytest.raises(ValueError, match=r"autoreset_mode = .* allowed: NextStep, SameStep, Disabled"):
        gym.make_vec("DrillRig-v0", num_envs=2, autoreset_mode=mode)


@pytest.mark.parametrize("options", ["rest", 3, ("start", "rest")])
def test_options_that_are_no_dictionary(make, options):
    with pytest.raises(ValueError, match=r"options = .* a dictionary, with the keys normal_force"):
        begin(make(), options)


@pytest.mark.parametrize("steps", [[("1", "20")], [(True, True)], [1.0, 20.0], [(1.0, 20.0, 3.0)], 5, "ab"])
def test_load_steps_that_are_no_pairs_of_numbers(make, steps):
    with pytest.raises(ValueError, match=r"load_steps = .* a list of \(time in s, N_1 in N\)"):
        begin(make(), {"load_steps": steps})


@pytest.mark.parametrize("options", [[], [{}], [{}, {}, {}]])
def test_options_for_another_number_of_rigs(options):
    with pytest.raises(ValueError, match=r"number of dictionaries = \d is not allowed; allowed: one for all, or 2"):
        drillrig_env.make_sb3(2).set_options(options)


@pytest.mark.parametrize("name", ["core", "num_envs", "render_mode", "observation_space"])
def test_attributes_that_are_no_part_of_the_task(name):
    for env in (FORMS["vector"](), FORMS["sb3"]()):
        with pytest.raises(
            AttributeError, match=f"{name} cannot be changed; scenario, reward, slew_limit, noise and delay"
        ):
            env.set_attr(name, 3)


def test_step_before_the_first_reset(make):
    env = make()
    shape = (1,) if isinstance(env, gym.Env) else (2, 1)
    with pytest.raises(ResetNeeded, match="reset"):
        env.step(np.zeros(shape, np.float32))


@pytest.mark.parametrize("sensors", ["state", ("bit_speed",)])
@pytest.mark.parametrize("observation", [None, "a", 1.0, np.zeros(2), np.zeros((3, 2))])
def test_observations_of_other_sensors(sensors, observation):
    with pytest.raises(ValueError, match=r"observation = .* allowed"):
        FORMS["single"](sensors=sensors).sensors.values(observation)


def test_a_scenario_may_say_what_stands_for_its_default(make):
    assert make(scenario={"load_force": None}).scenario.load_force is None
