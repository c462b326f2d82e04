"""The adapter of a site that has no robot connection: hears nothing, refuses all."""

from __future__ import annotations

import asyncio
from typing import TYPE_CHECKING

from talaia.gateway.adapters.undriven_adapter import UndrivenAdapter
from talaia.gateway.ports import CommandOutcome
from talaia.wire.frames import CommandPhase

if TYPE_CHECKING:
    from collections.abc import Callable, Collection

    from talaia.gateway.ports import ChannelReading
    from talaia.wire.frames import Scalar

__all__ = ["NullAdapter"]


class NullAdapter(UndrivenAdapter):
    """An `Adapter`."""

    async def run(self) -> None:
        """Do nothing until cancelled."""
        # Never set: the task lasts until it is cancelled.
        await asyncio.Event().wait()

    def watch(self, streams: Collection[str]) -> None:
        """Take no pictures."""

    def latest(self, address: str) -> ChannelReading | None:
        """Give nothing."""
        return None

    def act(
        self,
        device: str,
        command: str,
        fields: dict[str, Scalar],
        done: Callable[[CommandOutcome], None],
    ) -> Callable[[], None] | None:
        """Refuse."""
        done(CommandOutcome(CommandPhase.REFUSED, "this site has no robot connection"))
        return None

    def reconnect(self, device: str, done: Callable[[CommandOutcome], None]) -> None:
        """Say that there is nothing to connect to."""
        done(CommandOutcome(CommandPhase.FAILED, "this site has no robot connection"))
