"""What a site can do for a request, as its form offers it."""

from __future__ import annotations

from talaia.hub.api.schemas.common import Schema
from talaia.model.observing.requests import ImageType  # noqa: TC001 - pydantic reads it

__all__ = ["AbilitiesShape", "FieldShape", "SettingRangeShape"]


class SettingRangeShape(Schema):
    """What a number of the camera may be; none: no limit is described."""

    low: float | None
    high: float | None


class FieldShape(Schema):
    """How much of the sky a picture shows (°).

    ``position_angle``: where its top points, from north through east; ``rotates``: a request may
    ask for another.
    """

    width: float
    height: float
    position_angle: float
    rotates: bool


class AbilitiesShape(Schema):
    """What can be asked of a site; a number without a range cannot be chosen.

    ``filters`` is none where there is no wheel: then any name is a note. ``exposure`` in s, of a
    frame of a target. Requests may be held to a limit of seeing or clouds where these are measured.
    """

    filters: list[str] | None
    types: list[ImageType]
    exposure: SettingRangeShape
    binning: SettingRangeShape | None
    gain: SettingRangeShape | None
    guides: bool
    field: FieldShape | None
    measures_seeing: bool
    measures_clouds: bool
