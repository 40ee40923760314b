"""A policy on hardware: one file, and what runs it at the control period with NumPy and onnxruntime alone.

See docs/hardware.md. Nothing here loads PyTorch, Stable-Baselines3 or Numba; only `export`, `ship` and their `build`
and `graph`, which make the files, need more.

A policy's file in a loop, on a simulated rig whose time does not wait, with an operator who stops it:

>>> from drillrig_env.deploy import Operator, State, Supervisor, run_loop, shipped_policies
>>> from drillrig_env.twin.dry_run import DryRig, Instant
>>> "z_torque" in shipped_policies()
True
>>> supervisor, rig, time = Supervisor("z_torque"), DryRig(3), Instant()
>>> orders = {15: Operator(target=2.5), 25: Operator(stop="the shift ends")}
>>> inputs = {"reference": rig.reference, "target": rig.target, "operator": orders.get}
>>> timing = run_loop(supervisor, rig, steps=60, clock=time, sleep=time.sleep, **inputs)
>>> [event.reason for event in supervisor.events.kept if "shift" in event.reason]
['the shift ends']
>>> supervisor.state is State.RAMP, timing.missed
(True, 0)
"""

from drillrig_env.deploy.connection import connect
from drillrig_env.deploy.controller import Controller
from drillrig_env.deploy.events import Event, Events
from drillrig_env.deploy.limits import Limits
from drillrig_env.deploy.log import Log, read_log
from drillrig_env.deploy.loop import Hardware, Operator, Timing, run_loop
from drillrig_env.deploy.policy_file import PolicyFile, shipped_policies
from drillrig_env.deploy.replay import Replay, replay_log
from drillrig_env.deploy.supervisor import State, Supervisor
from drillrig_env.deploy.watchdog import Watchdog

__all__ = [
    "Controller",
    "Event",
    "Events",
    "Hardware",
    "Limits",
    "Log",
    "Operator",
    "PolicyFile",
    "Replay",
    "State",
    "Supervisor",
    "Timing",
    "Watchdog",
    "connect",
    "read_log",
    "replay_log",
    "run_loop",
    "shipped_policies",
]
