"""What the command line asks to be played again: a run that was kept, or a row of a results.csv."""

from __future__ import annotations

import csv
from collections.abc import Mapping
from pathlib import Path
from typing import Any

import numpy as np

from drillrig_env.course import COLUMNS, Course
from drillrig_env.env.core import EpisodeBatch
from drillrig_env.env.generators import first_uniforms
from drillrig_env.env.recorded import Recorded, RecordedLane
from drillrig_env.env.scenario import STARTS
from drillrig_env.evaluation.conditions import Conditions
from drillrig_env.evaluation.contestants import contestant_of
from drillrig_env.evaluation.runner import play
from drillrig_env.evaluation.store import read
from drillrig_env.evaluation.suites import OF_ONE_RIG, suite
from drillrig_env.parameters import closest
from drillrig_env.policy import channels_of, drive_of, find_policy, is_exact
from drillrig_env.rig import Rig
from drillrig_env.room.setting import Setting
from drillrig_env.room.strangers import named
from drillrig_env.scales import Scales


def run_of(place: str) -> Recorded:
    """The run in a file, or of a row of a results.csv, FILE:ROW, whose first row is 1; that is played for it.

    Raises `ValueError` for what is neither, and for a row that cannot be played here, whatever its policy raises among
    it; `FileNotFoundError` where there is no such file.
    """
    file, colon, row = place.rpartition(":")
    if colon and file.endswith(".csv") and row.isdecimal():
        return _of_row(Path(file), int(row))
    if place.endswith(".csv"):
        raise ValueError(f"--replay {place} says no row; allowed: FILE:ROW, such as {place}:1 for the first one")
    return Recorded.read(place)


def _of_row(file: Path, number: int) -> Recorded:
    """The run of a row: the policy plays the episode again."""
    row, config = _row(file, number), read(file.parent).config
    if row["suite"] not in OF_ONE_RIG:
        raise ValueError(f"{file}, row {number}: suite {row['suite']!r} is not played here; allowed: {OF_ONE_RIG}")
    rig, largest = Rig.of(config.get("rig")), config.get("largest_reference")
    if largest is not None or config.get("friction") is not None:
        raise ValueError(f"{file}: results with a largest reference or a friction of their own are not played here")
    episode, scales = int(row["episode"]), Scales.of(rig)
    faced = suite(row["suite"], max(episode + 1, int(config["suites"][row["suite"]]["rigs"])), scales).only(episode)
    held = Conditions(config["env"], config["noise"], _pair(config["delay"]), rig)
    whose = f"{file}, row {number}: {row['policy']}"
    with named(whose):
        source = find_policy(row["policy"])
    if row["seed"] not in source.makers:
        raise ValueError(
            f"{file}, row {number}: {row['policy']} has no seed {row['seed']!r}; allowed: {[*source.makers]}"
        )
    with named(whose):
        contestant = contestant_of(source, held, row["policy"])
        policy = contestant.members[row["seed"]](faced)
        arguments: dict[str, Any] = {**contestant.env, **faced.env, "drive": drive_of(policy)}
    if is_exact(policy):
        arguments.update(sensors=channels_of(policy), noise=0.0, delay=0)
    core = EpisodeBatch(1, scenario=faced.scenario, threads=1, **arguments)
    core.reset(np.zeros(1, dtype=np.intp), first_uniforms(faced.first_seed, 1), faced.groups[0][1])
    start, taken = STARTS[int(core.episodes["start"][0])], np.empty((core.steps, 1, 1), dtype=np.float32)
    asked = faced.groups[0][1].get("start", start)
    first = [float(core.episodes[name][0]) for name in COLUMNS]
    table = np.empty((core.steps, len(COLUMNS)))
    with named(whose):
        for step in play(policy, core, faced.first_seed, taken):
            table[step] = [core.episodes[name][0] for name in COLUMNS]
    if list(table[0]) != first:
        raise ValueError(f"{file}, row {number}: the force steps in the first moment, which no run here can tell")
    new = np.concatenate([[True], np.any(table[1:] != table[:-1], axis=1)])
    task = core.task
    time = task.control_period * np.flatnonzero(new).astype(float)
    course = Course(time, **dict(zip(COLUMNS, table[new].T, strict=True)))
    noise = task.sensors.noise if task.noise is None else task.noise
    if isinstance(noise, Mapping):
        raise ValueError(f"{file}: results with noise of single channels are not played here")
    delay = int(core.episodes["delay"][0])
    lane = RecordedLane(row["policy"], task.sensors.names, noise, delay, task.drive, taken[:, 0, 0])
    setting = Setting().as_dict()
    return Recorded(rig, "exponential", course, faced.first_seed, str(asked), {"A": lane}, setting, task.slew_limit)


def _row(file: Path, number: int) -> dict[str, str]:
    """A row of a results.csv by its columns. `ValueError` for one that is not there."""
    try:
        with file.open(newline="", encoding="utf-8") as lines:
            rows = csv.DictReader(lines)
            for place, row in enumerate(rows, 1):
                if place == number and {"suite", "policy", "seed", "episode"} <= set(row):
                    return row
    except FileNotFoundError as error:
        raise FileNotFoundError(f"--replay: there is no file {file}") from error
    except (OSError, UnicodeDecodeError, csv.Error) as error:
        raise ValueError(f"--replay: {file} is no file that can be read: {error}") from error
    raise ValueError(f"--replay: {file} has no row {number} of results; {closest(str(number), ['1 to its last one'])}")


def _pair(delay: Any) -> tuple[int, int]:
    low, high = delay
    return int(low), int(high)
