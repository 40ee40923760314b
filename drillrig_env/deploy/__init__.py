"""A policy on hardware: one file, and what runs it at the control period with NumPy and onnxruntime alone.

See docs/hardware.md. Nothing here loads PyTorch, Stable-Baselines3 or Numba; only `export`, `ship` and their `build`
and `graph`, which make the files, need more.
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
