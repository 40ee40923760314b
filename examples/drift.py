"""A rig that drifts
=================

Friction wanders, the disc is tilted, and the operator steps the target: what an episode need not keep still. The same
policy with and without all that.
"""

import gymnasium as gym
import matplotlib.pyplot as plt
import numpy as np

from drillrig_env import Scenario, Tilt, Wandering
from drillrig_env.policy import load

still = Scenario(load_step=0.0, stick_slip=1.0, steady=0.0)
drifting = Scenario(
    load_step=0.0,
    stick_slip=1.0,
    steady=0.0,
    wandering=Wandering(0.2, 20.0),
    tilt=Tilt(0.1, turns=(1, 2)),
    target_step=1.0,
)
policy = load("lqg")
fig, axes = plt.subplots(2, 1, figsize=(7, 4.5), sharex=True)
for ax, scenario, name in zip(axes, (still, drifting), ("Nothing changes", "Everything drifts"), strict=True):
    env = gym.make("drillrig_env:DrillRig-v0", scenario=scenario)
    observation, info = env.reset(seed=11)
    memory, begins = None, np.ones(1, dtype=bool)
    bit_speed, target = [], []
    for _ in range(env.spec.max_episode_steps):
        actions, memory = policy.predict(observation[None], memory, begins)
        observation, _, _, _, info = env.step(actions[0])
        begins[:] = False
        bit_speed.append(info["bit_speed"])
        target.append(info["speed_target"])
    time = 0.1 * np.arange(1, len(bit_speed) + 1)
    ax.plot(time, bit_speed, lw=0.9, label="bit")
    ax.plot(time, target, color="0.4", ls="--", label="target")
    ax.set(title=f"{name}: calm at the target at the end? {bool(info['is_success'])}", ylabel="speed, rad/s")
axes[0].legend(loc="upper right")
axes[1].set_xlabel("time, s")
fig.tight_layout()
plt.show()
