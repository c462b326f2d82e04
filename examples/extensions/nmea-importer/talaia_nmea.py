"""An importer of weather logs in NMEA 0183: ``$WIMDA`` sentences with a time before each.

    2026-03-01T20:15:00Z $WIMDA,29.9,I,1.0133,B,12.3,C,,C,61.0,,5.1,C,210.0,T,209.0,M,6.2,N,3.2,M*1C

A value goes into the channel that is named like it (``weather/temperature``), or that the person
names: ``--column temperature=mast/air``.
"""

from __future__ import annotations

import datetime as dt
import re
from typing import TYPE_CHECKING

from talaia.extend.importer import ImportedSample, ImporterExtension, ImportProblem

if TYPE_CHECKING:
    from collections.abc import Iterator
    from pathlib import Path

    from talaia.extend.importer import ImportRequest

# Where each value stands in the sentence, and what makes it of the signal's usual unit.
FIELDS = {
    "pressure": (3, 1000.0),  # bar to hPa
    "temperature": (5, 1.0),
    "humidity": (9, 1.0),
    "dew_point": (11, 1.0),
    "wind_direction": (13, 1.0),
    "wind_speed": (19, 1.0),
}
_LINE = re.compile(r"(\S+) \$(([A-Z]{2}MDA),[^*]*)\*([0-9A-Fa-f]{2})\s*\Z")


def recognizes(path: Path, begin: bytes) -> bool:
    """Tell by the first line."""
    return _LINE.match(begin.partition(b"\n")[0].decode("ascii", "replace")) is not None


def read(request: ImportRequest) -> Iterator[ImportedSample]:
    """Give the values of each sentence; one that was damaged on its way is left out."""
    channels = _channels(request)
    damaged = 0
    with request.path.open(encoding="ascii", errors="replace") as file:
        for number, line in enumerate(file, 1):
            if not line.strip():
                continue
            found = _LINE.match(line)
            if found is None:
                raise ImportProblem(f"line {number}", "expected a time and an MDA sentence")
            time, sentence, _, checksum = found.groups()
            if _checksum(sentence) != int(checksum, 16):
                damaged += 1
                continue
            time_us = _time_us(time, number)
            words = sentence.split(",")
            for name, address in channels.items():
                at, scale = FIELDS[name]
                if at < len(words) and words[at]:
                    value = _number(words[at], number)
                    yield ImportedSample(address, time_us, value * scale)
    if damaged:
        request.note(f"{damaged} sentences have a wrong checksum and were left out")


def _channels(request: ImportRequest) -> dict[str, str]:
    channels = {}
    for name in FIELDS:
        like_it = [each for each in request.channels if each.rpartition("/")[2] == name]
        if name in request.names:
            channels[name] = request.names[name]
        elif len(like_it) == 1:
            channels[name] = like_it[0]
        else:
            why = "several channels have this name" if like_it else "no channel has this name"
            request.skip(name, f"{why}; name one with --column {name}=ADDRESS")
    return channels


def _checksum(sentence: str) -> int:
    total = 0
    for letter in sentence:
        total ^= ord(letter)
    return total


def _time_us(text: str, line: int) -> int:
    try:
        moment = dt.datetime.fromisoformat(text)
    except ValueError as error:
        raise ImportProblem(f"line {line}", f"{text!r} is no time") from error
    if moment.tzinfo is None:
        raise ImportProblem(f"line {line}", f"{text!r} names no zone", "end it with Z")
    return round(moment.timestamp() * 1e6)


def _number(text: str, line: int) -> float:
    try:
        return float(text)
    except ValueError as error:
        raise ImportProblem(f"line {line}", f"{text!r} is no number") from error


extension = ImporterExtension(
    api=1,
    summary="weather logs of NMEA 0183 (MDA sentences)",
    title="NMEA weather log",
    recognizes=recognizes,
    read=read,
)
