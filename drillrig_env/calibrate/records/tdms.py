"""TDMS files, as LabVIEW writes them: channels with their units, and times of their own or of a waveform."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

from drillrig_env.calibrate.records.quantities import guess
from drillrig_env.calibrate.records.raw import RawTable, column, of_one_length
from drillrig_env.extras import missing

_UNIT = ("unit_string", "NI_UnitDescription")
"""Properties of a channel that may hold its unit."""


def read_tdms(source: str) -> RawTable:
    """The channels of a TDMS file, by name. Where none is a time, the clock of the first waveform is it.

    Raises `ValueError` where it cannot be read, and `ImportError` without npTDMS.
    """
    try:
        from nptdms import TdmsFile
    except ModuleNotFoundError as error:
        raise missing(f"{source}: a TDMS file", "npTDMS", "records") from error
    try:
        content = TdmsFile.read(source)
    except (ValueError, KeyError, EOFError, IndexError) as error:
        raise ValueError(f"{source}: is no TDMS file that can be read ({error})") from error
    channels = [channel for group in content.groups() for channel in group.channels() if len(channel) > 1]
    columns = [column(channel.name, channel[:], _unit(channel.properties)) for channel in channels]
    clocked = [channel for channel in channels if channel.properties.get("wf_increment")]
    if clocked and not any((found := guess(one.name)) and found.quantity == "time" for one in columns):
        columns.insert(0, column("time", clocked[0].time_track(), "s"))
    columns, note = of_one_length(source, columns)
    return RawTable(source, columns, "sample", None, ("TDMS file", *([note] if note else [])))


def _unit(properties: Mapping[str, Any]) -> str:
    return next((str(properties[key]) for key in _UNIT if properties.get(key)), "")
