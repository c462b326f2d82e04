"""JSON bodies of units: in which one a value is shown, and what a person may choose."""

from __future__ import annotations

from typing import Annotated

from pydantic import Field, StringConstraints

from talaia.hub.api.schemas.common import Schema
from talaia.model.units.unit_text import LONGEST_UNIT

__all__ = ["UnitChoice", "UnitChoiceAsk", "UnitChoiceList"]

# Of one person; more units than any site has.
_MOST = 40
_Unit = Annotated[str, StringConstraints(min_length=1, max_length=LONGEST_UNIT)]


class UnitChoice(Schema):
    """A unit of values that you may see, and in which others they can be shown.

    ``name`` is in English words; ``sites`` have values in it. ``shown`` is your choice, or empty.
    """

    unit: str
    name: str
    sites: list[str]
    shown: str
    choices: list[str]


class UnitChoiceList(Schema):
    """Your choices; units that can be shown in no other are left out."""

    units: list[UnitChoice]


class UnitChoiceAsk(Schema):
    """What to show in what: stored unit to shown unit. What is not named is as the site has it."""

    shown: dict[_Unit, _Unit] = Field(max_length=_MOST)
