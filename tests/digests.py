"""What must stay the same bit for bit: episodes, policies and analyses as digests, kept in digests.json.

python -m tests.digests            # compare with what is kept
python -m tests.digests --write    # keep today's, on purpose

Bits depend on the processor and on the libraries below, so digests are kept for each such machine; on another
one the rounded values beside them are what is compared.
"""

from __future__ import annotations

import hashlib
import json
import os
import sys
from collections.abc import Callable
from importlib.metadata import version
from pathlib import Path
from typing import Any

import gymnasium as gym
import numpy as np

import drillrig_env
from drillrig_env import Friction, Rig
from drillrig_env.evaluation.contestants import contestant_of
from drillrig_env.evaluation.provenance import provenance
from drillrig_env.evaluation.runner import run
from drillrig_env.evaluation.suites import suite
from drillrig_env.jit.threads import available_threads
from drillrig_env.policy import find_policy

RECORD = Path(__file__).with_name("digests.json")
STEPS, RIGS, SEED = 200, 200, 7


def machine() -> str:
    """What the bits depend on: processor, BLAS kernel and threads, and versions."""
    processor = provenance()["machine"].rpartition(",")[0]
    threads = os.environ.get("OPENBLAS_NUM_THREADS") or os.environ.get("OMP_NUM_THREADS") or available_threads()
    libraries = [f"{name} {version(name)}" for name in ("numpy", "scipy", "numba", "torch")]
    blas = f"{os.environ.get('OPENBLAS_CORETYPE', 'any BLAS kernel')} on {threads} threads"
    return ", ".join([processor, blas, *libraries])


def _actions(num_envs: int) -> np.ndarray:
    return np.random.default_rng(SEED).uniform(-1.2, 1.2, (STEPS, num_envs, 1)).astype(np.float32)


def _single(env_id: str) -> list[np.ndarray]:
    env = gym.make(env_id)
    observation, _ = env.reset(seed=SEED)
    seen, rewards = [observation], []
    for action in _actions(1)[:, 0]:
        observation, reward, *_ = env.step(action)
        seen.append(observation)
        rewards.append(reward)
    return [np.array(seen), np.array(rewards)]


def _vector(env_id: str) -> list[np.ndarray]:
    env = gym.make_vec(env_id, num_envs=8)
    observation, _ = env.reset(seed=SEED)
    seen, rewards = [observation], []
    for actions in _actions(8):
        observation, reward, *_ = env.step(actions)
        seen.append(observation)
        rewards.append(reward)
    return [np.array(seen), np.array(rewards)]


def _sb3(env_id: str) -> list[np.ndarray]:
    env = drillrig_env.make_sb3(8, seed=SEED, env_id=env_id)
    seen, rewards = [np.asarray(env.reset())], []
    for actions in _actions(8):
        observation, reward, *_ = env.step(actions)
        seen.append(np.asarray(observation))
        rewards.append(reward)
    return [np.array(seen), np.array(rewards)]


def _policy(name: str) -> list[np.ndarray]:
    chosen = suite("default", RIGS)
    contestant = contestant_of(find_policy(name), "DrillRig-v0")
    make = next(iter(contestant.members.values()))
    episodes = run(make(chosen), chosen, **contestant.env)
    return [episodes.speed_reference, episodes.average, episodes.reward]


def _stability() -> list[np.ndarray]:
    rig, frictions = Rig(), Friction(np.array([5.0, 10.0, 20.0, 30.0]))
    orbit = drillrig_env.stability.stick_slip_orbit(rig, Friction(10.0), speed_reference=2.0)
    return [
        np.atleast_1d(drillrig_env.stability.critical_speed(rig, frictions)),
        np.atleast_1d(drillrig_env.stability.fold_speed(rig, frictions)),
        np.array([orbit.period, orbit.stuck, *np.abs(orbit.multipliers)]),
    ]


def _kinds() -> dict[str, Callable[[], list[np.ndarray]]]:
    kinds: dict[str, Callable[[], list[np.ndarray]]] = {}
    for env_id in ("DrillRig-v0", "DrillRigSurface-v0"):
        kinds[f"single {env_id}"] = lambda env_id=env_id: _single(env_id)
        kinds[f"vector {env_id}"] = lambda env_id=env_id: _vector(env_id)
        kinds[f"sb3 {env_id}"] = lambda env_id=env_id: _sb3(env_id)
    for name in ("lqg", "jump_ease", "ppo"):
        kinds[f"policy {name}"] = lambda name=name: _policy(name)
    kinds["stability"] = _stability
    return kinds


KINDS = _kinds()


def digest_of(kind: str) -> dict[str, Any]:
    """Digest of every bit, and a few rounded values, of one kind."""
    arrays = KINDS[kind]()
    digest = hashlib.sha256()
    for array in arrays:
        digest.update(np.ascontiguousarray(array).tobytes())
    values = [float(f"{float(np.mean(array)):.6g}") for array in arrays]
    return {"digest": digest.hexdigest(), "values": values}


def main() -> int:
    """Compare with the record, or write it; the exit status."""
    kept = json.loads(RECORD.read_text(encoding="utf-8")) if RECORD.exists() else {}
    found = {kind: digest_of(kind) for kind in KINDS}
    if "--write" in sys.argv:
        kept[machine()] = found
        RECORD.write_text(json.dumps(kept, indent=1) + "\n", encoding="utf-8")
        return 0
    if machine() in kept:
        changed = [kind for kind in KINDS if kept[machine()].get(kind) != found[kind]]
    else:
        print(f"no digests of this machine ({machine()}): comparing rounded values")
        changed = [kind for kind in KINDS if not _near(kept, kind, found[kind]["values"])]
    print("\n".join(f"changed: {kind}" for kind in changed) or "all the same")
    return 1 if changed else 0


def _near(kept: dict[str, Any], kind: str, values: list[float]) -> bool:
    """Whether another machine has values such as these, but for their last digit."""
    others = [one[kind]["values"] for one in kept.values() if kind in one]
    return any(np.allclose(values, one, rtol=1e-4, atol=1e-6) for one in others)


if __name__ == "__main__":
    sys.exit(main())
