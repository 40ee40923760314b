"""Flags that commands share: a rig, a friction, a schedule; and flags that are made from documented fields."""

from __future__ import annotations

import argparse
from collections.abc import Callable, Iterable, Mapping, Sequence
from dataclasses import MISSING, fields
from pathlib import Path
from typing import TYPE_CHECKING, Any

from drillrig_env.allowed import COUNT, Kind, Made, Switch
from drillrig_env.parameters import default_of

if TYPE_CHECKING:
    from drillrig_env.engine.contract import Engine


def add_rig_argument(parser: argparse._ActionsContainer) -> None:
    """Add `--rig FILE`: the option `rig` is the rig that the file describes, None without the flag.

    `drillrig info --write FILE` writes a file to begin from. The folder of a calibration will do in place of a file:
    the option `calibration` is then its path, and where the command takes `--friction` and is given none, that is
    the folder's. What cannot be read or holds what is not allowed is a bad argument.
    """
    parser.set_defaults(calibration=None)
    parser.add_argument(
        "--rig",
        action=_TakeRig,
        metavar="FILE",
        help="a rig of your own, a TOML file with the table [rig], the folder of a calibration, or a name: laboratory, "
        "field_2500m (default: the chapter's; `drillrig info --write FILE` writes one to begin from)",
    )


def add_friction_argument(parser: argparse._ActionsContainer, default: str = "the chapter's") -> None:
    """Add `--friction FILE`: the option `friction` is what the file describes, None without the flag.

    `default` says in words what None stands for.
    """
    from drillrig_env.friction import Friction

    parser.add_argument(
        "--friction",
        type=_reader(Friction.of),
        metavar="FILE",
        help=f"a friction of your own, a TOML file with the table [friction] (default: {default})",
    )


def add_engine_arguments(parser: argparse._ActionsContainer, pieces: str, default: str = "1") -> None:
    """Add `--on WHERE` and `--jobs N`, which `engine_of` reads: where pieces of work are done, and how many at a time.

    `pieces` says in the plural what they are, `default` how many this machine does at a time.
    """
    from drillrig_env.engine.choice import ALLOWED, LOCAL

    parser.add_argument(
        "--on",
        metavar="WHERE",
        default=LOCAL,
        help=f"where {pieces} are done: {ALLOWED}; see docs/scale.md (default: local)",
    )
    parser.add_argument(
        "--jobs",
        type=of_kind(COUNT),
        metavar="N",
        help=f"{pieces} at a time (default: {default}, on Ray as many as it has cores)",
    )


def engine_of(options: argparse.Namespace, jobs: int | None = None) -> Engine:
    """The engine that `--on` and `--jobs` name, `jobs` at a time on this machine where the command line does not say.

    Raises as `drillrig_env.engine.engine_at`.
    """
    from drillrig_env.engine.choice import LOCAL, engine_at

    own = jobs if options.on == LOCAL else None
    return engine_at(options.on, options.jobs or own)


def add_schedule_argument(
    parser: argparse._ActionsContainer, flag: str, unit: str, about: str, **settings: Any
) -> None:
    """Add a flag for what changes with time: a number, or `time:value` pairs (s, `unit`), as `simulate` takes them."""
    parser.add_argument(flag, nargs="+", type=step, metavar=unit.upper(), help=about, **settings)


def step(text: str) -> tuple[float, float]:
    """One step of a schedule, "time:value" as (time in s, value); a value alone counts from 0 s on."""
    time, _, value = text.rpartition(":")
    try:
        return float(time or 0), float(value)
    except ValueError:
        raise argparse.ArgumentTypeError(f"{text!r} is not allowed; allowed: a number, or time:value") from None


def of_kind(kind: Kind, unit: str = "") -> Callable[[str], Any]:
    """What `add_argument(type=...)` takes for a kind of value; what is not allowed becomes one sentence."""

    def read(text: str) -> Any:
        try:
            return kind.parse(text)
        except ValueError as error:
            allowed = f"{kind} {unit}".rstrip()
            sentence = str(error) if isinstance(kind, Made) else f"{text!r} is not allowed; allowed: {allowed}"
            raise argparse.ArgumentTypeError(sentence) from None

    return read


def add_fields(
    parser: argparse._ActionsContainer,
    record: type,
    skip: Iterable[str] = (),
    flags: Mapping[str, Sequence[str]] | None = None,
) -> None:
    """Add a flag for every field of a record, `--speed-target` for `speed_target`, with its meaning as help.

    `flags` holds, by name, those of fields whose flag is another. What is not given does not show in the options;
    `given_fields` collects what is.
    """
    for item in fields(record):
        if item.name in skip:
            continue
        meta, default = item.metadata, default_of(item)
        shown = meta["none"] if default is None else default
        unit = f" {meta['unit']}" if meta["unit"] and default is not None else ""
        settings: dict[str, Any] = {"dest": item.name, "default": argparse.SUPPRESS}
        settings["help"] = meta["meaning"] + ("" if default is MISSING else f" (default: {shown}{unit})")
        if isinstance(meta["allowed"], Switch):
            settings["action"] = argparse.BooleanOptionalAction
        else:
            settings["type"] = of_kind(meta["allowed"], meta["unit"])
            settings["metavar"] = (meta["unit"] or item.name).upper()
        parser.add_argument(*(flags or {}).get(item.name, (f"--{item.name.replace('_', '-')}",)), **settings)


def given_fields(options: argparse.Namespace, record: type) -> dict[str, Any]:
    """The fields of a record that the command line gives, by name."""
    return {item.name: getattr(options, item.name) for item in fields(record) if hasattr(options, item.name)}


class _TakeRig(argparse.Action):
    """Read a rig, and from the folder of a calibration the friction too."""

    def __call__(
        self, parser: argparse.ArgumentParser, namespace: argparse.Namespace, values: Any, option_string: Any = None
    ) -> None:
        from drillrig_env.friction import Friction
        from drillrig_env.rig import RIGS, Rig

        if namespace.calibration is not None:  # whose friction may be taken already
            raise argparse.ArgumentError(self, "given twice; allowed: one folder of a calibration")
        try:
            namespace.rig = Rig.of(values)
            if values in RIGS or not Path(values).is_dir():
                return
            namespace.calibration = Path(values)
            if "friction" in namespace and namespace.friction is None:
                namespace.friction = Friction.of(values)
        except (ValueError, OSError) as error:
            raise argparse.ArgumentError(self, str(error)) from None


def _reader(read: Callable[[str], Any]) -> Callable[[str], Any]:
    """`read`, which reads a file, as `add_argument(type=...)` takes it."""

    def reader(path: str) -> Any:
        try:
            return read(path)
        except (ValueError, OSError) as error:
            raise argparse.ArgumentTypeError(str(error)) from None

    return reader
