"""The control room: frames, processors, bytes, the first picture, and clients beside each other."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

from benchmarks.parts.part import Part, Results, duration
from drillrig_env import markdown

_PAGE = {
    "frames_per_second": ("frames/s of the page, two lanes", "{:.0f}"),
    "server_share": ("server, of a core", "{:.1%}"),
    "browser_share": ("browser, of a core", "{:.0%}"),
}
_BYTES = {"bytes_per_second": ("kB/s to one page", "{:.1f}"), "messages_per_second": ("messages/s", "{:.0f}")}
_CLIENTS = {
    "server_share": ("server with four clients, each its own rig, of a core", "{:.0%}"),
    "slowest_share_of_due": ("control steps that came of those due, the slowest client", "{:.0%}"),
}


def result(results: Results) -> list[tuple[str, str]]:
    """What a user meets."""
    found, told = results["cases"], []
    if "page" in found:
        page = found["page"]["1"]
        told.append(("control room, two lanes at real time", f"**{page['frames_per_second']:.0f} frames/s**"))
        told.append(("control room, server for one page", f"**{page['server_share']:.1%}** of a core"))
    if "first picture" in found:
        told.append(
            ("control room, from command to first picture", f"**{duration(found['first picture']['seconds'])}**")
        )
    if "map" in found:
        told.append(("control room, from slider to map", f"**{found['map']['median_ms']:.0f} ms**"))
    return told


def tables(results: Results) -> list[str]:
    """What was measured at real time and at ten times that, and what belongs to no speed."""
    found = results["cases"]
    rows = [
        *_rows(found.get("page"), _PAGE),
        *_rows(found.get("bytes"), _BYTES),
        *_rows(found.get("four clients"), _CLIENTS),
    ]
    blocks = [markdown.table(("what", "real time", "ten times that"), rows)]
    if "map" in found:
        waits = found["map"]
        blocks.append(
            f"From a new value of a slider to the map that follows it: median {waits['median_ms']:.0f} ms, nine in "
            f"ten within {waits['nine_in_ten_ms']:.0f} ms, the slowest {waits['slowest_ms']:.0f} ms."
        )
    if slow := found.get("a client that reads nothing"):
        blocks.append(
            f"Beside a client that reads nothing at ten times real time, for {results['seconds']:.0f} s: the server "
            f"grew by {slow['grown_kilobytes']:,} kB, another client got {slow['other_share_of_due']:.0%} of its "
            f"control steps, and the slow one, when it read again, was told that steps were left out."
        )
    load = f"{results['load_before']:.1f} to {results['load_after']:.1f}"
    blocks.append(f"Load of the machine while this was measured: {load}; priority {results['nice']}.")
    return blocks


def _rows(found: Mapping[str, Any] | None, lines: Mapping[str, tuple[str, str]]) -> list[list[str]]:
    if found is None:
        return []
    scale = {"bytes_per_second": 1e-3}
    return [
        [words, *(form.format(found[speed][name] * scale.get(name, 1.0)) for speed in ("1", "10"))]
        for name, (words, form) in lines.items()
    ]


ROOM = Part(
    "room",
    "The control room",
    """Two lanes with seven signals each at 160 samples a second, drawn over 30 s by Chromium without a
window or a graphics card at 1600 by 1000 px; server and browser on the same two cores. The first picture is from the
command, kernels compiled, to what a page has drawn. Other work on the machine takes frames away; processor times
hardly depend on it.""",
    result,
    tables,
)
