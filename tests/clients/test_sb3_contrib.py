"""sb3-contrib's algorithms on the `VecEnv` and on the plain environment."""

import copy
from functools import partial

import gymnasium as gym
import numpy as np
import pytest

import drillrig_env

pytestmark = pytest.mark.clients
contrib = pytest.importorskip("sb3_contrib", reason="needs the extra clients")

SMALL = {"policy_kwargs": {"net_arch": [16]}, "seed": 0}
OFF_POLICY = {**SMALL, "learning_starts": 8, "batch_size": 8, "buffer_size": 200}
ALGORITHMS = {
    "RecurrentPPO": ("MlpLstmPolicy", {"policy_kwargs": {"net_arch": [16], "lstm_hidden_size": 8}, "n_steps": 16}),
    "TQC": ("MlpPolicy", OFF_POLICY),
    "CrossQ": ("MlpPolicy", OFF_POLICY),
    "TRPO": ("MlpPolicy", {**SMALL, "n_steps": 16, "batch_size": 16}),
    "ARS": ("LinearPolicy", {"n_delta": 2, "seed": 0}),
}
FORMS = {"VecEnv": partial(drillrig_env.make_sb3, 4, seed=0), "plain": partial(gym.make, "DrillRig-v0")}


@pytest.mark.parametrize("form", FORMS)
@pytest.mark.parametrize("name", ALGORITHMS)
def test_a_few_steps(name, form):
    policy, settings = ALGORITHMS[name]
    env = FORMS[form](duration=1.0)
    model = getattr(contrib, name)(policy, env, **copy.deepcopy(settings))  # it writes into them
    model.learn(64)
    observation = model.get_env().reset()
    action, _ = model.predict(observation)
    assert np.isfinite(action).all()
