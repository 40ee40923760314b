"""What a training shows: one line for each, however narrow the terminal."""

import io
import json

import pytest
from rich.console import Console

from agents.training.progress import ShowProgress, bars, line, read_progress

NUMBERS = {"steps": 1_234_567, "reward": -0.123, "mitigated": 0.5, "evaluated": 0.25, "steps_per_second": 98_765.0}


@pytest.mark.parametrize("width", [40, 60, 120])
def test_a_bar_takes_one_line_in_any_terminal(width):
    console = Console(width=width, file=io.StringIO(), force_terminal=True)
    shown = bars(console)
    for name in ("seed_0", "seed_1"):
        shown.add_task(name, total=2_000_000, completed=1_234_567, numbers=NUMBERS)
    with console.capture() as drawn:
        console.print(shown.get_renderable())
    assert len(drawn.get().splitlines()) == 2


def test_numbers_that_are_not_known_yet_are_left_out():
    assert line({}) == "0 steps"
    told = "1,234,567 steps  reward -0.123  mitigated 0.50  evaluated 0.250  98,765 steps/s"
    assert line(NUMBERS) == told
    assert line({**NUMBERS, "evaluated": None}) == told.replace("  evaluated 0.250", "")


def test_while_it_imitates_time_goes_on():
    assert line({"imitated": 4_000, "steps": 0, "seconds": 12.3}) == "imitates: 4,000 steps, 12 s"


def test_a_training_that_is_stopped_before_it_has_told_anything_has_taken_no_time(tmp_path):
    for earlier in (0.0, 100.0):
        (tmp_path / "progress.json").write_text(json.dumps({"seconds": earlier}))
        shown = ShowProgress(tmp_path, 10, show=False)
        shown.num_timesteps = 0
        shown.close()
        assert earlier <= read_progress(tmp_path)["seconds"] < earlier + 5.0


def test_progress_that_is_missing_or_damaged_is_nothing_yet(tmp_path):
    assert read_progress(tmp_path) == {}
    (tmp_path / "progress.json").write_text(json.dumps(NUMBERS)[:20])
    assert read_progress(tmp_path) == {}
