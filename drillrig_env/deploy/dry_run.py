"""A rig of the environment in the place of hardware, and a clock that does not wait: to try all but the wires.

  python -m drillrig_env.deploy.dry_run lqg --rigs 60         # how many are calmed, what the supervisor had to do
  python -m drillrig_env.deploy.dry_run lqg --real --steps 150    # at the system's time: how punctual it is

It needs the whole package, unlike the rest of this folder.
"""

from __future__ import annotations

import time
from collections import Counter
from collections.abc import Sequence
from typing import Any

import numpy as np

from drillrig_env.allowed import COUNT
from drillrig_env.command_line import Parser, command
from drillrig_env.deploy.loop import run_loop
from drillrig_env.deploy.supervisor import Supervisor
from drillrig_env.env.core import EpisodeBatch
from drillrig_env.env.generators import first_uniforms
from drillrig_env.flags import of_kind
from drillrig_env.seeds import VALIDATION_SEEDS


class DryRig:
    """A rig of an episode with the instruments of the surface, noise and delay included; `Hardware` for `run_loop`.

    `rig` is a number that draws load and start, as a seed does; `task` has arguments of the environment, such as
    `rig=` and `sensors=`. `steps` is how many control steps it has done.
    """

    def __init__(self, number: int = 0, **task: Any) -> None:
        self.core = EpisodeBatch(1, **{"sensors": "surface", **task})
        self.core.reset(np.arange(1), first_uniforms(VALIDATION_SEEDS.start + number, 1))
        self.steps = 0

    @property
    def reference(self) -> float:
        """The speed reference that the drive has, rad/s."""
        return float(self.core.episodes["speed_reference"][0])

    @property
    def target(self) -> float:
        """The speed target of the episode, rad/s."""
        return float(self.core.episodes["speed_target"][0])

    @property
    def bit_speed_deviation(self) -> float:
        """The running deviation of the bit speed, rad/s: how much it sticks and slips, which no surface shows."""
        return float(np.sqrt(self.core.episodes["variance"][0]))

    def measure(self) -> dict[str, Any]:
        """What the instruments show, by channel."""
        seen = self.core.sensors.values(self.core.observations)
        own = ("speed_reference", "speed_target")
        return {
            name: float(value[0])
            for name, value in seen.items()
            if name not in own and not name.endswith(("_mean", "_deviation"))
        }

    def command(self, speed_reference: float) -> None:
        """Give the drive a speed reference (rad/s), and let a control step pass."""
        largest = self.core.slew_limit * self.core.control_period
        action = np.clip((speed_reference - self.reference) / largest, -1.0, 1.0)
        self.core.step(np.full((1, 1), action, np.float32))
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
def main(arguments: Sequence[str] | None = None, prog: str = "python -m drillrig_env.deploy.dry_run") -> None:
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
            clock=clock,
            sleep=sleep,
        )
        kinds.update(event.kind for event in supervisor.events.kept if event.kind != "start")
        calm += bool(rig.core.mitigated[0])
    print(f"{chosen.policy}: {calm} of {chosen.rigs} rigs calm at the end; events: {dict(kinds) or 'none'}")
    if chosen.real:
        print(timing)


if __name__ == "__main__":
    raise SystemExit(main())
