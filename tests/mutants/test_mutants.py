"""The driver of mutation testing on a toy project: what it changes, what it finds, what it keeps."""

import ast
from pathlib import Path

import pytest

from tests.mutants import __main__ as command
from tests.mutants import rooms
from tests.mutants.bench import Bench, Outcome
from tests.mutants.campaign import try_all
from tests.mutants.mutation import mutants_of
from tests.mutants.record import Record, chosen, reasons
from tests.mutants.report import Tally, kills, survivors, table
from tests.mutants.rooms import ROOMS, files_of, stages_of

TOY = '''
"""A toy: 1 + 1, which nobody reads."""
from __future__ import annotations
from typing import TYPE_CHECKING
import numpy as np
if TYPE_CHECKING:
    SIZE = 1
LIMIT = 10.0  # m, 2 < 3
__all__ = ["a"] + ["b"]

def toy(n: int | None, most: float = 0.5, *, strict: bool = True) -> float:
    """At most 3."""
    if n < 0 and not strict:
        raise ValueError(f"n = {n + 1} is not allowed" + "; allowed: > 0")
    total = (n + 2) * (  # 5 + 5
        most
    )
    total -= 1e-9
    check(total)
    return max(total, -LIMIT)
'''.lstrip()


def changes(source):
    return [(one.before, one.after) for one in mutants_of(source.encode(), "toy.py")]


def test_mutants_are_what_changes_the_meaning_and_nothing_that_is_only_read():
    found = changes(TOY)
    assert found == [
        ("LIMIT = 10.0  # m, 2 < 3", "LIMIT = 20.0  # m, 2 < 3"),
        (
            head := "def toy(n: int | None, most: float = 0.5, *, strict: bool = True) -> float:",
            head.replace("0.5", "1.0"),
        ),
        (head, head.replace("True", "False")),
        (line := "if n < 0 and not strict:", line.replace("<", "<=")),
        (line, line.replace("<", ">=")),
        (line, line.replace("0", "1")),
        (line, line.replace("and", "or")),
        (line, "if n < 0 and  strict:"),
        ('raise ValueError(f"n = {n + 1} is not allowed" + "; allowed: > 0")', "pass"),
        (line := "total = (n + 2) * (  # 5 + 5", line.replace("n + 2", "n - 2")),
        (line, line.replace("2", "3")),
        (line, line.replace("* (", "/ (")),
        (line := "total -= 1e-9", line.replace("-=", "+=")),
        (line, "total -= 1e-06"),
        ("check(total)", "pass"),
        (line := "return max(total, -LIMIT)", "return None"),
        (line, line.replace("max", "min")),
        (line, "return max(total, LIMIT)"),
    ]


@pytest.mark.parametrize(
    ("before", "after"),
    [
        ("a not in b", ["a in b"]),
        ("a is not b", ["a is b"]),
        ("a <= b", ["a < b", "a > b"]),
        ("a ** b", ["a * b"]),
        ("a // b % c", ["a * b % c", "a // b * c"]),
        ("a >> b", ["a << b"]),
        ("a.argmax()", ["a.argmin()"]),
        ("np.maximum(a, b)", ["np.minimum(a, b)"]),
        ("ä + b", ["ä - b"]),
        ("-(a)", ["(a)"]),
        ("(a)-(b)", ["(a)+(b)"]),
    ],
)
def test_each_operator_has_its_opposites(before, after):
    assert [becomes.removeprefix("x = ") for _, becomes in changes(f"x = {before}\n")] == after


@pytest.mark.parametrize(
    ("line", "after"),
    [
        ("zip(a, b, strict=True)", []),
        ("zip(a, b, strict=False)", ["zip(a, b, strict=True)"]),
        ("zip(a, b, strict=c > d)", ["zip(a, b, strict=c >= d)", "zip(a, b, strict=c <= d)"]),
        ("zip(a - b, strict=True)", ["zip(a + b, strict=True)"]),
        ("read(a, strict=True)", ["read(a, strict=False)"]),
        ("field(init=False, repr=False)", ["field(init=True, repr=False)"]),
    ],
)
def test_that_lengths_are_the_same_is_an_assertion_and_how_a_record_prints_is_only_read(line, after):
    """An assertion says what always holds; allowing what never comes would change nothing."""
    assert [becomes.removeprefix("x = ") for _, becomes in changes(f"x = {line}\n")] == after


def test_every_mutant_of_a_real_file_is_python_and_differs():
    file = Path(command.__file__).with_name("mutation.py")
    source = file.read_bytes()
    found = mutants_of(source, "mutation.py")
    assert len(found) > 50
    for mutant in found:
        mutated = mutant.applied_to(source)
        ast.parse(mutated)
        assert mutated != source
        assert mutant.before in source.decode()
        assert source.decode().splitlines()[mutant.line - 1].strip() == mutant.before.splitlines()[0]


@pytest.fixture
def project(tmp_path):
    root = tmp_path / "project"
    root.mkdir()
    (root / "toy.py").write_text("def sign(x):\n    return 1 if x > 0 else -1\n")
    (root / "test_toy.py").write_text(
        "from toy import sign\n\n\ndef test_sign():\n    assert sign(5) == 1\n    assert sign(-5) == -1\n"
    )
    (root / "test_slow.py").write_text("import time\n\n\ndef test_slow():\n    time.sleep(60)\n")
    (root / "test_wrong.py").write_text("def test_wrong():\n    assert False\n")
    return root


def mutant_to(source, after):
    return next(one for one in mutants_of(source.read_bytes(), source.name) if one.after.strip() == after)


@pytest.mark.slow
def test_bench_finds_what_tests_notice_and_leaves_the_project_as_it_was(project, tmp_path):
    bench, toy = Bench(project, tmp_path / "bench"), project / "toy.py"
    source = toy.read_bytes()
    noticed = bench.try_out(mutant_to(toy, "return 1 if x <= 0 else -1"), [["test_toy.py"]])
    assert noticed.killed_by == "test_toy.py::test_sign"
    assert bench.try_out(mutant_to(toy, "return 1 if x >= 0 else -1"), [["test_toy.py"]]).killed_by is None
    assert toy.read_bytes() == source == (bench.tree / "toy.py").read_bytes()
    with pytest.raises(ValueError, match=r"test_wrong\.py fails without any mutant"):
        bench.try_out(mutant_to(toy, "return None"), [["test_wrong.py"]])


def test_bench_ends_what_takes_too_long_and_runs_nothing_once_stopped(project, tmp_path):
    bench = Bench(project, tmp_path / "bench")
    assert bench._run(["test_slow.py"], tmp_path / "cache", 1.0) == (None, "")
    bench.stop()
    assert bench._run(["test_wrong.py"], tmp_path / "cache", None) == (None, "")


def test_bench_tries_short_tests_first(project, tmp_path):
    bench = Bench(project, tmp_path / "bench")
    bench._times = {"test_wrong.py": 2.0, "test_toy.py": 1.0}
    mutant = mutant_to(project / "toy.py", "return None")
    assert bench.try_out(mutant, [["test_wrong.py", "test_toy.py"]]).killed_by == "test_toy.py::test_sign"


@pytest.mark.slow
def test_kernels_of_a_mutant_are_kept_for_all_its_tests_and_not_for_the_next(project, tmp_path):
    kernel = "Path(os.environ['NUMBA_CACHE_DIR']) / 'kernel'"
    head = "import os\nfrom pathlib import Path\n\n\n"
    (project / "test_first.py").write_text(f"{head}def test_first():\n    ({kernel}).mkdir(parents=True)\n")
    (project / "test_then.py").write_text(f"{head}def test_then():\n    assert ({kernel}).exists()\n")
    bench = Bench(project, tmp_path / "bench")
    bench._times = {"test_first.py": 1.0, "test_then.py": 1.0}
    for mutant in mutants_of((project / "toy.py").read_bytes(), "toy.py")[:2]:
        assert bench.try_out(mutant, [["test_first.py"], ["test_then.py"]]).killed_by is None


def test_outcomes_hold_as_long_as_what_they_rest_on(project, tmp_path):
    """A killed mutant as long as its file is the same, a survivor as long as its tests are too."""
    toy, stages = project / "toy.py", [["test_toy.py"]]
    first, second = mutants_of(toy.read_bytes(), "toy.py")[:2]
    record = Record(tmp_path / "outcomes.jsonl", project)
    assert record.find(first, stages) is None
    record.add(first, stages, Outcome("test_toy.py::test_sign", 1.0))
    record.add(second, stages, Outcome(None, 2.0))

    def known():
        again = Record(tmp_path / "outcomes.jsonl", project)
        return again.find(first, stages), again.find(second, stages)

    assert known() == (Outcome("test_toy.py::test_sign", 1.0), Outcome(None, 2.0))
    (project / "test_toy.py").write_text("# other tests\n")
    assert known() == (Outcome("test_toy.py::test_sign", 1.0), None)
    toy.write_text(toy.read_text() + "\n# another text\n")
    assert known() == (None, None)


def test_sample_depends_on_the_seed_and_not_on_where_the_text_stands():
    here, moved = (mutants_of(source.encode(), "toy.py") for source in (TOY, "# a line more\n" + TOY))
    texts = [(one.before, one.after) for one in chosen(here, 6, seed=1)]
    assert texts == [(one.before, one.after) for one in chosen(moved, 6, seed=1)]
    assert texts != [(one.before, one.after) for one in chosen(here, 6, seed=2)]
    assert len(texts) == 6
    assert len(chosen(here, None, seed=1)) == len(here)


class Still:
    """A bench on which every other mutant survives."""

    def __init__(self):
        self.tried, self.stopped = 0, False

    def try_out(self, mutant, stages):
        self.tried += 1
        return Outcome(None if self.tried % 2 else "test", 0.0)

    def stop(self):
        self.stopped = True


def test_a_campaign_tries_all_or_keeps_what_it_has_when_it_is_stopped():
    mutants, outcomes, bench = mutants_of(TOY.encode(), "toy.py"), [], Still()
    assert try_all(mutants, lambda _: [], [bench], lambda mutant, outcome: outcomes.append(mutant))
    assert sorted(one.start for one in outcomes) == sorted(one.start for one in mutants)

    def stop_at_the_third(mutant, outcome):
        outcomes.append(mutant)
        if len(outcomes) == 3:
            raise KeyboardInterrupt

    outcomes.clear()
    assert not try_all(mutants, lambda _: [], [bench], stop_at_the_third)
    assert len(outcomes) == 3
    assert bench.stopped


def test_report_counts_by_file_and_room_and_sets_apart_what_changes_nothing():
    first, second, third = mutants_of(TOY.encode(), "toy.py")[:3]
    tally = Tally()
    tally.count(first, "test", None)
    tally.count(second, None, None)
    tally.count(third, None, "a default that every caller gives")
    rooms = {"toys": {"toy.py": tally, "untouched.py": Tally()}}
    assert kills([tally]) == 0.5
    assert kills([Tally()]) == 1.0
    lines = [line.split() for line in table(rooms).splitlines()]
    assert lines == [
        ["mutants", "killed", "survived", "alike"],
        ["toy.py", "3", "1", "1", "1"],
        ["toys", "3", "1", "1", "1", "50%"],
    ]
    text = survivors(rooms)
    assert f"toy.py:{second.line}\n  - {second.before}\n  + {second.after}" in text
    assert "alike: a default that every caller gives" in text
    assert first.after not in text
    assert survivors({"toys": {"toy.py": Tally()}}) == "no survivors"


def test_every_room_has_files_and_each_file_tests_of_its_room():
    root = command.ROOT
    for room in ROOMS:
        files = files_of(room, root)
        assert files
        every = {tuple(sorted(test for tests in stages_of(file, room, root) for test in tests)) for file in files}
        assert len(every) == 1  # whichever come first, in the end all of the room's tests have run
        assert all((root / test).exists() for test in every.pop())
    assert stages_of("drillrig_env/verdict.py", "model", root)[0] == ["tests/test_verdict.py"]
    assert "drillrig_env/env/rendering.py" not in files_of("env", root)


def test_listed_survivors_are_mutants_that_exist():
    """An entry whose line has changed says nothing any more."""
    mutants = {
        (mutant.file, mutant.before, mutant.after)
        for file in {file for file, _, _ in reasons()}
        for mutant in mutants_of((command.ROOT / file).read_bytes(), file)
    }
    for entry, reason in reasons().items():
        assert entry in mutants, "its line has changed: take the entry out of survivors.toml, and try the new line"
        assert len(reason) > 10


def test_what_is_listed_is_counted_and_not_tried(tmp_path, monkeypatch, capsys):
    file = "drillrig_env/verdict.py"
    every = mutants_of((command.ROOT / file).read_bytes(), file)
    monkeypatch.setattr(command, "reasons", lambda: {(file, one.before, one.after): "nobody minds" for one in every})
    assert command.main(["model", "--file", file, "--max", "3", "--work", str(tmp_path)]) == 0
    assert "3 mutants, of which 3 are listed" in (told := capsys.readouterr().out)
    assert told.count("alike: nobody minds") == 3


def test_rooms_take_turns(tmp_path, monkeypatch, capsys):
    tried = []
    monkeypatch.setattr(command, "Bench", lambda *_: None)
    monkeypatch.setattr(command, "try_all", lambda mutants, *_: tried.extend(one.file for one in mutants) or True)
    command.main(["env", "stepper", "--max", "2", "--work", str(tmp_path)])
    assert [file.split("/")[1] for file in tried] == ["env", "stepper", "env", "stepper"]


@pytest.mark.parametrize(
    ("arguments", "words"),
    [
        (["atic"], "room 'atic' is not known; allowed: model"),
        (["--jobs", "0"], "--jobs 0"),
        (["--max", "-1"], "--max -1"),
    ],
)
def test_unknown_rooms_and_impossible_numbers_are_refused(arguments, words, capsys):
    with pytest.raises(SystemExit) as caught:
        command.main(arguments)
    assert caught.value.code == 2
    assert words in capsys.readouterr().err


def test_a_file_of_no_room_is_refused(capsys):
    assert command.main(["--file", "drillrig_env/nosuch.py"]) == 2
    assert "nosuch.py" in capsys.readouterr().err


def test_files_and_tests_that_are_named_are_there():
    root = Path(__file__).parents[2]
    for file, tests in rooms._BESIDE.items():
        assert (root / file).is_file(), file
        for test in tests:
            assert (root / test).is_file(), test
