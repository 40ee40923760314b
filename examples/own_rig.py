"""A rig of your own
=================

A rig is a record of its parameters. Change what differs from the chapter's rig, read it from a TOML file, or make it
from the lengths and diameters of a string. What follows from it, times, speeds and loads of the environment, follows.
"""

import gymnasium as gym
import matplotlib.pyplot as plt
import numpy as np

from drillrig_env import Friction, Rig, Task, stability

rigs = {"the chapter's": Rig(), "twice the inertia": Rig(J_1=0.0576), "half the shaft": Rig(k_2=0.2382)}

# %%
# Critical speed over the normal force: to the left of each line steady rotation is unstable.

forces = np.linspace(4.0, 30.0, 40)
fig, ax = plt.subplots(figsize=(6, 3.2))
for name, rig in rigs.items():
    ax.plot(stability.critical_speed(rig, Friction(forces)), forces, label=name)
ax.set(title="Left of its line a rig will stick and slip", xlabel="speed reference, rad/s", ylabel="normal force, N")
ax.legend()
fig.tight_layout()
plt.show()

# %%
# The environment of a rig takes its control period, targets, loads and the length of an episode from the rig's scales.

for name, rig in rigs.items():
    task = Task.for_rig(rig)
    print(f"{name}: a step of {task.control_period:.3f} s, an episode of {task.duration:.0f} s")
env = gym.make("drillrig_env:DrillRig-v0", rig=rigs["twice the inertia"])
observation, info = env.reset(seed=0)
print(f"target {info['speed_target']:.2f} rad/s at {info['normal_force']:.1f} N")
