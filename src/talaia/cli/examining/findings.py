"""What `talaia doctor` found, thing by thing."""

from __future__ import annotations

from enum import StrEnum
from typing import NamedTuple

__all__ = ["PartFinding", "PartState"]


class PartState(StrEnum):
    """How something is."""

    OK = "ok"
    # Not there, and nothing else needs it.
    ABSENT = "--"
    # There, and cannot be used as it is.
    PROBLEM = "!!"


class PartFinding(NamedTuple):
    """One thing that was looked for.

    Attributes:
        state: how it is.
        what: its name.
        detail: what was found.
        remedy: what to do; empty where there is nothing to do.

    """

    state: PartState
    what: str
    detail: str
    remedy: str = ""
