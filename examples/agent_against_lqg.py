"""A trained agent against LQG
===========================

The agent ``ppo`` acts on the rig's own stiff drive, as LQG does, which it imitated before it learnt by trial. Both, and
action 0 on the same drive, face the same rigs of the suite ``wide``, whose draws go beyond what the agent learnt on.
"""

import matplotlib.pyplot as plt
import numpy as np

from drillrig_env.evaluation.runner import run
from drillrig_env.evaluation.scores import score
from drillrig_env.evaluation.suites import suite
from drillrig_env.policy import load

rigs = suite("wide", rigs=200)
scores = {name: score(run(load(name), rigs)) for name in ("constant", "lqg", "ppo")}
for name, found in scores.items():
    print(f"{name}: {found['mitigated'].mean():.3f} mitigated, {np.median(found['time_to_calm']):.1f} s to calm")

# %%
# Who mitigates what: slow targets and heavy loads are hard. Failures lie on top.

fig, axes = plt.subplots(1, 3, figsize=(8, 3), sharex=True, sharey=True)
for ax, (name, found) in zip(axes, scores.items(), strict=True):
    for calm, colour, what in ((1.0, "tab:blue", "mitigated"), (0.0, "tab:red", "not")):
        chosen = found["mitigated"] == calm
        ax.scatter(found["speed_target"][chosen], found["normal_force"][chosen], s=8, c=colour, label=what)
    ax.set(title=name, xlabel="target, rad/s")
axes[0].set_ylabel("normal force, N")
axes[0].legend(fontsize=8)
fig.tight_layout()
plt.show()
