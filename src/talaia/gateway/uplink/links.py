"""The connections to the hub, each dialled anew for as long as the gateway runs.

The link comes first: pictures and files are sent only while it stands.
"""

from __future__ import annotations

import asyncio
import logging
from typing import TYPE_CHECKING, NamedTuple

from talaia.gateway.uplink.catchup import CatchUp
from talaia.gateway.uplink.connection import HubLink, run_media
from talaia.gateway.uplink.dialling import OutageLog, beside_link, keep_dialling
from talaia.gateway.uplink.files import TransferCallbacks, send_files
from talaia.gateway.uplink.newest_samples import NewestSamplesSender
from talaia.wire.frames import ArchiveOffer, NewestBatch

if TYPE_CHECKING:
    from collections.abc import Sequence

    from talaia.clock import Clock
    from talaia.gateway.ports import EventSink
    from talaia.gateway.reload.apply import DescriptionReload
    from talaia.gateway.samples.batching import Batcher
    from talaia.gateway.settings import GatewaySettings
    from talaia.gateway.spool.spool_thread import SpoolThread
    from talaia.gateway.uplink.files import FileLane
    from talaia.gateway.uplink.lanes import SendLanes
    from talaia.gateway.uplink.message_dispatcher import MessageDispatcher
    from talaia.gateway.uplink.pictures import PictureUplink
    from talaia.gateway.uplink.tls import HubTrust
    from talaia.wire.frames import FileOffer, FilmOffer, Hello, Welcome

__all__ = ["HubConnection", "keep_files", "keep_link", "keep_media"]

log = logging.getLogger(__name__)


class HubConnection(NamedTuple):
    """The way to the hub, and who acts on what it says."""

    settings: GatewaySettings
    trust: HubTrust
    clock: Clock
    desk: MessageDispatcher


async def keep_link(
    way: HubConnection,
    boot: str,
    exchange: DescriptionReload,
    lanes: SendLanes,
    wake: asyncio.Event,
    batcher: Batcher,
    keeper: SpoolThread,
) -> None:
    """Keep the link: what is new goes out at once, and what waits on the disk beside it.

    Args:
        way: to the hub.
        boot: names this run.
        exchange: knows the description that counts.
        lanes: what is to be sent.
        wake: set when there is something in them.
        batcher: knows what was sampled last.
        keeper: has what the hub has not.

    """
    settings, clock = way.settings, way.clock
    link = HubLink(settings, way.trust, clock, lanes, wake, way.desk)
    outage = OutageLog()
    teller = NewestSamplesSender(batcher.newest, keeper, lanes, clock, boot)
    # Which description the hub was greeted with.
    told = 0

    def hello() -> Hello:
        nonlocal told
        told = exchange.turn
        return exchange.now.hello(boot, clock.wall_ns() // 1000, settings.accepts)

    def beside(welcome: Welcome) -> asyncio.Task[None]:
        outage.back()
        exchange.said_since(told)
        log.debug("the hub has %d samples of this run", welcome.acked)
        live_from = batcher.next
        takes = NewestBatch.__struct_config__.tag in welcome.takes

        def tell_newest() -> None:
            if takes:
                teller.tell_run(exchange.now.catalogue)

        catchup = CatchUp(
            keeper, lanes, boot, lambda: exchange.now.catalogue, settings.backfill_bytes,
            tell_newest,
        )  # fmt: skip

        async def both() -> None:
            telling = asyncio.ensure_future(
                teller.tell_former(lambda: exchange.now.addresses) if takes else asyncio.sleep(0)
            )
            catching = asyncio.ensure_future(catchup.run(live_from))
            try:
                # What goes wrong with the one is not to be hidden by the other.
                await telling
                await catching
            finally:
                for each in (telling, catching):
                    each.cancel()
                await asyncio.gather(telling, catching, return_exceptions=True)

        # Before anything old, and before anything newer.
        tell_newest()
        return asyncio.ensure_future(both())

    await keep_dialling("the hub", lambda: link.once(hello(), beside), outage, clock)


async def keep_media(way: HubConnection, pictures: PictureUplink) -> None:
    """Keep the connection for pictures of cameras."""
    desk, outage = way.desk, OutageLog()

    def up() -> None:
        if outage.back():
            log.info("the hub's media side is back")

    async def once() -> None:
        await run_media(way.settings, way.trust, way.clock, pictures, up)

    await keep_dialling(
        "the hub's media side",
        lambda: beside_link(desk.linked, lambda: desk.links, once),
        outage,
        way.clock,
    )


async def keep_files(
    way: HubConnection,
    files: Sequence[FileLane],
    to_send: asyncio.Event,
    lanes: SendLanes,
    events: EventSink,
) -> None:
    """Hand pictures and recordings over, while there is a link and something waits.

    Args:
        way: to the hub.
        files: what waits.
        to_send: set when something does.
        lanes: what is more urgent.
        events: told what the hub does not take.

    """
    desk, outage = way.desk, OutageLog()

    def up() -> None:
        if outage.back():
            log.info("the hub takes files again")

    def refused(offer: FileOffer | FilmOffer | ArchiveOffer, why: str) -> None:
        device = offer.device if isinstance(offer, ArchiveOffer) else ""
        said = f"the hub does not take {offer.id}: {why}"
        events.tell("file_refused", said, device=device)

    sending = TransferCallbacks(lambda: lanes.busy, up, refused)

    async def once() -> None:
        await send_files(way.settings, way.trust, files, sending)

    def waiting() -> bool:
        return any(each.source.offers() for each in files)

    async def waited() -> None:
        await to_send.wait()
        to_send.clear()
        try:
            await beside_link(desk.linked, lambda: desk.links, once)
        except BaseException:
            to_send.set()
            raise
        # A link that took the loss upon itself: what is left waits for the next one.
        if await asyncio.to_thread(waiting):
            to_send.set()

    # What a run before has left.
    to_send.set()
    await keep_dialling("the hub's side for files", waited, outage, way.clock)
