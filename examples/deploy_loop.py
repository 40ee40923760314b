"""A controller on hardware, tried on a simulated rig
==================================================

The loop that runs a policy on a rig, with its supervisor and its log, and a simulated rig in the place of the hardware.
At 10 s the instruments fall silent for half a second: the supervisor holds the reference, and goes on.
"""

from pathlib import Path
from tempfile import mkdtemp

import matplotlib.pyplot as plt

from drillrig_env.deploy import Limits, Supervisor, read_log, replay_log, run_loop
from drillrig_env.twin.dry_run import DryRig, Instant


class Silent(DryRig):
    """A rig whose instruments show nothing for half a second."""

    def measure(self):
        shown = super().measure()
        return dict.fromkeys(shown) if 100 <= self.steps < 105 else shown


rig, time, log = Silent(3), Instant(), Path(mkdtemp()) / "run.csv"
supervisor = Supervisor("lqg", Limits(fallback="z_torque"))
inputs = {"reference": rig.reference, "target": rig.target}
run_loop(supervisor, rig, **inputs, steps=300, log=log, clock=time, sleep=time.sleep)
for event in supervisor.events.kept:
    print(event)
print(f"the bit's speed swings by {rig.bit_speed_deviation:.3f} rad/s at the end")
print(f"commands that differ when the log is played again: {replay_log(log).differing}")

# %%
# The log holds all that was measured, decided and why, and can be played again through the same file to the last bit.

_, rows = read_log(log)
rows = list(rows)
fig, ax = plt.subplots(figsize=(7, 3))
ax.plot([row.time for row in rows], [row.measured["top_speed"] for row in rows], lw=0.9, label="top speed, measured")
ax.plot([row.time for row in rows], [row.command for row in rows], label="speed reference, commanded")
ax.axvspan(10.0, 10.5, color="tab:red", alpha=0.2, label="instruments silent")
ax.set(title="The supervisor holds through a gap", xlabel="time, s", ylabel="rad/s")
ax.legend()
fig.tight_layout()
plt.show()
