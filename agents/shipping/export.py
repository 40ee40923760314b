"""Export an agent as one ONNX file, for use without PyTorch, Stable-Baselines3 and this package.

    python -m agents.shipping.export ppo --out policy.onnx
    python -m agents.shipping.export runs/ppo_1 --out policy.onnx

The file takes the measured values in their physical units, an input of shape (batch, 1) a channel,
named as the channel, and gives the rate at which to move the speed reference, in rad/s^2. Scaling,
clipping and the slew limit are inside; channels, units and versions are in its metadata. An agent
with a frame stack has one more input and output, its memory. The export runs recorded episodes through
both, prints the largest difference and fails where it is above 5e-6 of the slew limit.
"""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path
from typing import Any

import numpy as np

from agents.policy.agent import Agent
from agents.policy.run_folder import find_run, load_policy, shipped
from agents.shipping.exported import ExportedPolicy
from drillrig_env.allowed import COUNT
from drillrig_env.command_line import Failed, Parser, command
from drillrig_env.env.core import EpisodeBatch
from drillrig_env.env.generators import first_uniforms
from drillrig_env.extras import missing
from drillrig_env.files import check_writable_file, written_whole
from drillrig_env.flags import of_kind
from drillrig_env.seeds import VALIDATION_SEEDS

COMMAND = "python -m agents.shipping.export"
TOLERANCE = 5e-6
"""Largest difference from the agent that an export may have, as a share of the slew limit."""

EXAMPLE = """
import json

import numpy as np
import onnxruntime

session = onnxruntime.InferenceSession("policy.onnx")
about = session.get_modelmeta().custom_metadata_map
period = float(about["control_period"].split()[0])  # s, between two calls
speed_reference, speed_target = 0.0, 3.0  # rad/s
memory = {i.name: np.zeros((1, i.shape[1]), np.float32) for i in session.get_inputs() if i.name == "frames"}


def measured(name):  # ask your rig here; the unit is in about["channels"]
    return {"speed_reference": speed_reference, "speed_target": speed_target}.get(name, 0.0)


for _ in range(50):
    values = {c["name"]: np.array([[measured(c["name"])]], np.float64) for c in json.loads(about["channels"])}
    rate, *remembered = session.run(None, {**values, **memory})
    memory = dict(zip(memory, remembered))
    speed_reference += period * float(rate[0, 0])  # give this to your drive
print(f"speed reference: {speed_reference:.3f} rad/s")
"""
"""A program that runs an exported agent with onnxruntime alone."""


@command
def main(arguments: Sequence[str] | None = None) -> None:
    """Parse the command line, export, and compare."""
    parser = Parser(prog=COMMAND, description=__doc__, epilog=f"how to run it with onnxruntime alone:\n{EXAMPLE}")
    names = ", ".join(shipped()) or "none yet"
    parser.add_argument("agent", help=f"a shipped agent ({names}) or a run folder")
    parser.add_argument("--out", type=Path, default=Path("policy.onnx"), help="file to write (default: policy.onnx)")
    parser.add_argument("--episodes", type=of_kind(COUNT), default=20, help="episodes for the comparison (default: 20)")
    chosen = parser.parse_args(arguments)
    check_writable_file(chosen.out)
    try:
        agent = load_policy(find_run(chosen.agent))
        export(agent, chosen.out)
    except (ValueError, ImportError) as error:
        parser.error(str(error))
    difference = largest_difference(agent, chosen.out, chosen.episodes)
    print(f"{chosen.out}: {chosen.out.stat().st_size / 1024:.0f} kB")
    print(f"largest difference from the agent over {chosen.episodes} episodes: {difference:.1e} of the slew limit")
    if not difference < TOLERANCE:
        raise Failed(f"the difference is not below {TOLERANCE:g} of the slew limit; the file is not to be trusted")


def export(agent: Agent, path: Path) -> None:
    """Write an agent as an ONNX file. `ValueError` for a network that cannot be exported."""
    try:
        import onnx

        from agents.shipping.onnx_graph import build
    except ImportError as error:
        raise missing("the export", "onnx", "export") from error
    model = build(agent)
    with written_whole(path) as new:
        onnx.save(model, new)


def largest_difference(agent: Agent, path: Path, episodes: int = 20) -> float:
    """The largest difference between the file's output and the agent's over recorded episodes, over the slew limit.

    Both are shown the same measurements, step by step, the file in physical units; each keeps its own memory.
    """
    exported = ExportedPolicy(path)
    core = EpisodeBatch(episodes, **agent.environment)
    core.reset(np.arange(episodes), first_uniforms(VALIDATION_SEEDS.start, episodes))
    state: Any = None
    largest = 0.0
    for _ in range(core.steps):
        rates = exported.rates(core.sensors.values(core.observations))
        actions, state = agent.predict(core.observations, state)
        largest = max(largest, float(np.abs(rates / core.slew_limit - actions).max()))
        core.step(np.ascontiguousarray(actions, dtype=np.float32))
    return largest


if __name__ == "__main__":
    raise SystemExit(main())
