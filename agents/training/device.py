"""The device that PyTorch trains on: the processor, or a graphics card where there is one."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

import torch

from drillrig_env.evaluation.provenance import provenance
from drillrig_env.parameters import refuse

DEVICES = ("cpu", "cuda", "mps")
"""Names of devices: the processor, NVIDIA's or AMD's cards, Apple's."""


def device_of(config: Mapping[str, Any]) -> torch.device:
    """The device of a run. `ValueError` where this machine, or this build of PyTorch, has none of the kind."""
    there = {"cpu": True, "cuda": torch.cuda.is_available(), "mps": torch.backends.mps.is_available()}
    name = config.get("device", "cpu")
    if not there[name]:
        found = ", ".join(one for one, is_there in there.items() if is_there)
        raise refuse("Training", "device", name, "", f"what PyTorch finds here: {found}")
    return torch.device(name)


def provenance_on(device: torch.device) -> dict[str, Any]:
    """The `provenance` of a training on a device: the machine with its graphics card, where that trains."""
    made = provenance()
    card = f", {torch.cuda.get_device_name(device)}" if device.type == "cuda" else ""
    return {**made, "machine": made["machine"] + card}
