"""What the hub expects of the parts it is given."""

from __future__ import annotations

from typing import TYPE_CHECKING, Protocol

if TYPE_CHECKING:
    from collections.abc import Sequence

    from talaia.hub.history.series import Series
    from talaia.wire.columns import Columns

__all__ = ["History"]


class History(Protocol):
    """Samples for good. Times are microseconds since the epoch (UTC)."""

    async def open(self) -> None:
        """Make ready; called once, after the tables are up to date."""
        ...

    async def close(self) -> None:
        """Let go of everything; what was appended is already safe."""
        ...

    async def append(
        self, site: str, boot: str, first: int, addresses: Sequence[str], columns: Columns
    ) -> None:
        """Store samples for good; durable on return, and twice the same changes nothing."""
        ...

    async def record_gap(
        self,
        site: str,
        boot: str,
        first: int,
        last: int,
        from_us: int,
        to_us: int,
        reason: str,
    ) -> None:
        """Store that samples ``first`` to ``last`` are lost."""
        ...

    async def stored_below(self, site: str, boot: str) -> int:
        """Give the first sequence number that is neither stored nor in a recorded gap."""
        ...

    async def read(
        self, site: str, addresses: Sequence[str], from_us: int, to_us: int, width: int
    ) -> list[Series]:
        """Read a window; at most two points a pixel of ``width``, spikes kept."""
        ...

    async def last(self, site: str, addresses: Sequence[str]) -> dict[str, tuple[int, float, str]]:
        """Give the newest stored sample of each address: time, value, text."""
        ...
