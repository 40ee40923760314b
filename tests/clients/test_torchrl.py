"""TorchRL's environments around a rig and around several: specs, infos as tensors, rollouts.

TorchRL starts processes afresh, so the id names the module that registers it.
"""

from functools import partial

import pytest

pytestmark = pytest.mark.clients
torch = pytest.importorskip("torch", reason="needs the extra clients")
envs = pytest.importorskip("torchrl.envs", reason="needs the extra clients")

INFOS = {"bit_speed", "normal_force", "torque_into_string", "is_success", "start"}


@pytest.mark.parametrize("name", ["drillrig_env:DrillRig-v0", "drillrig_env:DrillRigSurface-v0"])
@pytest.mark.parametrize("rigs", [None, 3])
def test_specs_hold_and_infos_become_tensors(name, rigs):
    if rigs:  # registers the infos by itself
        env = envs.GymEnv(name, num_envs=rigs, duration=0.5)
    else:
        env = envs.GymEnv(name, duration=0.5).auto_register_info_dict()
    envs.check_env_specs(env)
    rollout = env.rollout(12, break_when_any_done=False)
    shape = (12,) if rigs is None else (rigs, 12)
    assert rollout.batch_size == torch.Size(shape)
    assert set(rollout["next"].keys()) >= INFOS
    for key in INFOS:
        assert rollout["next", key].shape == torch.Size(shape)
    assert bool(torch.isfinite(rollout["next", "reward"]).all())
    assert int(rollout["next", "truncated"].sum()) == 2 * (rigs or 1)


def test_a_seed_fixes_a_rollout():
    rewards = []
    for _ in range(2):
        env = envs.GymEnv("drillrig_env:DrillRig-v0", num_envs=3, duration=0.5)
        torch.manual_seed(0)
        env.set_seed(7)
        rewards.append(env.rollout(12, break_when_any_done=False)["next", "reward"])
    assert torch.equal(*rewards)


def test_several_processes():
    env = envs.ParallelEnv(2, partial(envs.GymEnv, "drillrig_env:DrillRig-v0", duration=0.5))
    try:
        assert env.rollout(5)["next", "reward"].shape == torch.Size((2, 5, 1))
    finally:
        env.close()
