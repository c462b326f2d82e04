"""What the gateway is put together of: parts that build themselves, start, run tasks and close."""

from __future__ import annotations

from typing import TYPE_CHECKING

if TYPE_CHECKING:
    from collections.abc import Awaitable, Callable, Mapping

__all__ = ["GatewayPart"]


class GatewayPart:
    """One group of the gateway's objects; `talaia.gateway.app.Gateway` starts and closes it.

    A subclass builds its objects in ``__init__``, of other parts that it is given by name, and
    offers what others need as attributes.
    """

    @property
    def name(self) -> str:
        """What its tasks are called by in the log."""
        return type(self).__name__.removesuffix("Part").lower()

    def start(self) -> None:
        """Begin; called in the order of the table, before any task runs."""

    def tasks(self) -> Mapping[str, Callable[[], Awaitable[None]]]:
        """Name what runs until cancelled; one that ends, however it ends, ends the gateway."""
        return {}

    async def close(self) -> None:
        """Release everything; called in reverse order, after all tasks have ended."""
