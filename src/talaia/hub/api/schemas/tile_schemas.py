"""What the routes of tiles give."""

from __future__ import annotations

from typing import Literal

from pydantic import BaseModel, Field

from talaia.extensions.tile_folder import BrokenTile  # noqa: TC001 - pydantic reads it
from talaia.model.closed_lists import DeviceKind, SignalType  # noqa: TC001 - pydantic reads them
from talaia.model.roles import SignalRole  # noqa: TC001 - pydantic reads it

__all__ = ["TileList", "TileShape", "TileSignalShape"]


class TileSignalShape(BaseModel):
    """Which signal of a device a tile reads; what is empty fits any."""

    name: str = Field(description="the tile's own name for it")
    type: SignalType | Literal[""]
    unit: str
    id: str
    role: SignalRole | Literal[""]


class TileShape(BaseModel):
    """A web component that a device's page shows where the device has all its signals."""

    name: str = Field(description="of its folder")
    title: str
    module: str = Field(description="path of the JavaScript module at this hub")
    device: DeviceKind | Literal[""] = Field(
        description="the kind of device that it is for; empty: every kind"
    )
    signals: list[TileSignalShape]


class TileList(BaseModel):
    """The tiles in the hub's folder of extensions."""

    api: int = Field(description="version of the interface for tiles")
    tiles: list[TileShape]
    broken: list[BrokenTile] = Field(description="for who may manage the whole hub")
