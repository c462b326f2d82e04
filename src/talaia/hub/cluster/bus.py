"""The port to the bus, whatever carries it: messages between hubs that may get lost."""

from __future__ import annotations

import enum
from typing import TYPE_CHECKING, Protocol

if TYPE_CHECKING:
    from collections.abc import Callable, Mapping

__all__ = ["Bus", "BusLane"]


class BusLane(enum.StrEnum):
    """Ways that do not wait for each other."""

    URGENT = "u"  # links and pages: STOP, driving, states
    BULK = "b"  # pictures, files, requests


class Bus(Protocol):
    """Carries bytes to whoever listens now; what is lost is lost, and nothing comes late."""

    @property
    def connected(self) -> bool:
        """Whether something can be sent at present."""
        ...

    async def open(
        self,
        subjects: Mapping[BusLane, tuple[str, ...]],
        receive: Callable[[BusLane, str, bytes], None],
        lost: Callable[[], None],
        returned: Callable[[], None],
    ) -> None:
        """Listen from now on; it goes on trying while nobody answers.

        ``receive`` takes what comes; ``lost`` is called when the bus is gone, for what was under
        way then may not have come, and ``returned`` when it is there again. None waits or raises.
        """
        ...

    async def publish(self, lane: BusLane, subject: str, data: bytes) -> None:
        """Send.

        Raises:
            OSError: it cannot be sent; nothing of it is kept for later.

        """
        ...

    async def close(self) -> None:
        """Let go of the bus."""
        ...
