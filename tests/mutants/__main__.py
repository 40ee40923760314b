"""Mutation testing: change the code in one place, and see whether a test notices.

    python -m tests.mutants                       # 30 random mutants of every room that decides
    python -m tests.mutants stability --max 100
    python -m tests.mutants --file drillrig_env/verdict.py --max 0    # all of one file

Each mutant runs the tests of its own file first, then those of its room, up to the first that fails. The rooms take
turns, and outcomes are kept as they come, so that the same command goes on where it was stopped. Mutants that change
nothing are listed with the reason in tests/mutants/survivors.toml: they are not tried, and counted apart. Exit status
1 where a room kills less than 85 %.
"""

from __future__ import annotations

import argparse
import getpass
import sys
from collections.abc import Sequence
from hashlib import sha256
from itertools import zip_longest
from pathlib import Path
from tempfile import gettempdir

from tests.mutants.bench import Bench, Outcome
from tests.mutants.campaign import try_all
from tests.mutants.mutation import Mutant, mutants_of
from tests.mutants.record import Record, chosen, reasons
from tests.mutants.report import ENOUGH, Tally, kills, survivors, table
from tests.mutants.rooms import ROOMS, files_of, stages_of

ROOT = Path(__file__).parents[2]


def main(arguments: Sequence[str] | None = None) -> int:
    """Parse the command line, try mutants out and report; the exit status."""
    options = _options(arguments)
    files = {room: files_of(room, ROOT) for room in options.rooms or ROOMS}
    if options.file:
        files = {room: [options.file] for room, names in files.items() if options.file in names}
    if not files:
        print(f"tests.mutants: file {options.file!r} belongs to none of the rooms", file=sys.stderr)
        return 2
    work = options.work or Path(gettempdir()) / f"drillrig-mutants-{getpass.getuser()}" / _digest(str(ROOT))
    record, listed = Record(work / "outcomes.jsonl", ROOT), reasons()
    tallies = {room: {name: Tally() for name in names} for room, names in files.items()}
    room_of = {name: room for room, names in files.items() for name in names}

    tests = {name: stages_of(name, room, ROOT) for name, room in room_of.items()}

    def stages(mutant: Mutant) -> list[list[str]]:
        return tests[mutant.file]

    def count(mutant: Mutant, outcome: Outcome) -> None:
        reason = listed.get((mutant.file, mutant.before, mutant.after))
        tallies[room_of[mutant.file]][mutant.file].count(mutant, outcome.killed_by, reason)

    samples = [
        chosen(
            (one for name in names for one in mutants_of((ROOT / name).read_bytes(), name)),
            options.max or None,
            options.seed,
        )
        for names in files.values()
    ]
    sample = [mutant for turn in zip_longest(*samples) for mutant in turn if mutant is not None]
    known = {
        mutant: Outcome(None, 0.0)
        if (mutant.file, mutant.before, mutant.after) in listed
        else record.find(mutant, stages(mutant))
        for mutant in sample
    }
    waiting = [mutant for mutant, outcome in known.items() if outcome is None]
    for mutant, outcome in known.items():
        if outcome is not None:
            count(mutant, outcome)
    print(
        f"{len(sample)} mutants, of which {len(sample) - len(waiting)} are listed or known from {record.path}",
        flush=True,
    )
    tried = 0

    def done(mutant: Mutant, outcome: Outcome) -> None:
        nonlocal tried
        tried += 1
        record.add(mutant, stages(mutant), outcome)
        count(mutant, outcome)
        verdict = f"killed by {outcome.killed_by}" if outcome.killed_by else "SURVIVED"
        place = f"{mutant.file}:{mutant.line}: {mutant.after}"
        print(f"{tried}/{len(waiting)} {outcome.seconds:4.0f} s  {verdict}  {place}", flush=True)

    benches = [
        Bench(ROOT, work / f"bench{number}", lambda text: print(text, flush=True))
        for number in range(min(options.jobs, len(waiting)))
    ]
    finished = not benches or try_all(waiting, stages, benches, done)
    print(f"\n{table(tallies)}\n\n{survivors(tallies)}")
    if not finished:
        print("stopped; the same command goes on from here", file=sys.stderr)
        return 130
    return int(any(kills(list(room.values())) < ENOUGH for room in tallies.values()))


def _options(arguments: Sequence[str] | None) -> argparse.Namespace:
    parser = argparse.ArgumentParser(
        prog="python -m tests.mutants", description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter
    )
    parser.add_argument("rooms", nargs="*", metavar="ROOM", help=f"any of {', '.join(ROOMS)} (default: all)")
    parser.add_argument("--file", help="mutate this file only, a path from the top of the project")
    parser.add_argument("--max", type=int, default=30, help="mutants of each room; 0 is all (default: 30)")
    parser.add_argument("--seed", type=int, default=0, help="of the random choice of mutants (default: 0)")
    parser.add_argument("--jobs", type=int, default=1, help="mutants tried at a time (default: 1)")
    parser.add_argument("--work", type=Path, help="folder of outcomes, kernels and copies (default: a temporary one)")
    options = parser.parse_args(arguments)
    for room in options.rooms:
        if room not in ROOMS:
            parser.error(f"room {room!r} is not known; allowed: {', '.join(ROOMS)}")
    for name, least in (("max", 0), ("jobs", 1)):
        if (value := getattr(options, name)) < least:
            parser.error(f"--{name} {value} is not allowed; allowed: >= {least}")
    return options


def _digest(text: str) -> str:
    return sha256(text.encode()).hexdigest()[:12]


if __name__ == "__main__":
    sys.exit(main())
