import json
import subprocess
import sys

import numpy as np
import pytest
import torch

from agents.export import EXAMPLE
from agents.policy.agent import Agent
from agents.policy.run_folder import load_policy
from agents.training.settings import Training
from agents.training.train import train
from drillrig_env.deploy import export as command
from drillrig_env.deploy.export import TOLERANCE, export, largest_difference
from drillrig_env.deploy.policy_file import PolicyFile
from tests.agents import tiny

onnx = pytest.importorskip("onnx")
onnxruntime = pytest.importorskip("onnxruntime")

PPO = {**tiny.PPO, "learning_rate": 0.01}
SAC = tiny.SAC
ROUNDING = 5e-6  # of the slew limit: what PyTorch's single precision may move an action by


@pytest.fixture(scope="module", params=["ppo", "sac", "ppo with frames, surface", "ppo_lstm", "ppo_lstm, surface"])
def agent(request, tmp_path_factory):
    algorithm = request.param.partition(",")[0].partition(" ")[0]
    hyperparams = SAC if algorithm == "sac" else PPO
    if "frames" in request.param:
        hyperparams = {**hyperparams, "frame_stack": 3}
    if algorithm == "ppo_lstm":
        pytest.importorskip("sb3_contrib")
        layers = 2 if "surface" in request.param else 1
        hyperparams = {**hyperparams, "policy_kwargs": {"lstm_hidden_size": 6, "n_lstm_layers": layers}}
    training = Training(
        algorithm=algorithm,
        env_id="DrillRigSurface-v0" if "surface" in request.param else "DrillRig-v0",
        n_timesteps=256,
        hyperparams=hyperparams,
        env_kwargs={"duration": 5.0, "slew_limit": 1.5},
        eval_freq=-1,
        run_folder=tmp_path_factory.mktemp("runs") / "run",
        tensorboard=False,
        progress=False,
    )
    return load_policy(train(training))


def test_file_acts_as_the_agent(agent, tmp_path):
    export(agent, tmp_path / "policy.onnx")
    assert largest_difference(agent, tmp_path / "policy.onnx", episodes=10) < TOLERANCE
    assert largest_difference(agent, tmp_path / "policy.onnx", episodes=10, single=True) < ROUNDING
    about = onnxruntime.InferenceSession(tmp_path / "policy.onnx").get_modelmeta().custom_metadata_map
    assert [channel["name"] for channel in json.loads(about["channels"])] == list(agent.sensors.names)
    assert json.loads(about["slew_limit"]) == {"value": 1.5, "unit": "rad/s^2"}


def test_the_difference_counts_beside_the_slew_limit(agent, tmp_path):
    """A rig of other size moves its reference at rates hundreds of times as high, rounding errors and all."""
    fast = Agent(agent.model, {**agent.config, "env_kwargs": {**agent.config["env_kwargs"], "slew_limit": 900.0}})
    export(fast, tmp_path / "policy.onnx")
    assert largest_difference(fast, tmp_path / "policy.onnx", episodes=10) < TOLERANCE


def test_another_agent_would_be_noticed(agent, tmp_path):
    """The comparison can fail: it sees a network whose weights are a little off."""
    export(agent, tmp_path / "policy.onnx")
    weights = agent.model.policy.state_dict()
    name = next(name for name in weights if name.startswith(("action_net", "actor.mu")))
    original = weights[name].clone()
    weights[name] += 0.001
    agent.model.policy.load_state_dict(weights)
    assert largest_difference(agent, tmp_path / "policy.onnx", episodes=2) > TOLERANCE
    weights[name] = original
    agent.model.policy.load_state_dict(weights)


def test_rate_keeps_the_slew_limit(agent, tmp_path):
    export(agent, tmp_path / "policy.onnx")
    session = onnxruntime.InferenceSession(tmp_path / "policy.onnx")
    values = {
        item.name: np.full((2, item.shape[1]), 1e6, np.float32 if item.name == "frames" else np.float64)
        for item in session.get_inputs()
    }
    rate = session.run(["speed_reference_rate"], values)[0]
    assert rate.shape == (2, 1)
    assert np.all(np.abs(rate) <= 1.5)


def test_example_runs_with_onnxruntime_alone(agent, tmp_path):
    export(agent, tmp_path / "policy.onnx")
    done = subprocess.run([sys.executable, "-c", EXAMPLE], cwd=tmp_path, capture_output=True, text=True, check=False)
    assert done.returncode == 0, done.stderr
    assert done.stdout.startswith("speed reference: ")
    assert len([line for line in EXAMPLE.splitlines() if line]) <= 20


@pytest.mark.parametrize("agent", ["ppo_lstm"], indirect=True)
def test_a_network_with_another_memory_is_refused(agent, tmp_path):
    lstm = agent.model.policy.lstm_actor
    agent.model.policy.lstm_actor = torch.nn.GRU(lstm.input_size, lstm.hidden_size)
    try:
        with pytest.raises(ValueError, match="this network is not exported; allowed: PPO, SAC, and recurrent PPO with"):
            export(agent, tmp_path / "policy.onnx")
    finally:
        agent.model.policy.lstm_actor = lstm


@pytest.mark.parametrize(("difference", "refused"), [(9e-7, False), (1e-6, True), (0.1, True), (float("nan"), True)])
def test_a_file_that_acts_otherwise_than_its_agent_is_refused(difference, refused, tmp_path, monkeypatch, capsys):
    """What the command says of a file hangs on the largest difference alone: 1e-6 of the slew limit is too much."""
    path = tmp_path / "policy.onnx"
    monkeypatch.setattr(command, "policy_to_export", lambda name, sensors: None)
    monkeypatch.setattr(command, "export", lambda agent, out, name: out.write_bytes(b"x"))
    monkeypatch.setattr(command, "largest_difference", lambda agent, out, episodes: difference)
    assert command.main(["ppo", "--out", str(path)]) == refused
    told = capsys.readouterr()
    assert f"{difference:.1e} of the slew limit" in told.out
    assert ("not to be trusted" in told.err) == refused


def test_mistakes_are_explained_and_leave_no_file(tmp_path, monkeypatch, capsys):
    monkeypatch.chdir(tmp_path)
    for arguments, message in (
        (["ppo", "--episodes", "0"], "argument --episodes: '0' is not allowed; allowed: whole, >= 1"),
        (["pppo"], "policy 'pppo' is not known"),
    ):
        with pytest.raises(SystemExit) as end:
            command.main(arguments)
        assert end.value.code == 2
        assert message in capsys.readouterr().err
    assert not list(tmp_path.iterdir())


def test_an_exported_agent_takes_float32_and_float64(agent, tmp_path):
    export(agent, tmp_path / "policy.onnx")
    rng = np.random.default_rng(0)
    exported = PolicyFile(tmp_path / "policy.onnx")
    assert exported.inputs == tuple(agent.sensors.names)
    values = {name: rng.uniform(0.0, 1.0, 5).astype(np.float32) for name in exported.inputs}
    single, _ = exported.step(values)
    exported.reset()
    double, _ = exported.step({name: value.astype(np.float64)[:, None] for name, value in values.items()})
    np.testing.assert_array_equal(single, double)
    assert single.shape == (5,)
    with pytest.raises(ValueError, match=f"wants {exported.inputs[0]} too"):
        exported.step({name: values[name] for name in exported.inputs[1:]})
