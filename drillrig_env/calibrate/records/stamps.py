"""Time stamps, as text or as dates: the seconds between them."""

from __future__ import annotations

import re

import numpy as np
import numpy.typing as npt

from drillrig_env.arrays import FloatArray

_DAY = 86400.0  # s
_DATE = "S12"  # a date as it is written

_STAMP = re.compile(
    r"(?:(?P<date>\d{1,4}[-/.]\d{1,2}[-/.]\d{1,4})(?:[T ,]\s*))?"
    r"(?P<hours>\d{1,3}:)?(?P<minutes>\d{1,2}):(?P<seconds>\d{1,2}(?:[.,:]\d+)?)"
    r"\s*(?P<half>[AaPp][Mm])?\s*(?P<zone>Z|UTC|[+-]\d{2}:?\d{2})?",
    re.ASCII,
)


def is_stamp(cell: str) -> bool:
    """Whether a cell is a date, a clock time or both, such as 2024-05-17T10:00:00.25, 17.05.2024 10:00 or 10:00:00."""
    return ":" in cell and _STAMP.fullmatch(cell) is not None


def seconds_of_dates(dates: npt.NDArray[np.datetime64]) -> FloatArray:
    """The seconds since the first date, NaN where there is none."""
    known = dates[~np.isnat(dates)]
    if len(known) == 0:
        return np.full(len(dates), np.nan)
    seconds = (dates - known[0]) / np.timedelta64(1, "ns")
    return np.asarray(np.where(np.isnat(dates), np.nan, seconds * 1e-9))


def seconds_of_stamps(stamps: npt.NDArray[np.bytes_]) -> FloatArray:
    """The seconds since midnight before the first stamp, NaN where there is none, of stamps of shape (n,).

    A clock that goes past midnight without a date goes on into the next day. Of a day and a month that can be either,
    the one is the day with which the record is shorter.
    """
    clock, dates = np.empty(len(stamps)), np.empty(len(stamps), dtype=_DATE)
    lengths = np.char.str_len(stamps)
    for length in np.unique(lengths):  # a whole second may be written without a fraction
        alike = lengths == length
        some = stamps[alike].astype(f"S{max(length, 1)}")
        dates[alike], clock[alike] = _in_columns(some) or _one_by_one(some)
    if not np.any(dates):
        return _past_midnight(clock)
    spans = []
    for month_first in (False, True):
        days = _days(dates, month_first)
        if days is not None:
            seconds = clock + (days - np.nanmin(days)) * _DAY
            spans.append((float(np.nanmax(seconds) - np.nanmin(seconds)), seconds))
    return min(spans, key=lambda span: span[0])[1] if spans else np.full(len(clock), np.nan)


def _one_by_one(stamps: npt.NDArray[np.bytes_]) -> tuple[npt.NDArray[np.bytes_], FloatArray]:
    """Dates, b"" where there is none, and seconds since midnight, NaN where a cell is no stamp."""
    parts = [_STAMP.fullmatch(cell) if ":" in cell else None for cell in np.char.decode(stamps, errors="replace")]
    clock = np.array([np.nan if part is None else _clock(part) for part in parts])
    return np.array([(part["date"] if part else "") or "" for part in parts], dtype=_DATE), clock


def _in_columns(stamps: npt.NDArray[np.bytes_]) -> tuple[npt.NDArray[np.bytes_], FloatArray] | None:
    """The same of stamps that all have their digits in the same places, without a loop over them; None for others."""
    width = stamps.dtype.itemsize
    characters = np.ascontiguousarray(stamps).view(np.uint8).reshape(len(stamps), width)
    part = _STAMP.fullmatch(stamps[0].decode(errors="replace"))
    if part is None or not part["hours"] or part["half"] or ":" in part["seconds"]:
        return None
    digit = (characters[0] >= ord("0")) & (characters[0] <= ord("9"))
    numbers = characters - np.uint8(ord("0"))  # a character that is no digit is larger than 9
    same = ~digit  # and the zone, if there is one
    same[slice(*part.span("zone"))] = True
    if not np.all((numbers <= 9) == digit) or not np.all(characters[:, same] == characters[0, same]):
        return None

    def read(begin: int, end: int) -> FloatArray:
        places = [k for k in range(begin, end) if digit[k]]
        return np.asarray(numbers[:, places] @ 10.0 ** np.arange(len(places) - 1, -1, -1))

    seconds = read(*part.span("seconds")) / 10.0 ** len(re.split("[.,]", f"{part['seconds']}.")[1])
    clock = 3600.0 * read(*part.span("hours")) + 60.0 * read(*part.span("minutes")) + seconds
    if part["date"] is None:
        return np.zeros(len(stamps), dtype=_DATE), clock
    begin, end = part.span("date")
    return np.ascontiguousarray(characters[:, begin:end]).view(f"S{end - begin}").ravel(), clock


def _clock(part: re.Match[str]) -> float:
    seconds = part["seconds"]
    if ":" in seconds:  # some loggers part milliseconds by a colon
        whole, _, thousandths = seconds.partition(":")
        seconds = f"{whole}.{thousandths.zfill(3)}"
    hours, minutes = int((part["hours"] or "0").rstrip(":")), int(part["minutes"])
    if part["date"] and not part["hours"]:  # a clock beside a date has hours, whatever it leaves out
        hours, minutes, seconds = minutes, int(float(seconds.replace(",", "."))), "0"
    if part["half"]:
        hours = hours % 12 + 12 * (part["half"].lower() == "pm")
    ahead = 0.0
    if (zone := part["zone"]) and zone[0] in "+-":
        ahead = float(f"{zone[0]}1") * (3600.0 * int(zone[1:3]) + 60.0 * int(zone[-2:]))
    return 3600.0 * hours + 60.0 * minutes + float(seconds.replace(",", ".")) - ahead


def _days(dates: npt.NDArray[np.bytes_], month_first: bool) -> FloatArray | None:
    """The days of some dates since 1970, NaN where there is none; None where they cannot be read this way."""
    known, which = np.unique(dates, return_inverse=True)
    found = []
    for date in known:
        numbers = [int(word) for word in re.findall(r"\d+", date.decode())]
        if not numbers:
            found.append(np.nan)
            continue
        year, month, day = numbers
        if year <= 31:
            day, month, year = (month, year, day) if month_first else (year, month, day)
        try:
            written = f"{year + 2000 * (year < 100):04d}-{month:02d}-{day:02d}"
            found.append(float(np.datetime64(written, "D").astype(int)))
        except ValueError:
            return None
    return np.array(found)[which]


def _past_midnight(clock: FloatArray) -> FloatArray:
    known = ~np.isnan(clock)
    seconds = clock.copy()
    falls = np.diff(clock[known], prepend=clock[known][:1]) < -_DAY / 2
    seconds[known] += _DAY * np.cumsum(falls)
    return seconds
