"""What is known of mutants: outcomes as JSON lines, and the survivors that change nothing, with reasons."""

from __future__ import annotations

import hashlib
import json
import tomllib
from collections.abc import Iterable
from pathlib import Path

from tests.mutants.bench import Outcome
from tests.mutants.mutation import Mutant

SURVIVORS = Path(__file__).with_name("survivors.toml")


class Record:
    """Outcomes in a file, a line each, written at once: a run that is cut short is gone on with.

    An outcome holds as long as the mutated file is the same; that a mutant survived, as long as the tests are, too.
    """

    def __init__(self, path: Path, root: Path) -> None:
        self.path = path
        self._root = root
        self._known: dict[str, Outcome] = {}
        self._digests: dict[str, str] = {}
        if path.exists():
            for line in path.read_text(encoding="utf-8").splitlines():
                kept = json.loads(line)
                self._known[kept["key"]] = Outcome(kept["killed_by"], kept["seconds"])

    def find(self, mutant: Mutant, stages: list[list[str]]) -> Outcome | None:
        """What became of a mutant in an earlier run, if that still holds."""
        killed = self._known.get(self._key(mutant, []))
        return killed if killed and killed.killed_by else self._known.get(self._key(mutant, stages))

    def add(self, mutant: Mutant, stages: list[list[str]], outcome: Outcome) -> None:
        """Keep an outcome."""
        key = self._key(mutant, [] if outcome.killed_by else stages)
        self._known[key] = outcome
        names = {"file": mutant.file, "line": mutant.line, "before": mutant.before, "after": mutant.after}
        self.path.parent.mkdir(parents=True, exist_ok=True)
        with self.path.open("a", encoding="utf-8") as file:
            file.write(json.dumps({"key": key, **names, **vars(outcome)}, ensure_ascii=False) + "\n")

    def _key(self, mutant: Mutant, stages: list[list[str]]) -> str:
        names = [mutant.file, *(test for tests in stages for test in tests)]
        text = " ".join([f"{mutant.start} {mutant.end} {mutant.replacement}", *map(self._digest, names)])
        return hashlib.sha256(text.encode()).hexdigest()[:24]

    def _digest(self, name: str) -> str:
        """Of a file as it was when the run began: that is what the benches have."""
        if name not in self._digests:
            self._digests[name] = hashlib.sha256((self._root / name).read_bytes()).hexdigest()
        return self._digests[name]


Reasons = dict[tuple[str, str, str], str]
"""Why a survivor changes nothing, by file and by its line before and after."""


def reasons(path: Path = SURVIVORS) -> Reasons:
    """The listed survivors. `ValueError` for an entry that is not whole."""
    found: Reasons = {}
    for entry in tomllib.loads(path.read_text(encoding="utf-8")).get("survivor", []):
        if entry.keys() != {"file", "before", "after", "reason"}:
            raise ValueError(f"{path}: an entry has file, before, after and reason, not {', '.join(entry)}")
        found[entry["file"], entry["before"], entry["after"]] = entry["reason"]
    return found


def chosen(mutants: Iterable[Mutant], most: int | None, seed: int) -> list[Mutant]:
    """A random sample that depends on the seed and on the text of the mutants alone, not on where that stands."""

    def place(mutant: Mutant) -> bytes:
        return hashlib.sha256(f"{seed} {mutant.file} {mutant.before} {mutant.after}".encode()).digest()

    return sorted(mutants, key=place)[:most]
