"""Free a rig: past the fold and back
==================================

A rig that sticks is not freed by going a little faster than the critical speed. It is freed by going past the fold
once, where stick-slip cannot live, and coming back slowly. That is the whole of jump-and-ease.
"""

import matplotlib.pyplot as plt
import numpy as np

from drillrig_env import Friction, Rig, simulate, stability

rig, friction = Rig(), Friction(normal_force=20.0)
critical, fold = stability.critical_speed(rig, friction), stability.fold_speed(rig, friction)
target = critical + 0.1 * (fold - critical)

# %%
# A schedule holds each value from its time on; a ramp is many small steps. Both runs go up and come down in 20 s.


def up_and_down(highest):
    rise = np.linspace(target, highest, 40)
    return [(0, target), *zip(40 + 0.5 * np.arange(80), [*rise, *rise[::-1]], strict=True)]


short, far = up_and_down(fold - 0.4), up_and_down(fold + 0.4)

fig, axes = plt.subplots(2, 1, figsize=(7, 4.5), sharex=True, sharey=True)
for ax, schedule, name in zip(axes, (short, far), ("Not past the fold", "Past the fold, and back"), strict=True):
    run = simulate(rig, friction, speed_reference=schedule, duration=120.0)
    ax.plot(run.time, run.bit_speed, lw=0.8, label="bit")
    ax.plot(run.time, run.speed_reference, "0.3", label="speed reference")
    ax.axhline(fold, color="tab:red", ls=":", label="fold")
    last = run.bit_speed[-1000:]
    ax.set(title=f"{name}: swings by {np.ptp(last):.2f} rad/s at the end", ylabel="speed, rad/s")
axes[0].legend(loc="upper right", ncols=3)
axes[1].set_xlabel("time, s")
fig.tight_layout()
plt.show()
