"""An extension's adapter as a gateway runs it: its process, and what comes of it."""

from __future__ import annotations

import asyncio
from contextlib import asynccontextmanager, suppress
from typing import TYPE_CHECKING

from patience import PATIENCE_S

from talaia.clock import SystemClock
from talaia.gateway.adapters.catalog import adapter_of
from talaia.gateway.adapters.connection_scope import scopes_of
from talaia.gateway.errors import AdapterLost
from talaia.gateway.ports import AdapterContext
from talaia.model.checks.site_checks import raise_first
from talaia.model.yaml_text.load import load_site

if TYPE_CHECKING:
    from collections.abc import AsyncIterator, Callable
    from pathlib import Path

    from talaia.gateway.ports import Adapter, CommandOutcome
    from talaia.wire.columns import Columns


class Bench:
    """Takes what an adapter says.

    Attributes:
        values: the newest of each address.
        lost: why each run ended.
        events: what was written down.
        away: devices that do not answer, and why.

    """

    def __init__(self, text: str, folder: Path) -> None:
        """Make the adapter of the one connection of a description."""
        self.site = raise_first(load_site(text))
        (self.share,) = scopes_of(self.site)
        self.values: dict[str, float | str] = {}
        self.lost: list[str] = []
        self.events: list[tuple[str, str]] = []
        self.away: dict[str, str] = {}
        self.ups = 0
        self.news = asyncio.Event()
        context = AdapterContext(SystemClock(), self, None, self, folder)  # type: ignore[arg-type]
        self.adapter: Adapter = adapter_of(self.share, context, self)

    def put_samples(self, columns: Columns) -> None:
        address = {number: each for each, number in self.share.channel.items()}
        for at, channel in enumerate(columns.channel.tolist()):
            self.values[address[channel]] = columns.texts.get(at, columns.value[at])
        self.news.set()

    def report_event(self, kind: str, message: str, **_more: object) -> None:
        self.events.append((kind, message))
        self.news.set()

    def up(self) -> None:
        self.ups += 1
        self.news.set()

    def device(self, device: str, *, there: bool, why: str = "", sure: bool = True) -> None:
        self.away.pop(device, None) if there else self.away.update({device: why})
        self.news.set()

    async def until(self, holds: Callable[[], object]) -> None:
        async with asyncio.timeout(PATIENCE_S):
            while not holds():
                self.news.clear()
                await self.news.wait()

    async def do(self, device: str, command: str, **arguments: float | str) -> CommandOutcome:
        described = self.site.devices[device].commands[command]
        done: asyncio.Future[CommandOutcome] = asyncio.get_running_loop().create_future()
        self.adapter.act(device, command, {**described.fixed, **arguments}, done.set_result)
        async with asyncio.timeout(PATIENCE_S):
            return await done

    async def keep(self) -> None:
        """Run it again whenever it is lost, as a gateway does."""
        while True:
            try:
                await self.adapter.run()
            except AdapterLost as error:
                self.lost.append(str(error))
                self.news.set()
            await asyncio.sleep(0.05)


@asynccontextmanager
async def adapting(text: str, folder: Path) -> AsyncIterator[Bench]:
    bench = Bench(text, folder)
    running = asyncio.create_task(bench.keep())
    try:
        yield bench
    finally:
        running.cancel()
        with suppress(asyncio.CancelledError):
            await running
