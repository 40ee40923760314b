"""What an evaluation begins with in its output folder: nothing, or results of the same making to go on from.

Results are never written over unasked: only those that the same command would make again, to the last digit.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping
from pathlib import Path
from typing import Any

from drillrig_env.evaluation.histories import Histories
from drillrig_env.evaluation.provenance import provenance
from drillrig_env.evaluation.results import Results
from drillrig_env.evaluation.store import clear, holds_results, read, read_histories
from drillrig_env.markdown import listed

WAYS_OUT = "--overwrite replaces them, --output names another folder"
"""What `drillrig evaluate` offers where results are in the way."""

_UNIQUE = ("command", "reference")
"""Entries of a config that may differ between a run and its continuation."""

_KINDS = {"suites": "suite", "policies": "policy"}


def begin(
    folder: Path,
    config: dict[str, Any],
    resume: bool = False,
    overwrite: bool = False,
    say: Callable[[str], object] = print,
    ways_out: str = WAYS_OUT,
) -> tuple[Results, Histories]:
    """The results and histories to add to, for an evaluation of this `config` into a folder.

    They are empty, and whatever an evaluation has left in the folder is removed, but with `resume` they are
    those of the folder. Without `overwrite` this raises `ValueError` where the folder holds results of another
    making or, without `resume` too, results that this evaluation would not make again. `say` is called
    with a line for histories that cannot be read, which are passed over. `ways_out` are those of the command, in words.
    """
    if overwrite or not holds_results(folder):
        clear(folder)
        return Results(config, provenance()), Histories()
    results = read(folder)
    check_same(results.config, config, folder, ways_out)
    if not resume:
        if lost := _not_made_again(results, config):
            raise ValueError(
                f"{folder} holds results of {lost}, which this command would not make again; "
                f"--resume goes on with them, {ways_out}"
            )
        clear(folder)
        return Results(config, provenance()), Histories()
    try:
        histories = read_histories(folder)
    except ValueError as error:
        say(f"no pictures over time of what was run before: {error}")
        histories = Histories()
    merged = {name: {**config[name], **results.config[name], **config[name]} for name in _KINDS}
    results.config, results.provenance = {**config, **merged}, provenance()
    return results, histories


def check_same(earlier: Mapping[str, Any], now: Mapping[str, Any], folder: Path, ways_out: str = WAYS_OUT) -> None:
    """Raise `ValueError` where results of an earlier config cannot be continued with the one of `now`.

    Suites and policies that only one of them has are no obstacle.
    """
    for name in sorted(
        {**earlier, **now}, key=lambda name: name in _KINDS
    ):  # what suites and policies follow from first
        if name in _UNIQUE:
            continue
        before, after = earlier.get(name), now.get(name)
        if name in _KINDS:
            before, after = dict(before or {}), dict(after or {})
            changed = [key for key in before if key in after and before[key] != after[key]]
            if changed:
                what = _first_change(before[changed[0]], after[changed[0]])
                raise _other(folder, f"{_KINDS[name]} {changed[0]} is not what it was: {what}", ways_out)
        elif before != after:
            raise _other(folder, f"{name} was {before}, and is {after} now", ways_out)


def _other(folder: Path, what: str, ways_out: str) -> ValueError:
    return ValueError(f"{folder} holds results of another making: {what}; {ways_out}")


def _first_change(before: Mapping[str, Any], after: Mapping[str, Any]) -> str:
    keys = [key for key in {**before, **after} if before.get(key) != after.get(key)]
    return f"{keys[0]} was {before.get(keys[0])}, and is {after.get(keys[0])} now"


def _not_made_again(results: Results, config: Mapping[str, Any]) -> str:
    """The policies and suites whose results an evaluation of this config does not make, in words; empty for none."""
    policies = [name for name in results.policies if name not in config["policies"]]
    suites = [f"suite {name}" for name in results.scores if name not in config["suites"]]
    return listed([*policies, *suites]) if policies or suites else ""
