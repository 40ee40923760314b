"""Write a policy as one ONNX file, for hardware and for any other use without this package.

  drillrig export lqg --out lqg.onnx                 # a law: constant, z_torque, lqg, jump_ease_estimated
  drillrig export z_torque --sensors state           # made for other sensors
  drillrig export lqg --rig my_rig --delay 2         # designed for a rig of your own, with instruments that late
  drillrig export ppo --out ppo.onnx                 # a trained agent (in a clone), or the folder of a run

The file takes the measured values in their physical units, an input of shape (batch, 1) a channel, named as
the channel, and gives the rate of the speed reference (rad/s^2) and the reference at the end of the control step
(rad/s). Scaling, clipping, memory, slew limit and range are inside; what else a user must know is in its
metadata, as JSON: see docs/hardware.md. The export plays recorded episodes through policy and file, prints the
largest difference, and fails where it is not below 1e-6 of the slew limit. Networks are computed in double
precision for that; what single precision makes of them, as PyTorch runs them, is told too.
"""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path
from typing import Any

import numpy as np

from drillrig_env.allowed import COUNT, Allowed
from drillrig_env.command_line import Failed, Parser, command
from drillrig_env.env.core import EpisodeBatch
from drillrig_env.env.generators import first_uniforms
from drillrig_env.env.sensors import LONGEST_DELAY, SENSORS
from drillrig_env.env.task import Task
from drillrig_env.extras import missing
from drillrig_env.files import check_writable_file
from drillrig_env.flags import add_friction_argument, add_rig_argument, of_kind
from drillrig_env.parameters import refuse
from drillrig_env.policy import find_policy
from drillrig_env.seeds import VALIDATION_SEEDS

TOLERANCE = 1e-6
"""Largest difference from the policy that a file may have, as a share of the slew limit."""


@command
def main(arguments: Sequence[str] | None = None, prog: str = "drillrig export") -> None:
    """Parse the command line, export, and compare."""
    parser = Parser(prog=prog, description=__doc__)
    add = parser.add_argument
    add("policy", help="a law, a shipped agent or a run folder")
    add("--out", type=Path, help="file to write (default: POLICY.onnx)")
    add("--sensors", choices=tuple(SENSORS), help="of a law (default: surface where these do, else state)")
    add_rig_argument(parser)
    add_friction_argument(parser, "the chapter's, in the scales of the rig")
    add(
        "--delay",
        type=of_kind(Allowed(0, LONGEST_DELAY, whole=True)),
        help="of the instruments, for lqg; control steps",
    )
    add("--episodes", type=of_kind(COUNT), default=20, help="episodes for the comparison (default: 20)")
    chosen = parser.parse_args(arguments)
    out = chosen.out or Path(f"{Path(chosen.policy).name}.onnx")
    check_writable_file(out)
    try:
        made = {
            name: getattr(chosen, name) for name in ("rig", "friction", "delay") if getattr(chosen, name) is not None
        }
        policy = policy_to_export(chosen.policy, chosen.sensors, **made)
        export(policy, out, Path(chosen.policy).name)
    except ValueError as error:
        parser.error(error)
    except ImportError as error:
        raise Failed(str(error)) from error
    difference = largest_difference(policy, out, chosen.episodes)
    print(f"{out}: {out.stat().st_size / 1024:.0f} kB")
    print(f"largest difference from the policy over {chosen.episodes} episodes: {difference:.1e} of the slew limit")
    if hasattr(policy, "predict_in_double"):
        rounding = largest_difference(policy, out, chosen.episodes, single=True)
        print(f"and from what it does in single precision, whose rounding is its own: {rounding:.1e}")
    if not difference < TOLERANCE:
        raise Failed(f"the difference is not below {TOLERANCE:g} of the slew limit; the file is not to be trusted")


def policy_to_export(name: Any, sensors: str | None = None, **made: Any) -> Any:
    """A policy with the slew limit that it was made for; of a law, for `sensors`, or surface where these do.

    `made` is what else a law is made for: `rig`, `friction`, and `delay` in control steps. `ValueError` where there is
    no such policy, it does not work from these sensors, or it is a trained agent, which is made for what it was
    trained in.
    """
    source = find_policy(name)
    try:
        policy = source.make(sensors=sensors or "surface", **made)
    except ValueError:
        if sensors is not None:
            raise
        sensors = "state"
        policy = source.make(sensors=sensors, **made)
    if hasattr(policy, "predict_in_double") and (given := [*made, *(["sensors"] if sensors else [])]):
        raise refuse(
            str(name), "what it is to be made for", ", ".join(given), "", "nothing: that is as in its training"
        )
    task = getattr(policy, "task", None)
    if task is None:
        return policy
    return source.make(sensors=sensors or "surface", slew_limit=task.slew_limit, **made)


def export(policy: Any, path: Path, name: str = "") -> None:
    """Write a policy as an ONNX file. `ValueError` for one that cannot be exported; `ImportError` without onnx."""
    try:
        from drillrig_env.deploy.build import export_policy
    except ModuleNotFoundError as error:
        raise missing("the export", "onnx", "export") from error
    export_policy(policy, path, name)


def largest_difference(
    policy: Any, path: Path, episodes: int = 20, steps: int | None = None, single: bool = False
) -> float:
    """The largest difference between a file's rates and its policy's over recorded episodes, over the slew limit.

    Both are shown the same measurements, step by step, the file in physical units; each keeps its own memory. `steps`
    is how many control steps of each episode are played; None: all. A network is computed in double precision, or with
    `single` as `predict` does it, in single precision: then the difference is for the most part the rounding of that.
    """
    from drillrig_env.deploy.policy_file import PolicyFile

    exported, task = PolicyFile(path), Task.of(policy.task, drive=policy.drive)
    act = policy.predict if single else getattr(policy, "predict_in_double", policy.predict)
    core = EpisodeBatch(episodes, task)
    core.reset(np.arange(episodes), first_uniforms(VALIDATION_SEEDS.start, episodes))
    state: Any = None
    largest = 0.0
    for _ in range(core.steps if steps is None else steps):
        rates, _ = exported.step(core.sensors.values(core.observations))
        actions, state = act(core.observations, state)
        largest = max(largest, float(np.abs(rates / core.slew_limit - actions[:, 0]).max()))
        core.step(np.ascontiguousarray(actions, dtype=np.float32))
    return largest


if __name__ == "__main__":
    raise SystemExit(main())
