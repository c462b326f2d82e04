"""What is told of the fleet as a whole."""

from __future__ import annotations

from talaia.hub.api.schemas.common import CommandShape, Schema

__all__ = ["SharedCommandList", "SharedCommandShape"]


class SharedCommandShape(Schema):
    """A command that some sites have in common, with the narrowest limits of them.

    ``sites``: you may use it there. ``barred``: they have it, and you may only look.
    """

    device: str
    device_name: str
    command: CommandShape
    sites: list[str]
    barred: list[str]


class SharedCommandList(Schema):
    """The commands of all sites that are open to you, those that most of them have first."""

    commands: list[SharedCommandShape]
