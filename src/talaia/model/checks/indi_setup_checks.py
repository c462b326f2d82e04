"""Cross-checks of what is written to INDI drivers after each connect; part of `check`."""

from __future__ import annotations

import math
import re
from typing import TYPE_CHECKING

from talaia.model.checks.identifiers import Finding

if TYPE_CHECKING:
    from collections.abc import Iterator

    from talaia.model.site import Device

__all__ = ["setup_findings"]

# libindi's MAXINDINAME.
_MAX_NAME = 64
# What moves, exposes or hides weather is for commands: those pass the interlocks, a setup does not.
_ACTS = re.compile(
    r"(ABS|REL)_|.*(MOTION|PARK|SHUTTER|FLAP|EXPOSURE|GOTO|HOMING|OVERRIDE|TIMED_GUIDE|AUTOSYNC)"
    r"|(EQUATORIAL|HORIZONTAL)(_EOD)?_COORD|TARGET_EOD_COORD|CONNECTION|.*TRACK_STATE"
    r"|FILTER_SLOT|CCD_TEMPERATURE|CCD_COOLER",
)
# Named like what moves, and only says how.
_MOVES_NOT = re.compile(r"DOME_SHUTTER_PARK_POLICY|TELESCOPE_PARK_(OPTION|POSITION)|DOME_POLICY")


def setup_findings(where: str, device: Device) -> Iterator[Finding]:
    """List what does not fit in a device's ``setup``."""
    if device.setup and not device.indi:
        problem = "only INDI drivers are set up"
        yield Finding(f"{where}.setup", problem, "write indi: with its name, or leave setup out")
    for name, elements in device.setup.items():
        at = f"{where}.setup.{name}"
        if not name.strip() or len(name) > _MAX_NAME:
            yield Finding(at, "it is not the name of an INDI property", "as WEATHER_UPDATE")
        # The exceptions have to fit wholly: a longer name is another property.
        elif _ACTS.match(name) and not _MOVES_NOT.fullmatch(name):
            problem = "a setup moves nothing: it passes no interlock"
            yield Finding(at, problem, "write a command for it")
        if not elements:
            yield Finding(at, "no element is named", "write: {PERIOD: 5}")
        for element, value in elements.items():
            if not element.strip() or len(element) > _MAX_NAME:
                yield Finding(f"{at}.{element}", "it is not the name of an INDI element")
            if isinstance(value, float) and not math.isfinite(value):
                yield Finding(f"{at}.{element}", f"expected a finite number, found {value}")
