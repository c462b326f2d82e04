"""The connections to the hub, each dialled anew for as long as the gateway runs.

The link comes first: pictures and files are sent only while it stands.
"""

from __future__ import annotations

import asyncio
import logging
from typing import TYPE_CHECKING, NamedTuple, Protocol

from talaia.gateway.uplink.catchup import CatchUp
from talaia.gateway.uplink.connection import HubLink, HubMessageHandler, run_media
from talaia.gateway.uplink.dialling import OutageLog, beside_link, keep_dialling
from talaia.gateway.uplink.files import TransferCallbacks, send_files
from talaia.gateway.uplink.newest_samples import NewestSamplesSender
from talaia.wire.frames import ArchiveOffer, AssetRequest, NewestBatch, ResumeSaved

if TYPE_CHECKING:
    from collections.abc import Coroutine, Sequence

    from talaia.clock import Clock
    from talaia.gateway.ports import EventSink
    from talaia.gateway.reload.current_description import PreparedDescription
    from talaia.gateway.samples.batching import Batcher
    from talaia.gateway.settings import GatewaySettings
    from talaia.gateway.spool.spool_thread import SpoolThread
    from talaia.gateway.uplink.files import FileLane
    from talaia.gateway.uplink.key_prover import KeyProver
    from talaia.gateway.uplink.pictures import PictureUplink
    from talaia.gateway.uplink.send_lanes import SendLanes
    from talaia.gateway.uplink.tls import HubTrust
    from talaia.wire.frames import FileOffer, FilmOffer, Hello, Welcome

__all__ = [
    "CountingDescription",
    "HubConnection",
    "HubDispatcher",
    "keep_files",
    "keep_link",
    "keep_media",
]

log = logging.getLogger(__name__)
# What a hub may send that knows it.
_TAKES = (str(AssetRequest.__struct_config__.tag),)


class HubDispatcher(HubMessageHandler, Protocol):
    """Acts on what the hub says, and knows whether the link stands.

    Attributes:
        linked: set while it does; files and pictures wait for it.
        links: counts links.

    """

    linked: asyncio.Event
    links: int


class CountingDescription(Protocol):
    """The description that counts."""

    @property
    def now(self) -> PreparedDescription:
        """What counts."""
        ...

    @property
    def turn(self) -> int:
        """How often it was replaced."""
        ...

    def report_since(self, turn: int) -> None:
        """Tell a hub that was greeted with an earlier description which one counts now."""
        ...


class HubConnection(NamedTuple):
    """The way to the hub, and who acts on what it says."""

    settings: GatewaySettings
    trust: HubTrust
    prover: KeyProver
    clock: Clock
    dispatcher: HubDispatcher


async def keep_link(
    *,
    hub: HubConnection,
    boot: str,
    reload: CountingDescription,
    lanes: SendLanes,
    wake: asyncio.Event,
    batcher: Batcher,
    spool: SpoolThread,
) -> None:
    """Keep the link: what is new goes out at once, and what waits on the disk beside it.

    Args:
        hub: to the hub.
        boot: names this run.
        reload: knows the description that counts.
        lanes: what is to be sent.
        wake: set when there is something in them.
        batcher: knows what was sampled last.
        spool: has what the hub has not.

    """
    settings, clock = hub.settings, hub.clock
    link = HubLink(
        trust=hub.trust,
        prover=hub.prover,
        clock=clock,
        lanes=lanes,
        wake=wake,
        handler=hub.dispatcher,
    )
    outage = OutageLog()
    teller = NewestSamplesSender(
        newest=batcher.newest_samples, spool=spool, lanes=lanes, clock=clock, boot=boot
    )
    # Counted up by each reload; told to the hub in `hello`, compared once the link stands.
    # Which description the hub was greeted with.
    told = 0

    def hello() -> Hello:
        nonlocal told
        told = reload.turn
        return reload.now.make_hello(
            boot=boot,
            time_us=clock.wall_ns() // 1000,
            accepts=settings.accepts,
            acked=spool.acked_below(boot),
            takes=_TAKES if settings.meshes else (),
        )

    def beside(welcome: Welcome) -> asyncio.Task[None]:
        # The hub knows a channel by its former name only from this run's description.
        outage.back()
        reload.report_since(told)
        log.debug("the hub has %d samples of this run", welcome.acked)
        # Everything before is in the spool, or was acknowledged.
        live_from = batcher.next
        takes = NewestBatch.__struct_config__.tag in welcome.takes

        def tell_newest() -> None:
            if takes:
                teller.tell_run(reload.now.catalogue)

        catchup = CatchUp(
            spool=spool,
            lanes=lanes,
            boot=boot,
            catalogue=lambda: reload.now.catalogue,
            rate=settings.backfill_bytes,
            dropped=tell_newest,
        )

        # Before anything old, and before anything newer.
        # In the lane of live samples, so before anything newer.
        tell_newest()
        former = teller.tell_former(lambda: reload.now.addresses) if takes else asyncio.sleep(0)
        return asyncio.ensure_future(
            _run_together(save_place(welcome.resume), former, catchup.run(live_from))
        )

    async def save_place(resume: str) -> None:
        serial = await hub.prover.save_resume(resume)
        if serial is not None:
            lanes.send(ResumeSaved(serial=serial))

    await keep_dialling("the hub", lambda: link.once(hello(), beside), outage, clock)


async def _run_together(*parts: Coroutine[None, None, None]) -> None:
    """Run all at once; what goes wrong with the one is not hidden by another."""
    tasks = [asyncio.ensure_future(part) for part in parts]
    try:
        for task in tasks:
            # In order; the first usually end by themselves while the last goes on for the link's
            # life.
            await task
    finally:
        for task in tasks:
            task.cancel()
        await asyncio.gather(*tasks, return_exceptions=True)


async def keep_media(hub: HubConnection, pictures: PictureUplink) -> None:
    """Keep the connection for pictures of cameras."""
    dispatcher, outage = hub.dispatcher, OutageLog()

    def up() -> None:
        if outage.back():
            log.info("the hub's media side is back")

    async def once() -> None:
        await run_media(
            trust=hub.trust,
            prover=hub.prover,
            clock=hub.clock,
            pictures=pictures,
            up=up,
        )

    await keep_dialling(
        "the hub's media side",
        lambda: beside_link(dispatcher.linked, lambda: dispatcher.links, once),
        outage,
        hub.clock,
    )


async def keep_files(
    *,
    hub: HubConnection,
    files: Sequence[FileLane],
    to_send: asyncio.Event,
    lanes: SendLanes,
    events: EventSink,
) -> None:
    """Hand pictures and recordings over, while there is a link and something waits.

    Args:
        hub: to the hub.
        files: what waits.
        to_send: set when something does.
        lanes: what is more urgent.
        events: told what the hub does not take.

    """
    dispatcher, outage = hub.dispatcher, OutageLog()

    def up() -> None:
        if outage.back():
            log.info("the hub takes files again")

    def refused(offer: FileOffer | FilmOffer | ArchiveOffer, why: str) -> None:
        device = offer.device if isinstance(offer, ArchiveOffer) else ""
        said = f"the hub does not take {offer.id}: {why}"
        events.report_event("file_refused", said, device=device)

    sending = TransferCallbacks(lambda: lanes.busy, up, refused)

    async def once() -> None:
        await send_files(hub.trust, hub.prover, lanes=files, sending=sending)

    def waiting() -> bool:
        return any(file.source.offers() for file in files)

    async def waited() -> None:
        # Sleeps while there is nothing to send: no connection is kept open for it.
        await to_send.wait()
        to_send.clear()
        try:
            await beside_link(dispatcher.linked, lambda: dispatcher.links, once)
        except BaseException:
            # Whatever ended it: files still wait, so the next turn must not sleep for ever.
            to_send.set()
            raise
        # A link that took the loss upon itself: what is left waits for the next one.
        # On a thread: listing them reads a folder.
        if await asyncio.to_thread(waiting):
            to_send.set()

    # What a run before has left.
    to_send.set()
    await keep_dialling("the hub's side for files", waited, outage, hub.clock)
