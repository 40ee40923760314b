"""Reference pages from the records themselves: environments, channels, suites, options, files, commands."""

from __future__ import annotations

import inspect
import json
import re
from collections.abc import Mapping
from dataclasses import fields
from typing import Any

from docs.site import commands
from drillrig_env import ENVIRONMENTS, Drive, Fleet, Friction, Reward, Rig, Scenario, Task, observation_table
from drillrig_env.deploy import PolicyFile, shipped_policies
from drillrig_env.deploy import log as deploy_log
from drillrig_env.env.sensors import CHANNELS, SENSORS
from drillrig_env.env.single import DrillRigEnv
from drillrig_env.evaluation import store
from drillrig_env.evaluation.suites import SUITES, Suite, suite
from drillrig_env.markdown import table
from drillrig_env.parameters import default_of, field_rows
from drillrig_env.simulation import SIGNALS
from drillrig_env.toml import section_text

_FIELD = ("Field", "Default", "Unit", "Allowed", "Meaning")
_MOST = 8
"""Entries of a table that an example of a file shows."""


def pages() -> dict[str, str]:
    """Every such page, by name."""
    return {
        "environments": environments(),
        "channels": channels(),
        "options": options(),
        "suites": suites(),
        "files": files(),
        "commands": commands.page(),
    }


_ENVIRONMENTS = """\
# Environment ids

Environments are known to Gymnasium once `drillrig_env` is imported; `drillrig_env:DrillRig-v0` imports it. They are
one environment under several arguments, each of which can be given anew to `gym.make`: [spaces, reward, starts and
infos](/environment.md), [channels](channels.md), [all options](options.md).
"""

_VERSIONS = """\
The number behind `-v` belongs to the results: it rises when the same seed and actions would give other numbers.
"""


def environments() -> str:
    """The ids, in what they differ, and what each version brought."""
    rows = [(f"`{name}`", _said(given)) for name, given in ENVIRONMENTS.items()]
    history = re.split(r"^## Version History\n", inspect.getdoc(DrillRigEnv) or "", flags=re.MULTILINE)[1]
    ids = table(("Id", "Arguments in which it differs"), rows, words=2)
    return "\n".join([_ENVIRONMENTS, ids, "\n## Version history\n", history, "", _VERSIONS])


_CHANNELS = """\
# Observation channels

An observation is an array of channels, each its value less an offset, over a scale, clipped to ±10. The offset
"target" is the speed target. Noise is the standard deviation that a channel has by default, in its unit. Numbers are
those of the chapter's rig; [on another](/environment.md#a-rig-of-your-own) they go by its scales. `sensors=` of an
environment is the name of a set, or a tuple of channels.
"""


def channels() -> str:
    """The sets of channels, and every channel there is."""
    parts = [_CHANNELS]
    for name, sensors in SENSORS.items():
        late = f"{sensors.delay} control step late" if sensors.delay else "without delay"
        parts += [f"## The set `{name}`\n", f"{len(sensors.channels)} channels, {late}.\n", observation_table(name), ""]
    rows = [(f"`{one.name}`", one.meaning, one.unit, one.offset, one.scale, f"{one.noise:g}") for one in CHANNELS]
    head = ("Channel", "Meaning", "Unit", "Offset", "Scale", "Standard noise")
    return "\n".join([*parts, "## Every channel\n", table(head, rows, words=3)]) + "\n"


_OPTIONS = """\
# Options

Options are records of documented fields. Each may be given as a record, as a dictionary of its fields, or, where it
is a rig or a friction, as the path of a TOML file. What is not allowed is refused by name.
"""


def options() -> str:
    """The fields of the records that environments and simulations are given."""
    parts = [_OPTIONS]
    for record in (Task, Scenario, Reward, Drive, Fleet, Rig, Friction):
        rows = [(f"`{row[0]}`", *row[1:]) for row in field_rows(record)]
        parts += [f"## `{record.__name__}`\n", f"{_first_paragraph(record)}\n", table(_FIELD, rows, words=5), ""]
    return "\n".join(parts)


_SUITES = """\
# Suites

A suite is a list of episodes that every policy faces: rigs, starts, loads, noise and seeds are fixed by its name and
the number of rigs. `drillrig evaluate --suite NAME` plays it; [results](/results.md) has what came out. Numbers are
those of the chapter's rig, and counts those of the results.
"""


def suites() -> str:
    """Every suite: who faces what."""
    made = {name: suite(name) for name in SUITES}
    rows = [(f"[`{name}`](#suite-{name})", s.rigs, s.env_id or "any", s.description) for name, s in made.items()]
    words = ("Suite", "Environment", "What it is")
    parts = [_SUITES, table(("Suite", "Episodes", *words[1:]), rows, words), ""]
    return "\n".join(parts + [_suite(one, _first_paragraph(SUITES[name])) for name, one in made.items()])


def _suite(one: Suite, about: str) -> str:
    own = f"The environment has {_said(one.env)}." if one.env else "Noise, delay and slew limit are the environment's."
    drawn = [
        (f"`{item.name}`", _shown(value), item.metadata["unit"], item.metadata["meaning"])
        for item in fields(one.scenario)
        if (value := getattr(one.scenario, item.name)) != default_of(item)
    ]
    head = ("Field of the scenario", "Value, other than by default", "Unit", "Meaning")
    shown = [table(head, drawn, words=4), ""] if drawn else []
    title = f"(suite-{one.name})=\n## `{one.name}`\n"
    return "\n".join([title, about, "", f"Seeds from {one.first_seed:,} on. {own}\n", *shown])


_FILES = """\
# File formats

Files are written whole or not at all. Numbers are in SI units.

## A rig

TOML, a table `[rig]`. Every key must be there; with `base = "chapter"` those that differ from the chapter's are
enough. `drillrig info --write my_rig.toml` writes it; `--rig my_rig.toml` of every command and `rig="my_rig.toml"` of
every function read it. The chapter's:

```toml
{rig}```

## A friction

The same, with a table `[friction]` (`drillrig info --write-friction my_friction.toml`):

```toml
{friction}```

## A simulated run

`drillrig simulate --csv run.csv` writes a column a signal: {signals}.

## A record of a rig

Text, MATLAB, TDMS, Parquet and Excel files as loggers write them: [what is read, and what is refused](/records.md).

## The folder of a calibration

[What the report says](/calibrate.md#what-the-report-says).

## The folder of an evaluation

{evaluation}

## The log of a controller

{log}

## A policy for hardware

An ONNX file with a description as JSON in its metadata; [what the entries mean](/hardware.md#what-the-file-holds). That
of `{policy}`, long lists cut short:

```json
{about}
```
"""


def files() -> str:
    """The files that the project reads and writes."""
    policy = PolicyFile(shipped_policies()[0])
    return _FILES.format(
        rig=section_text(Rig(), "rig"),
        friction=section_text(Friction(), "friction"),
        signals=", ".join(f"`{name}`" for name in SIGNALS),
        evaluation=inspect.getdoc(store),
        log=inspect.getdoc(deploy_log),
        policy=policy.path.stem,
        about=json.dumps(_short(policy.about), indent=1, ensure_ascii=False),
    )


def _first_paragraph(value: Any) -> str:
    return (inspect.getdoc(value) or "").split("\n\n")[0]


def _said(given: Mapping[str, Any]) -> str:
    return ", ".join(f"`{name}={_shown(value)}`" for name, value in given.items())


def _shown(value: Any) -> str:
    return json.dumps(value) if isinstance(value, str) else str(value)


def _short(value: Any) -> Any:
    """A value of which long lists and tables show their beginning."""
    if isinstance(value, dict):
        shown = {key: _short(inner) for key, inner in list(value.items())[:_MOST]}
        return shown | ({"...": f"{len(value)} entries"} if len(value) > _MOST else {})
    if isinstance(value, list) and len(value) > 3:
        return [*map(_short, value[:3]), f"... {len(value)} entries"]
    return value
