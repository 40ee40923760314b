"""A policy on hardware: one file, and what runs it at the control period with NumPy and onnxruntime alone.

See docs/hardware.md. Nothing here loads PyTorch, Stable-Baselines3 or Numba; only `export`, `ship` and their `build`
and `graph`, which make the files, need more.
"""

from drillrig_env.deploy.controller import Controller
from drillrig_env.deploy.policy_file import PolicyFile, shipped_policies

__all__ = ["Controller", "PolicyFile", "shipped_policies"]
