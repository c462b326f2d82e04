"""What the routes of tiles give."""

from __future__ import annotations

from typing import Literal

from pydantic import BaseModel, Field

from talaia.model.roles import SignalRole  # noqa: TC001 - pydantic reads it

__all__ = ["BrokenTileShape", "TileList", "TileShape", "TileSignalShape"]


class TileSignalShape(BaseModel):
    """Which signal of a device a tile reads; what is empty fits any."""

    name: str = Field(description="the tile's own name for it")
    type: str
    unit: str
    id: str
    role: SignalRole | Literal[""]


class TileShape(BaseModel):
    """A web component that a device's page shows where the device has all its signals."""

    name: str = Field(description="of its folder")
    title: str
    module: str = Field(description="path of the JavaScript module at this hub")
    device: str = Field(description="the kind of device that it is for; empty: every kind")
    signals: list[TileSignalShape]


class BrokenTileShape(BaseModel):
    """One that cannot be used, and why."""

    name: str
    problem: str


class TileList(BaseModel):
    """The tiles in the hub's folder of extensions."""

    api: int = Field(description="version of the interface for tiles")
    tiles: list[TileShape]
    broken: list[BrokenTileShape] = Field(description="for who may manage the whole hub")
