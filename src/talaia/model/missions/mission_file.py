"""A mission as a YAML file of its own, to and fro."""

from __future__ import annotations

import re

import msgspec

from talaia.model.errors import DescriptionError, NotReadable
from talaia.model.missions.mission import Mission
from talaia.model.missions.mission_checks import mission_findings
from talaia.model.yaml_text.document import dump_document, read_document

__all__ = [
    "MISSION_FORMAT",
    "convert_mission",
    "dump_mission",
    "load_mission",
    "read_mission_json",
    "write_mission_json",
]

MISSION_FORMAT = 1
MAX_BYTES = 128 * 1024
_decoder = msgspec.json.Decoder(Mission)
_AT = re.compile(r"^(?P<problem>.*?)(?: - at `(?P<path>.*)`)?$", re.DOTALL)


def load_mission(text: str) -> Mission:
    """Make a mission of the text of a file.

    Raises:
        DescriptionError: with the place of the mistake (``$.steps[2].args``).

    """
    if len(text.encode()) > MAX_BYTES:
        raise NotReadable("$", f"the mission is longer than {MAX_BYTES // 1024} KiB")
    document = read_document(text)
    if not isinstance(document, dict) or document.get("mission") != MISSION_FORMAT:
        problem = "this is not the file of a mission"
        raise DescriptionError("$.mission", problem, f"it begins with: mission: {MISSION_FORMAT}")
    return convert_mission({key: value for key, value in document.items() if key != "mission"})


def convert_mission(document: object) -> Mission:
    """Make a mission of plain values; what fits together is checked as well.

    Raises:
        DescriptionError: they have not the shape of one, or do not fit together.

    """
    try:
        mission = msgspec.convert(document, Mission)
    except msgspec.ValidationError as error:
        match = _AT.match(str(error))
        problem, path = (match["problem"], match["path"] or "$") if match else (str(error), "$")
        said = problem[:1].lower() + problem[1:].replace("`", "")
        raise DescriptionError(path, said) from error
    for finding in mission_findings(mission):
        raise DescriptionError(*finding)
    return mission


def dump_mission(mission: Mission) -> str:
    """Write a mission as the text of a file that `load_mission` reads back to an equal one."""
    return dump_document({"mission": MISSION_FORMAT, **msgspec.to_builtins(mission)})


def read_mission_json(text: str) -> Mission:
    """Read a mission as the database holds it."""
    return _decoder.decode(text)


def write_mission_json(mission: Mission) -> str:
    """Write a mission for the database."""
    return msgspec.json.encode(mission).decode()
