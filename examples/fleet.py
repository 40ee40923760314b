"""A fleet of rigs that nobody knows
=================================

A controller is designed for a rig, and meets another. Here each of 64 rigs has its string, inertias and friction
anywhere from half to twice the nominal, and the controllers know the nominal one alone.
"""

import matplotlib.pyplot as plt
import numpy as np

from drillrig_env import Fleet, Scenario
from drillrig_env.policy import load

fleet = Fleet.around(spread={"string": 2.0, "inertias": 2.0, "friction": 2.0}, count=64, seed=0)
scenario = Scenario(rigs=fleet, load_step=0.0)


def mitigated(name):
    """Share of 256 episodes that end calm at the target, and the rig that each had."""
    policy = load(name)
    envs = policy.make_vec(256, scenario=scenario)
    observations, infos = envs.reset(seed=0)
    memory, begins = None, np.ones(256, dtype=bool)
    for _ in range(600):
        actions, memory = policy.predict(observations, memory, begins)
        observations, _, terminated, truncated, infos = envs.step(actions)
        begins = terminated | truncated
    return infos["is_success"], infos["rig"]


names = ("constant", "z_torque", "lqg")
shares = []
for name in names:
    success, rig = mitigated(name)
    shares.append(success.mean())
    print(f"{name}: {shares[-1]:.2f} of the episodes, on {len(set(rig.tolist()))} rigs")

fig, ax = plt.subplots(figsize=(6, 2.2))
ax.barh(names, shares)
ax.set(title="Calm at the target, on rigs that the controller does not know", xlim=(0, 1))
ax.invert_yaxis()
fig.tight_layout()
plt.show()
