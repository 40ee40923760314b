"""Whether a policy's file mitigates over a wire what it mitigates in the arena, and what loss and jitter cost.

    python -m benchmarks.over_the_wire                 # ppo over 200 rigs; writes docs/over_the_wire.md
    python -m benchmarks.over_the_wire --policy lqg --sensors surface --rigs 50 --output lqg.md

Every rig of the suite `default` is played three times or more: in the arena, where the file acts on observations of the
environment, and over the line protocol with the file under a supervisor, the twins in another process and their time at
most `--speed` times the system's. A twin's time waits for its client, so that what else the computer does counts for
nothing. Over the wire a policy begins 0.2 s later, with the first measurements that have come.

Loss and jitter hold for measurements and for commands alike, in the rig's time. With the watchdog as it is, three
silent control periods end the policy's turn; how often they did is told, and how it goes with one that bears ten.
"""

from __future__ import annotations

import multiprocessing
import time
from collections.abc import Sequence
from contextlib import closing, suppress
from dataclasses import dataclass, field
from multiprocessing.connection import Connection
from pathlib import Path
from typing import Any

import numpy as np
import numpy.typing as npt

from benchmarks.line_of_twins import Sort, serve
from benchmarks.measure import kept, note
from drillrig_env import markdown
from drillrig_env.allowed import COUNT, NOT_NEGATIVE, POSITIVE, SHARE, File
from drillrig_env.command_line import Parser, command, deaf_to_interrupt
from drillrig_env.deploy import Limits, Supervisor, run_loop
from drillrig_env.deploy.line_rig import LineRig
from drillrig_env.deploy.policy_file import PolicyFile
from drillrig_env.env.core import EpisodeBatch
from drillrig_env.env.generators import first_uniforms
from drillrig_env.evaluation.provenance import provenance, when_and_where
from drillrig_env.evaluation.statistics import Estimate, difference, rate
from drillrig_env.evaluation.suites import STICKING
from drillrig_env.files import write_text
from drillrig_env.flags import of_kind
from drillrig_env.scales import DURATION
from drillrig_env.seeds import EVALUATION_SEEDS

PAGE = Path(__file__).parents[1] / "docs" / "over_the_wire.md"
_EXACT = 2**31  # control steps that an instrument without noise may stand still
_LAST = 0.2  # s before which nothing can be commanded


@dataclass
class Played:
    """What became of the rigs so far under one sort of wire: mitigated or not, and how many the watchdog took."""

    sort: Sort
    mitigated: list[bool] = field(default_factory=list)
    tripped: int = 0
    seconds: float = 0.0  # of the system's time
    simulated: float = 0.0  # s


def arena(policy: str, sensors: str, rigs: int) -> npt.NDArray[np.bool_]:
    """Which rigs a policy's file mitigates in the environment, (rigs,)."""
    core, file = EpisodeBatch(rigs, sensors=sensors), PolicyFile(policy)
    core.reset(np.arange(rigs), first_uniforms(EVALUATION_SEEDS.start, rigs), STICKING)
    for _ in range(core.steps):
        rates, _ = file.step(core.sensors.values(core.observations))
        core.step((rates[:, None] / core.slew_limit).astype(np.float32))
    return core.mitigated


def over_the_wire(policy: str, sensors: str, sort: Sort, rigs: int, speed: float, played: Played) -> None:
    """Play the rigs over the line, one after another; what comes of each is added to `played` at once."""
    context = multiprocessing.get_context("spawn")
    here, there = context.Pipe()
    process = context.Process(target=serve, args=(there, sensors, sort, rigs, speed), daemon=True)
    with deaf_to_interrupt():
        process.start()
    there.close()
    try:
        for number in range(rigs):
            begin = time.perf_counter()
            played.tripped += not _play(policy, sensors, here.recv())
            mitigated, simulated = _verdict(here)
            played.mitigated.append(mitigated)
            played.simulated += simulated
            played.seconds += time.perf_counter() - begin
            if (number + 1) % 10 == 0:
                note(f"{sort.words}: {number + 1} of {rigs} rigs, {sum(played.mitigated)} mitigated")
    except EOFError:
        raise RuntimeError(f"the twins' process ended with status {process.exitcode}") from None
    finally:
        process.kill()
        process.join()


def _play(policy: str, sensors: str, address: str) -> bool:
    """Let a policy have a rig for an episode; whether it had it to the end."""
    with closing(LineRig(address)) as rig:
        supervisor = Supervisor(policy)
        if sensors == "state":  # whose instruments are exact
            about = supervisor.controller.file.about
            supervisor = Supervisor(supervisor.controller, Limits.for_policy(about, frozen=_EXACT))
        duration = DURATION
        steps = round((duration - _LAST) / rig.period)
        with suppress(ConnectionError):  # the watchdog has the rig
            run_loop(supervisor, rig, reference=rig.arm, target=rig.target, steps=steps, clock=rig.clock,
                     sleep=rig.sleep)  # fmt: skip
            rig.sleep(duration - rig.clock())
            return True
    with closing(LineRig(address)) as watcher:
        watcher.sleep(duration - watcher.clock())
    return False


def _verdict(twins: Connection) -> tuple[bool, float]:
    twins.send("verdict")
    mitigated, simulated = twins.recv()
    return bool(mitigated), float(simulated)


@command
def main(arguments: Sequence[str] | None = None) -> None:
    """Measure and write the page."""
    parser = Parser(prog="python -m benchmarks.over_the_wire", description=__doc__)
    add = parser.add_argument
    add("--policy", default="ppo", help="a shipped policy, or a file (default: ppo)")
    add("--sensors", default="state", help="of the policy (default: state)")
    add("--rigs", type=of_kind(COUNT), default=200, help="(default: 200)")
    add("--speed", type=of_kind(POSITIVE), default=50.0, help="times real time at most (default: 50)")
    add("--loss", type=of_kind(SHARE), default=0.1, help="share of the messages (default: 0.1)")
    add("--jitter", type=of_kind(NOT_NEGATIVE, "s"), default=0.05, help="up to which each is late, s (default: 0.05)")
    add("--seed", type=of_kind(COUNT), default=1, help="of losses and jitter (default: 1)")
    add("--output", type=of_kind(File()), default=PAGE, help="the page (default: docs/over_the_wire.md)")
    chosen = parser.parse_args(arguments)
    lossy = Sort(chosen.loss, chosen.jitter, 3, chosen.seed)
    sorts = [Sort(), lossy, Sort(chosen.loss, chosen.jitter, 10, chosen.seed)]
    found = [Played(sort) for sort in sorts]
    try:
        alone = arena(chosen.policy, chosen.sensors, chosen.rigs)
    except ValueError as error:
        parser.error(str(error))

    def report() -> None:
        write_text(chosen.output, page(chosen, alone, found))

    with kept(chosen.output, report):
        for played in found:
            over_the_wire(chosen.policy, chosen.sensors, played.sort, chosen.rigs, chosen.speed, played)
            report()


def page(chosen: Any, alone: npt.NDArray[np.bool_], found: Sequence[Played]) -> str:
    """The page, of as many rigs as have been played."""
    rows = [("arena", *_shown(rate(alone)), "", "", "", "")]
    for played in found:
        if count := len(played.mitigated):
            over = np.array(played.mitigated)
            pace = f"{played.simulated / played.seconds:.0f}"
            cells = (*_shown(rate(over)), *_shown(difference(over, alone[:count])), str(played.tripped), pace)
            rows.append((played.sort.words, *cells))
    headings = (
        "wire",
        "mitigated",
        "95 %",
        "less the arena's",
        "95 %, paired",
        "taken by watchdog",
        "times real time",
    )
    words = f"python -m benchmarks.over_the_wire --policy {chosen.policy} --sensors {chosen.sensors}"
    numbers = f"--rigs {chosen.rigs} --speed {chosen.speed:g} --loss {chosen.loss:g} --jitter {chosen.jitter:g}"
    return _PAGE.format(
        policy=chosen.policy,
        rigs=chosen.rigs,
        table=markdown.table(headings, rows),
        command=f"{words} {numbers} --seed {chosen.seed}",
        made=when_and_where(provenance()),
    )


_PAGE = """\
# Over the wire

`{policy}` from its file, on {rigs} rigs of the suite `default`: in the arena, and as `drillrig run` lets it control
`drillrig twin` over the [line protocol](line_protocol.md), the rigs in a process of their own. Loss and jitter hold for
measurements and commands, each drawn by itself. A rig that its [watchdog](hardware.md) took for want of commands counts
as not mitigated unless it calmed by itself at its target.

{table}

Intervals are at 95 %: Wilson's, and of the difference the bootstrap's over rigs.
`{command}`, {made}.
"""


def _shown(found: Estimate) -> tuple[str, str]:
    return f"{100 * found.value:.1f} %", f"{100 * found.low:.1f} to {100 * found.high:.1f} %"


if __name__ == "__main__":
    raise SystemExit(main())
