"""Let a policy's file control a rig that is connected: a real one, or a twin of `drillrig twin`.

  drillrig run ppo_surface --connect 127.0.0.1:5025 --log run.csv
  drillrig run lqg --connect 127.0.0.1:5025 --shadow --log shadow.csv     # computes and logs, and commands nothing
  drillrig run mine.onnx --connect opc.tcp://rig.lab:4840 --token-file token --target 3 --highest-reference 4

It begins from the speed reference that the drive has. What the supervisor does is printed, and why; docs/hardware.md
tells of its states and limits. Ctrl-C, or SIGTERM, ramps the rig down to a stand and gives it back; a second one ends
at once and leaves the rig to its own watchdog. The log is a record for `drillrig calibrate`, and `drillrig replay`
plays it again. The exit code is 1 at the end where the log could not be written any more, the rig being controlled on,
and where the time is over while the policy does not control the rig: in hold, fallback, ramp or stopped.
"""

from __future__ import annotations

import sys
from collections.abc import Sequence
from contextlib import closing, suppress
from typing import Any

from drillrig_env.allowed import POSITIVE, File
from drillrig_env.command_line import Failed, Parser, command
from drillrig_env.deploy.connection import Connection, compare, connect
from drillrig_env.deploy.limits import Limits
from drillrig_env.deploy.log import check_log
from drillrig_env.deploy.loop import Operator, run_loop
from drillrig_env.deploy.policy_file import shipped_policies
from drillrig_env.deploy.stopping import Stopping, asked_to_stop
from drillrig_env.deploy.supervisor import State, Supervisor
from drillrig_env.deploy.token import read_token
from drillrig_env.flags import add_fields, given_fields, of_kind

_ENDLESS = 2**62


@command
def main(arguments: Sequence[str] | None = None, prog: str = "drillrig run") -> None:
    """Parse the command line, connect, and control until the time is over or somebody stops it."""
    parser = _parser(prog)
    chosen = parser.parse_args(arguments)
    if chosen.log is not None:
        check_log(chosen.log)
        if chosen.log.is_file():  # what a rig did cannot be computed again
            parser.error(f"--log {chosen.log} is there already; allowed: the name of a new file")
    try:
        token = "" if chosen.token_file is None else read_token(chosen.token_file)
        supervisor = Supervisor(chosen.policy)
        if given := given_fields(chosen, Limits):
            supervisor = Supervisor(supervisor.controller, Limits.for_policy(supervisor.controller.file.about, **given))
        rig = connect(chosen.connect, token)
    except ValueError as error:
        parser.error(str(error))
    except ImportError as error:
        raise Failed(str(error)) from error
    with closing(rig):
        try:
            warnings = compare(supervisor, rig)
        except ValueError as error:
            raise Failed(str(error)) from error
        for warning in warnings:
            _say(f"mind: {warning}")
        _control(supervisor, rig, chosen)


def _parser(prog: str) -> Parser:
    parser = Parser(prog=prog, description=__doc__)
    add = parser.add_argument
    add("policy", help=f"a file, or one that comes with the package: {', '.join(shipped_policies())}")
    add("--connect", required=True, metavar="ADDRESS", help="HOST:PORT, or opc.tcp://HOST:PORT")
    add("--token-file", type=of_kind(File()), metavar="FILE", help="whose first line is the rig's token")
    add("--target", type=of_kind(POSITIVE, "rad/s"), metavar="RAD/S", help="speed (default: what the rig's side wants)")
    add("--duration", type=of_kind(POSITIVE, "s"), metavar="S", help="after which the rig is given back as it turns "
        "then (default: until Ctrl-C)")  # fmt: skip
    add("--log", type=of_kind(File()), metavar="FILE", help="a CSV file with every control step (default: none)")
    add("--shadow", action="store_true", help="compute and log what would be done, and command nothing")
    limits = parser.add_argument_group("limits, whose defaults here are the chapter rig's; else by the policy's rig")
    add_fields(limits, Limits, skip=("plausible",))
    return parser


def _control(supervisor: Supervisor, rig: Connection, chosen: Any) -> None:
    """Run the loop, and say how it went."""
    steps = _ENDLESS if chosen.duration is None else max(1, round(chosen.duration / rig.period))
    target = rig.target if chosen.target is None else chosen.target
    with asked_to_stop() as stopping:
        try:
            hand = _Hand(supervisor, stopping, chosen.shadow)
            timing = run_loop(
                supervisor,
                rig,
                reference=rig.first_reference if chosen.shadow else rig.arm,
                target=target,
                steps=steps,
                log=chosen.log,
                operator=hand,
                shadow=rig.drive_reference if chosen.shadow else None,
                rehearse=rig.speed == 1.0 and not rig.waits,
                clock=rig.clock,
                sleep=rig.sleep,
            )
        except ConnectionError:
            raise
        except (ValueError, OSError) as error:  # a target that the policy does not take, a log that cannot be begun
            rig.release()
            raise Failed(str(error)) from error
        finally:
            if chosen.log is not None and chosen.log.is_file():
                _say(f"log: {chosen.log.resolve()}")
        rig.release()  # not where the loop ended otherwise: the watchdog is to have the rig then
    hand.tell()
    _say(f"{supervisor.state.value} at {supervisor.reference:.4g} rad/s after {supervisor.time:.6g} s")
    if rig.speed == 1.0 and not rig.waits:
        _say(str(timing))
    if failed := supervisor.events.of("log"):
        raise Failed(failed[0].reason)
    if stopping.asked:
        raise stopping.as_exception()
    if supervisor.state is not State.NORMAL:
        raise Failed(f"the time is over in the state {supervisor.state.value}: the policy does not control the rig")


class _Hand:
    """The operator's hand on the loop: prints what happens, and stops the rig when somebody asks for it."""

    def __init__(self, supervisor: Supervisor, stopping: Stopping, shadow: bool) -> None:
        self.supervisor, self.stopping, self.shadow = supervisor, stopping, shadow
        self._told, self._stops = 0, False

    def __call__(self, _step: int) -> Operator | None:
        self.tell()
        if not self.stopping.asked:
            return None
        if self.shadow or (self._stops and self.supervisor.state is State.STOPPED):
            return Operator(leave=True)
        if self._stops:
            return None
        self._stops = True
        _say(f"stops: down at {self.supervisor.limits.ramp:g} rad/s^2; Ctrl-C again leaves the rig to its watchdog")
        return Operator(stop=self.stopping.asked)

    def tell(self) -> None:
        """Print the events that are new."""
        events = self.supervisor.events.kept
        for event in events[self._told :]:
            _say(str(event))
        self._told = len(events)


def _say(line: str) -> None:
    """Print a line; a terminal that has gone stops no rig."""
    with suppress(OSError, ValueError):
        print(line, file=sys.stdout, flush=True)


if __name__ == "__main__":
    raise SystemExit(main())
