"""Two answers to one speed
========================

Between the critical speed and the fold, calm rotation and stick-slip are both stable: at one and the same speed
reference and load the rig does what it did before. Two runs with the same inputs at the end show it.
"""

import matplotlib.pyplot as plt

from drillrig_env import Friction, Rig, simulate, stability

rig, friction = Rig(), Friction(normal_force=20.0)
critical, fold = stability.critical_speed(rig, friction), stability.fold_speed(rig, friction)
speed = 0.5 * (critical + fold)
print(f"critical speed {critical:.3f} rad/s, fold {fold:.3f} rad/s, both runs end at {speed:.3f} rad/s")

# %%
# One run comes from above the fold, where there is no stick-slip, the other from below the critical speed.

from_above = simulate(rig, friction, speed_reference=[(0, 1.5 * fold), (40, speed)], duration=100.0)
from_below = simulate(rig, friction, speed_reference=[(0, 0.8 * critical), (40, speed)], duration=100.0)

fig, axes = plt.subplots(2, 1, figsize=(7, 4.5), sharex=True, sharey=True)
for ax, run, name in zip(axes, (from_above, from_below), ("from above", "from below"), strict=True):
    ax.plot(run.time, run.bit_speed, lw=0.8, label="bit")
    ax.plot(run.time, run.speed_reference, "0.3", ls="--", label="speed reference")
    ax.set(title=f"Reached {name}", ylabel="speed, rad/s")
axes[0].legend(loc="upper right")
axes[1].set_xlabel("time, s")
fig.tight_layout()
plt.show()
