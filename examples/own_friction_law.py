"""A friction law of your own
==========================

Three functions, the coefficient of friction and its first two derivatives by speed, make a law. The stepper, the
analyses and the environments take it like the three that are built in.
"""

import matplotlib.pyplot as plt
import numpy as np

from drillrig_env import Friction, Law, Rig, simulate, stability


def coefficient(speed, mu_s, mu_k, v_b):
    return mu_k + (mu_s - mu_k) / (1.0 + v_b * speed)


def slope(speed, mu_s, mu_k, v_b):
    return -(mu_s - mu_k) * v_b / (1.0 + v_b * speed) ** 2


def curvature(speed, mu_s, mu_k, v_b):
    return 2.0 * (mu_s - mu_k) * v_b**2 / (1.0 + v_b * speed) ** 3


hyperbola = Law("hyperbola", coefficient, slope, curvature)
rig, speeds = Rig(), np.linspace(0.01, 5.0, 300)
fig, (left, right) = plt.subplots(1, 2, figsize=(8, 3))
for law in ("exponential", hyperbola):
    friction = Friction(normal_force=20.0, law=law)
    critical = stability.critical_speed(rig, friction)
    print(f"{law}: critical speed {critical:.3f} rad/s")
    run = simulate(rig, friction, speed_reference=2.4, duration=20.0)
    left.plot(speeds, friction.torque(rig, speeds), label=str(law))
    right.plot(run.time, run.bit_speed, lw=0.9)
left.set(title="Torque of the rock", xlabel="bit speed, rad/s", ylabel="N m")
right.set(title="The same rig on it, from rest", xlabel="time, s", ylabel="bit speed, rad/s")
left.legend()
fig.tight_layout()
plt.show()
