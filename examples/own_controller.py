"""A controller of your own
========================

Ten lines of controller, in the same suite as the field. It lets the speed reference give way to the swing of the
torque in the shaft, as a soft drive would.
"""

import matplotlib.pyplot as plt

from baselines import Baseline, make
from drillrig_env.evaluation.runner import run
from drillrig_env.evaluation.scores import score
from drillrig_env.evaluation.suites import suite


class GiveWay(Baseline):
    """The reference gives way to the swing of the torque about its running mean."""

    channels = ("speed_reference", "speed_target", "twist_23")
    memory = 1  # the running mean

    def desired_reference(self, seen, privileged, memory):
        torque = -self.rig.k_2 * seen["twist_23"]
        memory[:, 0] += 0.05 * (torque - memory[:, 0])
        return seen["speed_target"] - 8.0 * (torque - memory[:, 0])


# %%
# Every policy meets the same rigs in developed stick-slip. The seeds are those of the suite, which nothing may be tuned
# on; tune on others (``drillrig_env.seeds``).

rigs = suite("default", rigs=100)
policies = {"constant": make("constant"), "z_torque": make("z_torque"), "GiveWay": GiveWay()}
shares = {name: score(run(policy, rigs))["mitigated"].mean() for name, policy in policies.items()}
print(*(f"{name}: {share:.2f}" for name, share in shares.items()), sep="\n")

fig, ax = plt.subplots(figsize=(6, 2.5))
ax.barh(list(shares), list(shares.values()))
ax.set(title="Share of 100 random rigs brought calm to their target", xlim=(0, 1))
ax.invert_yaxis()
fig.tight_layout()
plt.show()
