"""An imitation that was stopped anywhere goes on, and ends bit for bit as without the stop."""

import errno
import io
import signal

import numpy as np
import pytest
import torch
from stable_baselines3 import PPO, SAC

from agents.policy.environment import make_environment
from agents.policy.run_folder import IMITATED, MODEL, load_policy
from agents.training import imitated, imitation, train
from agents.training.imitation import Imitation, imitate
from agents.training.settings import Training
from drillrig_env.command_line import Failed
from tests.agents import tiny

ROUNDS, STEPS, RIGS, UPDATES, LAST = 3, 40, 6, 6, 12
TELLS = ROUNDS * (STEPS + UPDATES) + LAST
HOW = {"rounds": ROUNDS, "updates": UPDATES, "last_updates": LAST, "batch": 60, "learning_rate": 3e-3}
NETWORK = tiny.ASYMMETRIC["policy_kwargs"]
STOPS = {
    "at once": [0],
    "while it plays": [STEPS + UPDATES + 3],
    "while it fits": [STEPS + 4],
    "in the last fit": [TELLS - 5],
    "in one and in the last": [STEPS + UPDATES + STEPS + 4, 3 * STEPS + 2 + UPDATES + 3],
    "where it goes on": [STEPS + UPDATES + STEPS + 4, 7, 5],
    "at the end": [TELLS - 1],
}


@pytest.fixture(autouse=True)
def each_update_is_remembered(monkeypatch):
    monkeypatch.setattr(imitated, "_SECONDS", 0.0)


def plain(kind):
    def imitates(how, told, file):
        env = make_environment("DrillRig-v0", RIGS, 0, {"duration": 4.0, "threads": 1}, 2)
        few = {"n_steps": 8, "batch_size": 24} if kind is PPO else {"buffer_size": 100}
        model = kind("MlpPolicy", env, device="cpu", seed=0, policy_kwargs={"net_arch": [8]}, **few)
        imitate(model, env, Imitation("z_torque", **how), 0, told, file)
        return model, env

    return imitates


def recurrent(**changes):
    def imitates(how, told, file):
        pytest.importorskip("sb3_contrib")
        from agents.recurrent.asymmetric import AsymmetricPPO
        from agents.recurrent.imitation import imitate_episodes

        env = make_environment("DrillRigUnknown-v0", RIGS, 0, tiny.SHORT, told=True)
        few = {"n_steps": 10, "batch_size": 30, "policy_kwargs": NETWORK}
        model = AsymmetricPPO("MlpLstmPolicy", env, device="cpu", seed=0, **{**few, **changes})
        imitate_episodes(model, env, Imitation("z_torque", **how), 0, told, file)
        return model, env

    return imitates


KINDS = {
    "ppo": plain(PPO),
    "sac": plain(SAC),
    "lstm": recurrent(estimates=1.0),
    "dropout": recurrent(policy_kwargs={**NETWORK, "n_lstm_layers": 2, "lstm_kwargs": {"dropout": 0.5}}),
    "through estimates": recurrent(estimates=1.0, through_estimates=True),
}


def until(tells):
    """Ctrl-C after it has told so many times."""
    told = []

    def tell(steps):
        told.append(steps)
        if len(told) > tells:
            raise KeyboardInterrupt

    return tell


@pytest.mark.parametrize("stops", STOPS.values(), ids=STOPS)
@pytest.mark.parametrize("imitates", KINDS.values(), ids=KINDS)
def test_stopped_and_gone_on_it_ends_bit_for_bit_as_without(imitates, stops, tmp_path):
    uncut, env = imitates(HOW, lambda _: None, None)
    file = tmp_path / "imitated.pt"
    for stop in stops:
        with pytest.raises(KeyboardInterrupt):
            imitates(HOW, until(stop), file)
    steps = []
    cut, again = imitates(HOW, steps.append, file)
    expected, found = uncut.policy.state_dict(), cut.policy.state_dict()
    assert all(torch.equal(expected[name], found[name]) for name in expected)
    np.testing.assert_array_equal(env.reset(), again.reset())  # and draws what it would have drawn
    assert steps == sorted(steps)


def test_what_was_fitted_is_not_fitted_again(tmp_path):
    with pytest.raises(KeyboardInterrupt):
        KINDS["ppo"](HOW, until(TELLS - 5), tmp_path / "imitated.pt")
    told = []
    KINDS["ppo"](HOW, told.append, tmp_path / "imitated.pt")
    assert len(told) == ROUNDS * STEPS + 5
    told.clear()
    KINDS["ppo"](HOW, told.append, tmp_path / "imitated.pt")  # all is done: it plays, and no more
    assert len(told) == ROUNDS * STEPS


def test_it_is_written_on_the_way_for_a_machine_that_fails(tmp_path, monkeypatch):
    monkeypatch.setattr(imitated, "_SECONDS_OF_FILE", 0.0)
    file, found = tmp_path / "imitated.pt", []
    KINDS["ppo"](HOW, lambda _: found.append(file.is_file()), file)
    assert found[0] is False
    assert found[STEPS + 1] is True


def test_a_damaged_file_is_named(tmp_path):
    file = tmp_path / "imitated.pt"
    with pytest.raises(KeyboardInterrupt):
        KINDS["ppo"](HOW, until(STEPS + 2), file)
    whole = file.read_bytes()
    changed = bytearray(whole)
    changed[len(whole) // 2] ^= 1
    for content in (whole[:100], b"", whole[: len(whole) // 2], bytes(changed)):
        file.write_bytes(content)
        with pytest.raises(ValueError, match=r"imitated\.pt is damaged .*; remove it, and the imitation begins anew"):
            KINDS["ppo"](HOW, lambda _: None, file)


@pytest.fixture
def full(monkeypatch):
    def write(*_):
        raise OSError(errno.ENOSPC, "No space left on device")

    monkeypatch.setattr(imitated, "write_bytes", write)


def test_a_full_disk_ends_nothing(full, tmp_path):
    uncut, _ = KINDS["ppo"](HOW, lambda _: None, None)
    found, _ = KINDS["ppo"](HOW, lambda _: None, tmp_path / "imitated.pt")
    assert torch.equal(uncut.policy.action_net.weight, found.policy.action_net.weight)
    assert list(tmp_path.iterdir()) == []


@pytest.fixture
def no_numbers(monkeypatch):
    monkeypatch.setattr(imitation, "imitation_cost", lambda given, _: (given * float("nan")).mean())


def test_what_is_no_number_is_not_remembered(no_numbers, tmp_path):
    file = tmp_path / "imitated.pt"
    with pytest.raises((FloatingPointError, ValueError)):
        KINDS["ppo"](HOW, lambda _: None, file)
    content = torch.load(io.BytesIO(file.read_bytes()[32:]), weights_only=True)
    assert all(bool(part.isfinite().all()) for then in content["rounds"] for part in then["parts"][0].values())


def of_a_run(folder, **changes):
    hyperparams = {**tiny.PPO, "frame_stack": 2, "imitation": {"teacher": "z_torque", **HOW, **changes}}
    quiet = {"eval_freq": -1, "tensorboard": False, "progress": False}
    few = {"n_timesteps": 256, "env_kwargs": {"duration": 4.0}}
    return Training(run_folder=folder, hyperparams=hyperparams, **few, **quiet)


def test_a_training_that_is_stopped_while_it_imitates_goes_on(tmp_path, monkeypatch):
    def settings(name):
        return of_a_run(tmp_path / name)

    train.train(settings("uncut"))
    with monkeypatch.context() as patched:
        tell = until(STEPS + 3)
        patched.setattr(train.ShowProgress, "imitates", lambda _, steps: tell(steps))
        with pytest.raises(KeyboardInterrupt) as stop:
            train.train(settings("cut"))
    cut = tmp_path / "cut"
    assert stop.value.__notes__ == [f"{cut} keeps what was imitated", f"to go on: python train.py --resume {cut}"]
    assert (cut / IMITATED).is_file()
    assert not (cut / MODEL).exists()
    train.resume(cut, progress=False)
    assert not (cut / IMITATED).exists()
    expected, found = (load_policy(tmp_path / name).model.policy.state_dict() for name in ("uncut", "cut"))
    assert all(torch.equal(expected[name], found[name]) for name in expected)


def test_what_could_not_be_kept_is_not_said_to_be(full, tmp_path, monkeypatch):
    tell = until(STEPS + 3)
    monkeypatch.setattr(train.ShowProgress, "imitates", lambda _, steps: tell(steps))
    with pytest.raises(KeyboardInterrupt) as stop:
        train.train(of_a_run(tmp_path / "run"))
    assert f"{tmp_path / 'run'} keeps nothing that was imitated" in stop.value.__notes__


def test_weights_that_are_no_numbers_are_not_gone_on_from(no_numbers, tmp_path):
    with pytest.raises(Failed, match="the training failed") as failure:
        train.train(of_a_run(tmp_path / "run"))
    assert failure.value.__notes__ == [
        "its weights are no numbers any more, and not kept; a lower learning_rate may help"
    ]


def test_a_stop_while_a_teacher_is_designed_is_answered_at_once(tmp_path, monkeypatch):
    def design(*_):
        signal.raise_signal(signal.SIGINT)
        pytest.fail("it went on")

    config_of = train.checked_config(of_a_run(tmp_path / "run"))
    monkeypatch.setattr(train, "checked_config", lambda _: config_of)
    monkeypatch.setattr(imitation, "Teacher", design)
    with pytest.raises(KeyboardInterrupt):
        train.train(of_a_run(tmp_path / "run"))
