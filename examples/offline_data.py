"""Offline data with Minari
========================

Episodes of a good policy, recorded with Minari's collector, as data for offline learning. For whole data sets of any
policies there is ``python -m agents.dataset``. Needs the extra ``clients``; what it draws:

.. image:: /images/examples/offline_data.png
   :alt: Bit speed over target in three episodes: from rest, or shaken by a step of the load, each comes back to 1
"""

# sphinx_gallery_thumbnail_path = 'images/examples/offline_data.png'

import matplotlib.pyplot as plt
import minari
import numpy as np

from drillrig_env.policy import load

policy = load("lqg")
env = minari.DataCollector(policy.make_env(), record_infos=True)
for seed in range(3):
    observation, _ = env.reset(seed=seed)
    memory, begins, done = None, np.ones(1, dtype=bool), False
    while not done:
        actions, memory = policy.predict(observation[None], memory, begins)
        observation, _, terminated, truncated, _ = env.step(actions[0])
        begins[:], done = False, terminated or truncated
data = env.create_dataset("drillrig/three-episodes-v0", algorithm_name="lqg")

# %%
# The data set lies in Minari's folder; any library that reads it can learn from it.

episodes = list(data)
print(f"{data.total_episodes} episodes, {data.total_steps} steps")
fig, ax = plt.subplots(figsize=(7, 3))
for episode in episodes:
    bit_speed, target = (np.ravel(episode.infos[name]) for name in ("bit_speed", "speed_target"))
    ax.plot(0.1 * np.arange(len(bit_speed)), bit_speed / target, lw=0.9)
ax.set(title="What LQG did in three recorded episodes", xlabel="time, s", ylabel="bit speed / target")
fig.tight_layout()
plt.show()
