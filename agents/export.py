"""Write a trained agent, or a law, as one ONNX file, for use without PyTorch and Stable-Baselines3.

    python -m agents.export ppo --out policy.onnx
    python -m agents.export runs/ppo_1 --out policy.onnx

It is `drillrig export` by its former name; see `drillrig_env.deploy.export` and docs/hardware.md.
"""

from __future__ import annotations

from collections.abc import Sequence

from drillrig_env.deploy import export as shared
from drillrig_env.deploy.export import TOLERANCE, export, largest_difference
from drillrig_env.deploy.policy_file import PolicyFile as ExportedPolicy

__all__ = ["COMMAND", "EXAMPLE", "TOLERANCE", "ExportedPolicy", "export", "largest_difference", "main"]

COMMAND = "python -m agents.export"

EXAMPLE = """
import json

import numpy as np
import onnxruntime

session = onnxruntime.InferenceSession("policy.onnx")
told = session.get_modelmeta().custom_metadata_map
about = {name: json.loads(told[name]) for name in ("channels", "memory", "control_period")}
speed_reference, speed_target = 0.0, 3.0  # rad/s
memory = {m["name"]: np.zeros((1, m["width"]), m["type"]) for m in about["memory"]}


def measured(name):  # ask your rig here, each about["control_period"]; the unit is in about["channels"]
    return {"speed_reference": speed_reference, "speed_target": speed_target}.get(name, 0.0)


for _ in range(50):
    values = {c["name"]: np.array([[measured(c["name"])]], np.float64) for c in about["channels"]}
    rate, reference, *remembered = session.run(None, {**values, **memory})
    memory = dict(zip(memory, remembered))
    speed_reference = float(reference[0, 0])  # give this to your drive
print(f"speed reference: {speed_reference:.3f} rad/s")
"""
"""A program that runs an exported policy with onnxruntime alone."""


def main(arguments: Sequence[str] | None = None) -> int:
    """What `drillrig export` does, by the former name."""
    return shared.main(arguments, prog=COMMAND)


if __name__ == "__main__":
    raise SystemExit(main())
