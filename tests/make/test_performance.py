import json
import re
from itertools import pairwise
from pathlib import Path

import pytest

from benchmarks.parts import PARTS
from benchmarks.parts.named_lines import spread
from benchmarks.parts.part import amount, digits, duration, power, times
from docs.make.__main__ import main
from docs.make.performance import COMMAND, page, read

DOCS = Path(__file__).parents[2] / "docs"
PROVENANCE = {"date": "2026-01-02", "python": "3.11", "machine": "a processor, 1 core", "versions": {"numpy": "2"}}


def solver(name, library, rtol, error, seconds):
    setting = {"solver": name, "library": library, "version": "1", "form": "compiled", "setting": f"rtol {rtol:g}"}
    speed = {"seconds_for_50_s": seconds, "simulated_s_per_s": 50.0 / seconds, "compile_s": 1.0}
    return {**setting, "rtol": rtol, "error_rad_s": error, **speed}


def batch(name, library, rtol, error, seconds_per_rig):
    sizes = {
        str(rigs): {
            "seconds_per_rig": seconds_per_rig,
            "simulated_s_per_s": 10.0 / seconds_per_rig,
            "memory_per_rig_B": 100.0,
            "compile_s": 1.0,
        }
        for rigs in (1, 256, 4096)
    }
    about = {"solver": name, "library": library, "rtol": rtol, "cores": 2, "duration_s": 10.0, "sizes": sizes}
    return {**about, "median_error_rad_s": error}


def rates(fixed, random):
    return {"steps_per_second_fixed": fixed, "steps_per_second_random": random, "seconds_per_draw": 2e-6}


def training(environment, goal):
    shares = {"env_percent": 10.0, "policy_percent": 20.0, "update_percent": 60.0, "other_percent": 10.0}
    setting = {"algorithm": "ppo", "environment": environment, "cores": 1, "torch_threads": 1, "n_envs": 8}
    reached = {"runs_to_goal": 1, "seconds_to_goal": goal, "steps_to_goal": goal}
    return {**setting, **shares, **reached, "steps_per_second": 12_345.0, "env_steps_per_second": 1e6}


RESULTS = {
    "solvers": {
        "case": {"normal_force_N": 20.0, "speed_reference_rad_s": 2.0},
        "solvers": [
            solver("DrillRig fast stepper", "DrillRig", 1e-3, 1e-7, 1e-4),
            solver("DrillRig fast stepper", "DrillRig", 1e-6, 1e-8, 2e-4),
            solver("other", "Other", 1e-4, 1e-4, 2e-3),
            solver("other", "Other", 1e-9, 1e-7, 4e-2),
            solver("coarse", "Other", 1e-4, 1e-5, 1e-2),
            {"solver": "broken", "version": "1", "setting": "rtol 1", "failure": "Error: a | b"},
        ],
        "faster_than": {"the fastest peer, error <= 1e-6": {"ratio": 200.0}},
    },
    "batches": {
        "batches": [
            batch("DrillRig fast stepper, all cores", "DrillRig", 1e-6, 1e-7, 1e-5),
            batch("other, all cores", "Other", 1e-8, 5e-7, 4e-4),
            {**batch("slow", "Other", 1e-8, 1e-2, 1.0), "not_run": "4,096 rigs would take about 999 s"},
        ],
    },
    "environments": {
        "cores": 2,
        "left_out": ["envpool is left out; install it with: pip install envpool"],
        "environments": {"DrillRig-v0": "a rig", "CartPole-v1": "a cart"},
        "versions": {"envpool": "1"},
        "rates": {
            "1": {"DrillRig-v0": rates(3e5, 5e4), "CartPole-v1": rates(2e5, 1e5)},
            "256": {"DrillRig-v0": rates(2e6, 2e6)},
            "4096": {"DrillRig-v0": rates(4.25e6, 4e6), "CartPole-v1": rates(2e7, 2e7)},
            "65536": {"DrillRig-v0": rates(1e6, 4e6)},
        },
        "memory": {"bytes_per_rig": 777.0},
    },
    "startup": {
        "tasks": {"import drillrig_env": "", "import, first env step": ""},
        "cases": {
            "fresh install": {
                "first": {"import, first env step": {"seconds": 14.2}},
                "later": {"import drillrig_env": {"seconds": 0.5}, "import, first env step": {"seconds": 0.75}},
            },
            "no home": {"fails": "RuntimeError: nowhere to write"},
        },
    },
    "training": {"goal": 0.9, "rows": [training("DrillRig-v0", 6.4), training("Pendulum-v1", None)]},
    "stability": {
        "seconds": {"fold, a new rig": 0.09},
        "hopf_to_fold": {"DrillRig": {"hopf": 1.9, "fold": 2.9, "seconds": 0.1, "remark": "31 orbits"}},
        "map": {"seconds": 1.5, "points": 1600, "cores": 2, "judged": 1502, "agree": 1.0},
    },
}


@pytest.fixture
def measured(tmp_path):
    """A folder with what all benchmarks have written."""
    folder = tmp_path / "results"
    folder.mkdir()
    for name, results in RESULTS.items():
        (folder / f"{name}.json").write_text(json.dumps({"provenance": PROVENANCE, "results": results}))
    return folder


@pytest.fixture
def docs(tmp_path):
    """The folder that a page is to be written into."""
    return tmp_path / "docs"


def make(docs, *folders, pictures=False):
    """Write the page after taking the folders in; returns its text."""
    words = ["performance", "--docs", str(docs), *(["--take-in", *map(str, folders)] if folders else [])]
    assert main([*words, *([] if pictures else ["--no-pictures"])]) == 0
    return (docs / "performance.md").read_text()


def test_page_shows_every_part(measured, docs):
    text = make(docs, measured)
    for words in (
        "| one rig, against the fastest peer, error ≤ 1e-6 rad/s | **200 times** as fast |",
        "| other | compiled | 2.0 ms | rtol 0.0001 | 20 | 40 ms | rtol 1e-09 | 200 |",
        "| coarse | compiled | 10 ms | rtol 0.0001 | 100 | - | - | - |",
        "| broken | 1 | rtol 1 | Error: a \\| b | - | - | - |",
        "median error ≤ 1e-6 rad/s | **40 times** as fast as other, all cores, 1e-8 |",
        "- slow, 1e-8: 4,096 rigs would take about 999 s.",
        "| one environment, fixed action | **1.5 times** the steps/s of CartPole-v1 |",
        "| one environment, random actions, drawn within the time | **0.5 times** the steps/s of CartPole-v1 |",
        "**4.25 M steps/s**",
        "**2.00 times** that of one of 256",
        "**777 bytes**",
        "- envpool is left out; install it with: pip install envpool.",
        "| first step after an install, compilation included | **14 s** |",
        "No home: fails with `RuntimeError: nowhere to write`.",
        "until 0.9 are mitigated on the softened drive, where action 0 has 0.99 | **6.4 s** |",
        "| Pendulum-v1 | 8 | 1 | 1 | 12,345 | 1,000,000 | not reached | not reached |",
        "| stability: fold, a new rig | **90 ms** |",
        "A map of 40 x 40 points",
        "a processor, 1 core, Python 3.11, numpy 2, envpool 1.",
    ):
        assert words in text, words
    assert not re.search(r"\b(nan|inf|None)\b", text)


@pytest.mark.slow
def test_pictures_are_drawn_and_shown(measured, docs):
    shown = set(re.findall(r"\]\((images/performance/.+)\)", make(docs, measured, pictures=True)))
    assert {Path(path).stem for path in shown} == {part.name for part in PARTS if part.plot} >= {"solvers", "training"}
    assert all((docs / path).read_bytes().startswith(b"\x89PNG") for path in shown)


def test_page_is_made_again_from_what_lies_beside_it(measured, docs, capsys):
    text = make(docs, measured)
    for file in measured.iterdir():
        file.unlink()
    assert make(docs) == text
    assert make(docs, docs / "performance") == text
    assert make(docs, measured) == text  # nothing there: what was taken in stays
    check = ["performance", "--check", "--docs", str(docs)]
    assert main(check) == 0
    (docs / "performance.md").write_text("old")
    assert main(check) == 1
    assert "out of date: performance; run: python -m docs.make performance" in capsys.readouterr().err


def test_part_that_is_missing_or_broken_names_its_command(measured, docs):
    (measured / "training.json").unlink()
    (measured / "startup.json").write_text("{ not JSON")
    (measured / "solvers.json").write_text(json.dumps({"provenance": PROVENANCE, "results": {"solvers": [{}]}}))
    text = make(docs, measured)
    for name in ("training", "startup"):
        assert f"Not measured yet: run `python -m benchmarks.{name}`" in text
    assert "another version: run `python -m benchmarks.solvers`" in text
    assert "images/performance/solvers.png" not in text
    assert "**777 bytes**" in text


@pytest.mark.slow
def test_benchmark_that_was_stopped_at_once_is_shown_as_far_as_it_went(measured, docs):
    nothing = {"environments": {"rates": {}}, "batches": {"batches": []}, "startup": {"cases": {}}}
    for name, part in nothing.items():
        results = {**RESULTS[name], **part}
        (measured / f"{name}.json").write_text(json.dumps({"provenance": PROVENANCE, "results": results}))
    assert "## Environments" in make(docs, measured, pictures=True)


def test_words_of_a_person_stand_with_their_part(measured, docs):
    (docs / "performance").mkdir(parents=True)
    (docs / "performance" / "notes.md").write_text(
        "About.\n\n## startup\n\nWords on waiting.\n\n## stability\n\nMore.\n"
    )
    text = make(docs, measured)
    assert text.index("## Start-up") < text.index("Words on waiting.") < text.index("## Training")
    assert "About." not in text


@pytest.mark.parametrize(
    ("written", "value"),
    [
        (times(12_345.4), "12,345"),
        (times(1.26), "1.3"),
        (times(0.04), "0.04"),
        (amount(4.25e6), "4.25 M"),
        (amount(241_667.0), "242 k"),
        (amount(999_999.0), "1.00 M"),
        (amount(42.0), "42"),
        (amount(None), "-"),
        (duration(3.3e-4), "330 µs"),
        (duration(0.9999), "1.0 s"),
        (duration(26.4), "26 s"),
        (duration(5e-9), "5 ns"),
        (digits(1234.5), "1,234"),
        (digits(4.0123), "4.01"),
        (power(1e-6), "1e-6"),
    ],
)
def test_numbers_are_written_for_readers(written, value):
    assert written == value


def test_names_beside_lines_keep_their_order_and_distance():
    assert spread([0.0, 1.0, 2.0], 0.5) == [0.0, 1.0, 2.0]
    places = spread([0.0, 0.01, 0.02, 0.9, 0.91], 0.2)
    assert all(b - a >= 0.2 - 1e-12 for a, b in pairwise(places))
    assert sum(places[:3]) == pytest.approx(0.03)
    assert spread([], 0.1) == []


@pytest.mark.skipif(
    all(read(DOCS / "performance" / f"{part.name}.json") is None for part in PARTS), reason="nothing has been measured"
)
def test_the_projects_page_is_up_to_date():
    assert (DOCS / "performance.md").read_text(encoding="utf-8") == page(DOCS), f"out of date; run: {COMMAND}"
