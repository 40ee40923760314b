"""First episode
=============

The environment for one episode, with an action that never moves the drive's speed reference. Below its critical speed
the rig sticks and slips: the bit stands, breaks loose, and races at twice the target.
"""

import gymnasium as gym
import matplotlib.pyplot as plt
import numpy as np

env = gym.make("drillrig_env:DrillRig-v0")
pins = {"normal_force": 20.0, "speed_target": 2.4, "start": "stick_slip", "load_steps": []}
observation, info = env.reset(seed=0, options=pins)

# %%
# An action is the rate of the speed reference, as a share of the slew limit; 0 holds it. The observation has
# everything there is; ``info`` has the same and more in physical units.

time, bit_speed, total = [], [], 0.0
for step in range(env.spec.max_episode_steps):
    observation, reward, terminated, truncated, info = env.step(np.zeros(1, dtype=np.float32))
    time.append(0.1 * (step + 1))
    bit_speed.append(info["bit_speed"])
    total += reward
print(f"return {total:.1f}, calm at the target: {info['is_success']}")

fig, ax = plt.subplots(figsize=(7, 3))
ax.plot(time, bit_speed, label="bit")
ax.axhline(info["speed_target"], color="0.4", ls="--", label="target")
ax.set(title="With action 0 the bit sticks and slips", xlabel="time, s", ylabel="speed, rad/s")
ax.legend(loc="upper right")
plt.show()
