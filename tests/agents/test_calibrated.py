"""Training on the rigs that a calibration allows."""

from dataclasses import replace

import pytest

from agents.policy.run_folder import read_config
from agents.training.settings import Training, checked_config
from agents.training.train import train
from drillrig_env import Fleet, Friction, Scenario, Task
from drillrig_env.calibrate.posterior import Posterior
from drillrig_env.policy import load
from tests.agents.tiny import PPO
from tests.calibrate.folder import FRICTION, RIG, write_folder
from tests.test_own_law import FILE
from train import main


@pytest.fixture
def folder(tmp_path):
    return write_folder(tmp_path / "my_rig")


def task_of(training):
    config = checked_config(training)
    return config, Task(**{name: config["env_kwargs"][name] for name in ("rig", "scenario")})


def test_a_training_takes_the_half_that_is_learnt_on(folder):
    posterior = Posterior.from_folder(folder)
    config, task = task_of(Training(env_kwargs={"rig": folder}, hyperparams=PPO))
    assert task.rig == RIG
    assert task.scenario.rigs == posterior.training
    assert set(task.scenario.rigs.rigs).isdisjoint(posterior.judged.rigs)
    assert config["calibration"] == {"folder": "my_rig", "draws": posterior.digest, "path": str(folder)}
    assert task.scenario.friction.as_dict() == FRICTION.as_dict()
    assert task.scenario.normal_force == pytest.approx((24.0 * 3.0 / 30.0, 24.0 * 36.0 / 30.0))  # the file has 3 to 36
    assert task.scenario.spread == pytest.approx(0.08)  # and 0.28
    assert task.scenario.candidates == 3


def test_what_a_training_gives_itself_is_kept(folder):
    own = {"rig": str(folder), "scenario": {"normal_force": [5.0, 6.0]}}
    _, task = task_of(Training(env_kwargs=own, hyperparams=PPO))
    assert task.scenario.normal_force == (5.0, 6.0)
    assert len(task.scenario.rigs.rigs) == 32
    _, task = task_of(Training(env_kwargs={"rig": folder, "scenario": "wide"}, hyperparams=PPO))
    assert task.scenario.normal_force == pytest.approx((24.0 * 2.0 / 30.0, 24.0 * 40.0 / 30.0))


def test_stages_of_a_curriculum_are_on_the_same_rigs(folder):
    stages = {"scenarios": [{"speed_target": [3.0, 4.0]}], "share": 0.5}
    config = checked_config(Training(env_kwargs={"rig": folder}, hyperparams={**PPO, "curriculum": stages}))
    (first,) = (Scenario.named(one) for one in config["hyperparameters"]["curriculum"]["scenarios"])
    assert first.rigs == Posterior.from_folder(folder).training
    assert first.friction.mu_k == 0.25


def test_an_environment_of_a_fleet_has_the_calibrations(folder):
    training = Training(env_id="DrillRigUnknown-v0", env_kwargs={"rig": folder}, hyperparams=PPO)
    path = folder.parent / "mine.yml"
    path.write_text("DrillRigUnknown-v0: {policy: MlpPolicy, n_timesteps: 512}")
    _, task = task_of(replace(training, conf_file=path))
    assert task.scenario.rigs == Posterior.from_folder(folder).training


def test_the_command_trains_and_keeps_the_rigs_in_the_config(folder, tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    pairs = [f"{name}:{'null' if value is None else value}" for name, value in PPO.items()]
    words = ["-n", "128", "--eval-freq", "-1", "--no-progress", "--no-tensorboard"]
    assert main(["--rig", "my_rig", *words, "--run-folder", "run", "--hyperparams", *pairs]) == 0
    config = read_config("run")
    assert config["calibration"]["path"] == "my_rig"
    kept = Scenario.named(config["env_kwargs"]["scenario"])
    assert kept.rigs == Posterior.from_folder(folder).training
    assert load("run").make_env().unwrapped.task.rig == RIG


@pytest.mark.parametrize("file", ["draws.npz", "calibration.json"])
def test_a_missing_file_is_named_before_anything_is_written(file, folder, tmp_path, monkeypatch, capsys):
    monkeypatch.chdir(tmp_path)
    (folder / file).unlink()
    with pytest.raises(SystemExit) as end:
        main(["--rig", "my_rig", "--run-folder", "run"])
    assert end.value.code == 2
    assert f"my_rig is no folder of a calibration: {file} is missing" in capsys.readouterr().err
    assert not (tmp_path / "run").exists()


def test_rigs_that_are_given_twice_are_refused(folder):
    for scenario in ({"rigs": {"spread": {"k_1": 2.0}}}, Scenario(rigs=Fleet.around(spread={"k_1": 2.0}))):
        with pytest.raises(ValueError, match=r"the scenario's rigs and .*my_rig are both given; allowed: one of them"):
            checked_config(Training(env_kwargs={"rig": folder, "scenario": scenario}, hyperparams=PPO))


def test_an_agent_of_another_rig_is_no_beginning(folder, tmp_path):
    run = train(
        Training(
            env_kwargs={"rig": {"k_2": 0.5}, "duration": 5.0},
            hyperparams={**PPO, "n_timesteps": 128},
            eval_freq=-1,
            run_folder=tmp_path / "run",
            tensorboard=False,
            progress=False,
        )
    )
    with pytest.raises(ValueError, match="run has a rig of its own; allowed with a calibration: the chapter's"):
        checked_config(Training(env_kwargs={"rig": folder}, resume_from=str(run)))


def test_another_law_of_friction_goes_into_the_config_by_its_name(tmp_path):
    folder = write_folder(tmp_path / "other", friction=Friction(24.0, 0.42, 0.25, 1.3, law="gaussian"))
    _, task = task_of(Training(env_kwargs={"rig": folder}, hyperparams=PPO))
    assert task.scenario.friction.law == "gaussian"
    (tmp_path / "mine.py").write_text(FILE, encoding="utf-8")
    own = Friction(24.0, 0.42, 0.25, 1.3, law=f"{tmp_path / 'mine.py'}:level")
    config, task = task_of(Training(env_kwargs={"rig": write_folder(tmp_path / "own", friction=own)}, hyperparams=PPO))
    assert config["env_kwargs"]["scenario"]["friction"]["law"].endswith("mine.py:level")
    assert task.scenario.friction.law.name == "level"
