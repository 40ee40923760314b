"""Replay the log of a controller: the same measurements give the same commands, to the last bit.

  drillrig replay run.csv                       # the policy that the log names, if it is a shipped one
  drillrig replay run.csv --policy mine.onnx    # a file of one's own; --other: another policy, and how far it differs

It prints how many commands are the same and what a control step took here, and ends with 1 where a command differs.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path
from time import perf_counter
from typing import Any

from drillrig_env.command_line import Failed, Parser, command
from drillrig_env.deploy.controller import Controller
from drillrig_env.deploy.limits import Limits
from drillrig_env.deploy.log import read_log
from drillrig_env.deploy.loop import Operator, Timing, serve
from drillrig_env.deploy.supervisor import Supervisor


@dataclass(frozen=True)
class Replay:
    """How a replay went: steps, those that differ, the first of them (None: none), by how much (rad/s) at most.

    These are `steps`, `differing`, `first` and `largest`; `timing` says how long steps took to be played again.
    """

    steps: int
    differing: int
    first: int | None
    largest: float
    timing: Timing


def replay_log(log: str | Path, policy: str | Path | None = None, other: bool = False) -> Replay:
    """Play a log through its policy again, or with `other` through another one.

    Raises `ValueError` for a log that is damaged or empty, and for a policy whose digest is not the log's.
    """
    about, rows = read_log(log)
    controller = Controller(policy or about["policy"])
    if not other and controller.file.sha256 != about["sha256"]:
        raise ValueError(
            f"{log} was written with another file of {about['policy']}: {about['file']} with the SHA-256 "
            f"{about['sha256'][:12]}..., not {controller.file.sha256[:12]}...; give that file, or --other"
        )
    supervisor = Supervisor(controller, _limits(about["limits"]))
    supervisor.start(about["reference"], about["target"], about["measurements"], about["time"])
    differing, first, largest, steps, timing = 0, None, 0.0, 0, Timing()
    for step, row in enumerate(rows):
        kind, _, reason = row.operator.partition(": ")
        begin = perf_counter()
        serve(supervisor, Operator(reason if kind == "stop" else "", kind == "restart", row.target), row.measured)
        given = supervisor.step(row.measured, row.time, row.ages, row.told)
        timing.took.append(perf_counter() - begin)
        timing.late.append(0.0)
        steps += 1
        if given != row.command:
            differing += 1
            first = step if first is None else first
            largest = max(largest, abs(given - row.command))
    if steps == 0:
        raise ValueError(f"{log} has no control step")
    return Replay(steps, differing, first, largest, timing)


def _limits(fields: dict[str, Any]) -> Limits:
    return Limits(**fields)


@command
def main(arguments: Sequence[str] | None = None, prog: str = "drillrig replay") -> None:
    """Parse the command line, replay, and say how it went."""
    parser = Parser(prog=prog, description=__doc__)
    parser.add_argument("log", type=Path, help="a log of run_loop")
    parser.add_argument("--policy", help="a shipped policy or a file (default: the log's)")
    parser.add_argument("--other", action="store_true", help="take a policy that is not the log's")
    chosen = parser.parse_args(arguments)
    try:
        found = replay_log(chosen.log, chosen.policy, chosen.other)
    except (ValueError, TypeError) as error:
        parser.error(error)
    print(f"{chosen.log}: {found.steps - found.differing} of {found.steps} commands are the same to the last bit")
    typical, longest = (found.timing.percentile(share)[1] for share in (50.0, 99.0))
    print(f"a control step took {1e3 * typical:.3f} ms in the median, {1e3 * longest:.3f} ms in 99 % here")
    if found.differing:
        sentence = f"the first that differs is step {found.first}, the largest difference {found.largest:.3g} rad/s"
        if not chosen.other:
            raise Failed(sentence)
        print(sentence)


if __name__ == "__main__":
    raise SystemExit(main())
