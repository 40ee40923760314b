"""Draw the pictures of the control room for README and docs: docs/images/room.

    python -m benchmarks.room_pictures

Each is what Chromium shows of a room that is played at ten times real time up to the same moment; a minute in all.
Needs the extra `room-test`, Debian's Chromium, and the parts of the page (`make room-test` brings all three).
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from pathlib import Path
from typing import Any

from benchmarks.browser import ROOT, chromium, is_drawn, room
from drillrig_env.command_line import Parser, command

IMAGES = ROOT / "docs" / "images" / "room"


def _play(page: Any, until: float) -> None:
    """Let the run go on to a time (s), and stop it there."""
    page.select_option("#times", "10")
    is_drawn(page, until)
    page.select_option("#times", "1")
    page.click("#pause")
    page.wait_for_timeout(700)


def _two_lanes(page: Any) -> None:
    _play(page, 24.0)
    page.fill("#field-normal_force", "14")
    page.press("#field-normal_force", "Enter")
    page.click("#pause")
    _play(page, 34.0)


def _lecture(page: Any) -> None:
    _play(page, 12.0)
    page.click("#pause")
    page.click("#tale-next")
    _play(page, 26.0)
    page.click("#pause")
    page.click("#tale-next")
    _play(page, 44.0)


def _dark(page: Any) -> None:
    _play(page, 8.0)
    page.click("#pause")
    page.get_by_role("button", name="Take over lane A").click()
    page.fill(".lane[data-lane='A'] .reference-number", "3.3")
    page.press(".lane[data-lane='A'] .reference-number", "Enter")
    page.click(".lane[data-lane='B'] summary")
    _play(page, 30.0)


PICTURES: dict[str, tuple[Sequence[str], tuple[int, int], str, Callable[[Any], None]]] = {
    "room": ((), (1600, 1000), "light", _two_lanes),
    "lecture": (("--story", "bistability", "--full-screen"), (1600, 900), "light", _lecture),
    "dark": ((), (1600, 1000), "dark", _dark),
}
"""Words behind `drillrig room`, size in px, colours, and what is done, by the picture's name."""


@command
def main(arguments: Sequence[str] | None = None, prog: str = "python -m benchmarks.room_pictures") -> None:
    """Parse the command line, and draw every picture."""
    parser = Parser(prog=prog, description=__doc__)
    parser.add_argument("--output", type=Path, default=IMAGES, help="folder (default: docs/images/room)")
    chosen = parser.parse_args(arguments)
    chosen.output.mkdir(parents=True, exist_ok=True)
    with chromium() as browser:
        for name, (words, (width, height), scheme, play) in PICTURES.items():
            with room(*words) as served:
                page = browser.new_page(viewport={"width": width, "height": height}, color_scheme=scheme)
                page.goto(served.address)
                is_drawn(page)
                play(page)
                page.wait_for_function("() => document.querySelector('.borders').textContent.includes('end')")
                page.mouse.move(0, 0)
                page.screenshot(path=chosen.output / f"{name}.png")
                page.close()
            print(chosen.output / f"{name}.png")


if __name__ == "__main__":
    raise SystemExit(main())
