"""What the outlets of a power device feed, as values."""

from __future__ import annotations

from talaia.model.base import Shape

__all__ = ["Outlet", "OutletCommand"]


class OutletCommand(Shape, frozen=True, kw_only=True):
    """A command of the same device that takes an outlet's power away.

    Attributes:
        command: its name.
        args: only with these arguments; with none of them it always does.

    """

    command: str
    args: dict[str, float | int | bool | str] = {}


class Outlet(Shape, frozen=True, kw_only=True):
    """One outlet: who hangs on it. What a safe state still needs is not switched off.

    A dome is needed until it is certainly closed, a telescope until it is certainly parked. A
    sensor that says nothing counts as needed.

    Attributes:
        feeds: devices that have no power without it.
        cut_by: the commands that cut its power, if only for a moment. With none given: the command
            of the outlet's own name, when it has one argument that is true or false and is given
            with ``false``, and the command of that name with ``_off`` behind it.

    """

    feeds: tuple[str, ...]
    cut_by: tuple[OutletCommand, ...] = ()
