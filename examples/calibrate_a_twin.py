"""Calibrate a twin
================

A record of a rig, here a simulated one with noise so that the truth is known, and a fit of its friction and its lower
shaft. The fit says how well the record tells each number. ``docs/tutorial.md`` goes the whole way from logger files.
"""

import matplotlib.pyplot as plt
import numpy as np

from drillrig_env import Friction, simulate
from drillrig_env.calibrate import Record, calibrate

true = Friction(normal_force=20.0)
run = simulate(friction=true, speed_reference=2.0, duration=24.0, sample_period=0.02)
noise = np.random.default_rng(0)
signals = {
    name: getattr(run, name) + 0.05 * noise.standard_normal(len(run.time))
    for name in ("bit_speed", "top_speed", "current")
}
record = Record("a run", "", run.time, signals, run.speed_reference, run.normal_force)

# %%
# What is known from weighing, data sheets and settings is fixed; the first guess of the friction is off.

known = ("J_1", "J_2", "J_3", "k_1", "d_1", "d_2", "L", "R", "K_T", "K_E", "C_m", "T_f", "k_p", "k_i")
found = calibrate([record], friction=Friction(20.0, 0.45, 0.33), fix=dict.fromkeys(known), starts=1)
for name, truth in (("mu_k", true.mu_k), ("v_b", true.v_b)):
    low, high = found.interval(name)
    print(f"{name}: {low:.4f} to {high:.4f} with 90 %, truly {truth}")

model = simulate(found.rig, found.friction, speed_reference=2.0, duration=24.0, sample_period=0.02)
fig, ax = plt.subplots(figsize=(7, 3))
ax.plot(record.time, signals["bit_speed"], ".", ms=2, color="0.6", label="measured")
ax.plot(model.time, model.bit_speed, lw=1, label="the fitted model, from rest")
ax.set(title="Measured beside model", xlabel="time, s", ylabel="bit speed, rad/s")
ax.legend(loc="upper right")
fig.tight_layout()
plt.show()
