"""The tables of a comparison as text: in the terminal, 80 columns wide, and in Markdown."""

from __future__ import annotations

from collections.abc import Iterable, Mapping
from decimal import ROUND_CEILING, ROUND_FLOOR, Decimal

from drillrig_env import markdown
from drillrig_env.evaluation.results import MARKS, SOFT, TOLD, label
from drillrig_env.evaluation.statistics import Estimate
from drillrig_env.evaluation.tables import (
    DIFFERENCES,
    HARDNESS,
    MAIN,
    OTHERS,
    Row,
    Scores,
    Table,
    differences,
    estimates,
)

_WIDTH = 80
_EXACT = 9  # digits behind the point that an end of an interval is taken with: what comes after them is rounding


def rows(results: Mapping[str, Scores], table: Table = MAIN) -> dict[str, Row]:
    """The estimates of a suite's policies."""
    return {policy: estimates(scores, table.columns) for policy, scores in results.items()}


def difference_rows(results: Mapping[str, Scores], reference: str) -> dict[str, Row]:
    """Paired differences from the reference of all other policies of a suite; none where it was not run."""
    if reference not in results:
        return {}
    return {
        policy: differences(scores, results[reference]) for policy, scores in results.items() if policy != reference
    }


def grouped(policies: Iterable[str], marks: Mapping[str, str]) -> dict[str, list[str]]:
    """Policies that are alike in what they may do, by what that is in words, each in their order.

    First those that see what a rig shows and move the speed reference, "" in words; then those that set the drive's
    gains as well; last those that are told what the sensors do not show.
    """
    groups: dict[str, list[str]] = {"": [], "with the drive's gains": [], "told what the sensors do not show": []}
    plain, soft, told = groups.values()
    for policy in policies:
        mark = marks.get(policy, "")
        (told if TOLD in mark else soft if SOFT in mark else plain).append(policy)
    return {words: members for words, members in groups.items() if members}


def markdown_table(table: Table, found: Mapping[str, Row], marks: Mapping[str, str], first: str = "policy") -> str:
    """A table in Markdown, a row a policy under the heading `first`; intervals at 95 % behind the values.

    Policies stand in their groups, each but the first under a line that says what it is.
    """
    lines = []
    for words, policies in grouped(found, marks).items():
        if words:
            lines.append([f"*{words}*", *("" for _ in table.columns)])
        for policy in policies:
            cells = [cell(found[policy][column.heading], column.digits, table.signed) for column in table.columns]
            texts = [f"{value} ({interval.replace(' ', ' to ')})" if interval else value for value, interval in cells]
            lines.append([label(policy, marks), *texts])
    return markdown.table([first, *table.headings], lines)


def print_table(title: str, table: Table, found: Mapping[str, Row], marks: Mapping[str, str]) -> None:
    """Print a table in the terminal, groups apart, intervals below the values; needs `rich`, of the extra `agents`."""
    from rich.console import Console
    from rich.table import Table as Grid

    legend = f"; {MARKS}" if any(marks.get(policy) for policy in found) else ""
    grid = Grid(
        title=title,
        caption=f"below each value its 95 % interval; {table.caption}{legend}",
        box=None,
        padding=(0, 1, 0, 0),
        pad_edge=False,
        title_justify="left",
        caption_justify="left",
        title_style="bold",
    )
    grid.add_column("policy", no_wrap=True)
    for column in table.columns:
        grid.add_column(column.heading, justify="right", no_wrap=True)
    for words, policies in grouped(found, marks).items():
        if words:
            grid.add_row()
        for policy in policies:
            cells = [cell(found[policy][column.heading], column.digits, table.signed) for column in table.columns]
            grid.add_row(label(policy, marks), *("\n".join(parts) for parts in cells))
    console = Console(highlight=False)
    console.width = max(console.width, _WIDTH)
    console.print(grid)
    console.print()


def print_suite(
    title: str,
    results: Mapping[str, Scores],
    marks: Mapping[str, str],
    reference: str,
    details: bool = False,
    compared: bool = False,
) -> None:
    """Print the headline of a suite; with `details` also all other tables, with `compared` the differences alone."""
    print_table(title, MAIN, rows(results), marks)
    if details:
        print_table("mitigated by hardness", HARDNESS, rows(results, HARDNESS), marks)
        print_table("other scores", OTHERS, rows(results, OTHERS), marks)
    if details or compared:
        found = difference_rows(results, reference)
        if found:
            print_table(f"less {reference} on the same rigs", DIFFERENCES, found, marks)


def cell(estimate: Estimate, digits: int, signed: bool = False) -> tuple[str, str]:
    """Value and interval as text; the interval with a digit less, rounded outwards, so that it holds the value."""
    if estimate.count == 0:
        return "none", ""
    fewer = max(digits - 1, 1)
    sign = "+" if signed else ""
    value = f"{estimate.value:{sign}.{digits}f}"
    if estimate.low == estimate.high:
        return value, ""
    step = Decimal(1).scaleb(-fewer)
    low, high = (
        f"{Decimal(f'{end:.{_EXACT}f}').quantize(step, rounding):{sign}}"
        for end, rounding in ((estimate.low, ROUND_FLOOR), (estimate.high, ROUND_CEILING))
    )
    return value, f"{low} {high}" if signed else f"{low}-{high}"
