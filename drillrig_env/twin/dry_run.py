"""A rig of the environment in the place of hardware, and a clock that does not wait: to try all but the wires.

  python -m drillrig_env.twin.dry_run lqg --rigs 60         # how many are calmed, what the supervisor had to do
  python -m drillrig_env.twin.dry_run lqg --real --steps 150    # at the system's time: how punctual it is

Both keep to the names of `drillrig_env.deploy`; behind wires a rig is `drillrig twin`.
"""

from __future__ import annotations

import time
from collections import Counter
from collections.abc import Sequence
from typing import Any

from drillrig_env.allowed import COUNT
from drillrig_env.command_line import Parser, command
from drillrig_env.deploy.loop import run_loop
from drillrig_env.deploy.supervisor import Supervisor
from drillrig_env.flags import of_kind
from drillrig_env.seeds import VALIDATION_SEEDS
from drillrig_env.twin.rig import PARTS, SimulatedRig


class DryRig(SimulatedRig):
    """A rig of an episode with the instruments of the surface, noise and delay included; `Hardware` for `run_loop`.

    `number` draws load and start, as a seed does; `settings` are those of `SimulatedRig`, such as `sensors=` and
    `rig=`. `steps` is how many control steps it has done.
    """

    def __init__(self, number: int = 0, **settings: Any) -> None:
        super().__init__(VALIDATION_SEEDS.start + number, **settings)
        self.steps = 0

    def command(self, speed_reference: float) -> None:
        """Give the drive a speed reference (rad/s), and let a control step pass. `speed_reference` is held over it."""
        self.reference = speed_reference
        for _ in range(PARTS):
            self.advance()
        self.steps += 1


class Instant:
    """A clock that passes only while somebody sleeps: `run_loop(..., clock=instant, sleep=instant.sleep)`."""

    def __init__(self) -> None:
        self.now = 0.0

    def __call__(self) -> float:
        """The time, s."""
        return self.now

    def sleep(self, seconds: float) -> None:
        """Let `seconds` pass at once."""
        self.now += seconds


@command
def main(arguments: Sequence[str] | None = None, prog: str = "python -m drillrig_env.twin.dry_run") -> None:
    """Parse the command line, run a supervised policy on simulated rigs, and say what happened."""
    parser = Parser(prog=prog, description=__doc__)
    parser.add_argument("policy", help="a shipped policy from the surface, or a file of one")
    parser.add_argument("--rigs", type=of_kind(COUNT), default=1, help="how many, one after another (default: 1)")
    parser.add_argument("--steps", type=of_kind(COUNT), default=600, help="control steps of each (default: 600)")
    parser.add_argument("--real", action="store_true", help="keep the system's time")
    chosen = parser.parse_args(arguments)
    kinds: Counter[str] = Counter()
    calm = 0
    for number in range(chosen.rigs):
        try:
            supervisor = Supervisor(chosen.policy)
        except ValueError as error:
            parser.error(error)
        rig, instant = DryRig(number), Instant()
        clock, sleep = (time.perf_counter, time.sleep) if chosen.real else (instant, instant.sleep)
        timing = run_loop(
            supervisor,
            rig,
            reference=rig.reference,
            target=rig.target,
            steps=chosen.steps,
            rehearse=chosen.real,
            clock=clock,
            sleep=sleep,
        )
        kinds.update(event.kind for event in supervisor.events.kept if event.kind != "start")
        calm += rig.is_mitigated
    print(f"{chosen.policy}: {calm} of {chosen.rigs} rigs calm at the end; events: {dict(kinds) or 'none'}")
    if chosen.real:
        print(timing)


if __name__ == "__main__":
    raise SystemExit(main())
