"""Model predictive control on copies of the environment
=====================================================

``get_state`` and ``set_state`` come back to a moment at little cost. So a planner can try sequences of actions in many
copies at once, take the first action of the best, and plan anew: random shooting. The reward is all that it is told.
"""

import gymnasium as gym
import matplotlib.pyplot as plt
import numpy as np

from drillrig_env import Friction, simulate

HORIZON, TRIED, STEPS = 25, 128, 250  # control steps, sequences, control steps
sticking = simulate(friction=Friction(20.0), speed_reference=2.4, duration=40.0).state[-1]
pins = {"state": sticking, "normal_force": 20.0, "speed_target": 2.4, "load_steps": []}
envs = gym.make_vec("drillrig_env:DrillRig-v0", num_envs=TRIED, scenario="nominal")
_, infos = envs.reset(seed=0, options=pins)  # all of them are one rig in one state
random, best = np.random.default_rng(0), np.zeros(HORIZON)
bit_speed, reference = [], []

for _ in range(STEPS):
    wiggle = np.repeat(random.normal(0.0, 0.7, (TRIED, HORIZON // 5)), 5, axis=1)  # each held for half a second
    wiggle[0] = 0.0  # the plan of before is among them
    plans = np.clip(np.append(best[1:], 0.0) + wiggle, -1.0, 1.0).astype(np.float32)
    now, returns = envs.get_state(), np.zeros(TRIED)
    for step in range(HORIZON):
        returns += envs.step(plans[:, step, None])[1]
    envs.set_state(now)
    best = plans[np.argmax(returns)]
    *_, infos = envs.step(np.full((TRIED, 1), best[0]))
    bit_speed.append(infos["bit_speed"][0])
    reference.append(infos["speed_reference"][0])

print(f"the last 5 s swing by {np.ptp(bit_speed[-50:]):.2f} rad/s, their mean is {np.mean(bit_speed[-50:]):.2f} rad/s")
time = 0.1 * np.arange(1, STEPS + 1)
fig, ax = plt.subplots(figsize=(7, 3))
ax.plot(time, bit_speed, label="bit")
ax.plot(time, reference, lw=0.8, label="speed reference, planned")
ax.axhline(2.4, color="0.4", ls="--", label="target")
ax.set(title="A planner frees the rig and holds it", xlabel="time, s", ylabel="rad/s")
ax.legend(loc="upper right")
fig.tight_layout()
plt.show()
