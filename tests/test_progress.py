"""Progress: lines where there is no terminal, and in a terminal one line that is never wider than it."""

import io

from rich.console import Console

from drillrig_env import progress as module
from drillrig_env.progress import Progress


def work(progress):
    with progress:
        for part in ("constant", "lqg"):
            for step in range(3):
                progress.show(part, step + 1, 3)


def test_without_a_terminal_there_is_a_line_a_part():
    file = io.StringIO()
    work(Progress("default", 2, file))
    lines = file.getvalue().splitlines()
    assert [line.split(" done in ")[0] for line in lines] == ["default: constant", "default: lqg"]
    assert lines[0].endswith("(1 of 2)")
    assert lines[1].endswith("(2 of 2)")
    assert "\x1b" not in file.getvalue()


class Terminal(io.StringIO):
    def isatty(self):
        return True


def test_in_a_terminal_there_is_a_bar_and_nothing_stays(monkeypatch):
    monkeypatch.setenv("TERM", "xterm")
    file = Terminal()
    work(Progress("default", 2, file))
    assert "default: lqg" in file.getvalue()
    assert " done in " not in file.getvalue()


def test_a_bar_is_one_line_in_terminals_of_any_width():
    bars = module._bar(Terminal())
    bars.add_task("degraded: feed_forward_start_of_a_long_name", completed=1, total=3)
    for width in (200, 80, 40, 20, 10):
        console = Console(file=io.StringIO(), width=width, force_terminal=True, color_system=None)
        console.print(bars.get_renderable())
        lines = console.file.getvalue().rstrip("\n").splitlines()
        assert len(lines) == 1
        assert len(lines[0]) <= width


def test_without_rich_there_are_lines(monkeypatch):
    monkeypatch.setattr(module, "_bar", lambda file: None)
    file = Terminal()
    work(Progress("default", 2, file))
    assert len(file.getvalue().splitlines()) == 2
