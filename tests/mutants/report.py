"""What a run of mutants tells: a table by file and room, and the survivors, those that count and those that do not."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field

from tests.mutants.mutation import Mutant

ENOUGH = 0.85
"""Share of mutants that the tests of a room must kill; those that change nothing are apart."""


@dataclass
class Tally:
    """Outcomes of some mutants: how many were killed, and which survived."""

    killed: int = 0
    survivors: list[Mutant] = field(default_factory=list)
    alike: list[tuple[Mutant, str]] = field(default_factory=list)  # that change nothing, with the reason

    def count(self, mutant: Mutant, killed_by: str | None, reason: str | None) -> None:
        """Take one outcome; `reason` says why a survivor changes nothing, None that it counts."""
        if killed_by is not None:
            self.killed += 1
        elif reason is None:
            self.survivors.append(mutant)
        else:
            self.alike.append((mutant, reason))


def kills(tallies: Sequence[Tally]) -> float:
    """Share of mutants killed, of those that change something; 1 where there are none."""
    killed, alive = sum(tally.killed for tally in tallies), sum(len(tally.survivors) for tally in tallies)
    return killed / (killed + alive) if killed + alive else 1.0


def table(rooms: Mapping[str, Mapping[str, Tally]]) -> str:
    """A line a file that had mutants, by room and name, and a line a room."""
    lines = [f"{'':46}{'mutants':>8}{'killed':>8}{'survived':>9}{'alike':>7}"]
    for room, tallies in rooms.items():
        lines += [_line(f"  {name}", [tally]) for name, tally in tallies.items() if _line("", [tally]) != _line("", [])]
        lines.append(f"{_line(room, list(tallies.values()))}  {kills(list(tallies.values())):.0%}")
    return "\n".join(lines)


def survivors(rooms: Mapping[str, Mapping[str, Tally]]) -> str:
    """Place and change of every survivor; then those that are listed as changing nothing, with the reason."""
    tallies = [tally for room in rooms.values() for tally in room.values()]
    lines = [_change(mutant) for tally in tallies for mutant in tally.survivors]
    alike = [f"{_change(mutant)}\n    alike: {reason}" for tally in tallies for mutant, reason in tally.alike]
    return "\n".join(["survivors:" if lines else "no survivors", *lines, *alike])


def _line(name: str, tallies: Sequence[Tally]) -> str:
    killed, alive = sum(tally.killed for tally in tallies), sum(len(tally.survivors) for tally in tallies)
    alike = sum(len(tally.alike) for tally in tallies)
    return f"{name:46}{killed + alive + alike:8}{killed:8}{alive:9}{alike:7}"


def _change(mutant: Mutant) -> str:
    return f"{mutant.file}:{mutant.line}\n  - {mutant.before}\n  + {mutant.after}"
