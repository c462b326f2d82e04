"""The coming and going of gateways, and what each says to the parts of the hub.

Long, because a link's whole life is told here in its order, from the hello to the farewell.
"""

from __future__ import annotations

import asyncio
import logging
from functools import partial
from typing import TYPE_CHECKING, NamedTuple

from sqlalchemy.exc import SQLAlchemyError

from talaia import __version__
from talaia.errors import TalaiaError
from talaia.first_completed import until_first
from talaia.hub.errors import HubBusy
from talaia.hub.history.errors import HistoryAway
from talaia.hub.live.gateways.channel_maps import ChannelMaps
from talaia.hub.live.gateways.description_intake import Redescription, source_of
from talaia.hub.live.gateways.doubles.gateway_places import REPLACED
from talaia.hub.live.gateways.fingerprint import fingerprint_of
from talaia.hub.live.gateways.flood_guard import HELD_OFF, TRY_LATER
from talaia.hub.live.gateways.hello_intake import REFUSED, receive_hello
from talaia.hub.live.gateways.ingest import Batch, Ingest, StoringPace
from talaia.hub.live.gateways.link import GONE, GatewayLink
from talaia.hub.live.site_state import LinkedGateway
from talaia.model.errors import DescriptionError
from talaia.model.renames import former_addresses, list_renames
from talaia.wire import frames
from talaia.wire.errors import PeerError
from talaia.wire.newest import chosen_newest, runs_of
from talaia.wire.sealing import digest_of

if TYPE_CHECKING:
    from collections.abc import Mapping

    from starlette.websockets import WebSocket

    from talaia.clock import Clock
    from talaia.hub.live.assets.robot_assets import RobotAssets
    from talaia.hub.live.detection.sightings import SightingJournal
    from talaia.hub.live.gateways.description_intake import DescriptionIntake
    from talaia.hub.live.gateways.doubles.gateway_places import GatewayPlaces
    from talaia.hub.live.gateways.flood_guard import FloodGuard
    from talaia.hub.live.gateways.join_queue import JoinQueue
    from talaia.hub.live.gateways.live_samples import LiveSamples
    from talaia.hub.live.gateways.open_links import OpenLinks
    from talaia.hub.live.gateways.robot_events import RobotEvents
    from talaia.hub.live.observing.night_link import NightLink
    from talaia.hub.live.pages.watched_signals import WatchedSignals
    from talaia.hub.live.pictures.picture_fanout import PictureFanout
    from talaia.hub.live.robot_log_intake import RobotLogIntake
    from talaia.hub.live.sites import LiveSite, Sites
    from talaia.hub.live.taps.tap_fanout import TapFanout
    from talaia.hub.ports import History
    from talaia.hub.settings import Settings
    from talaia.hub.store.sites.gateway_presence import GatewayPresence
    from talaia.hub.store.sites.site_registry import GatewayKey
    from talaia.model.site import Site

__all__ = ["LinkService", "fingerprint_of"]

_LOG = logging.getLogger(__name__)
# What gateways may send that older hubs do not know.
_TAKES = (
    "seen",
    "newest",
    "enclosure",
    "topic_list",
    "night_state",
    "robot_log",
    "release_state",
)
# Beats without an answer after which a gateway counts as gone.
_MISSED_BEATS = 3
# At each of so many beats pages are told how a site stands: its loop time, a rival's end.
_NEWS_EVERY = 5
# What waits may take so long to be stored after the end of a link (s); the gateway has the rest.
_FINISH_S = 1.0
# While these are raised the database is away; anything else is a defect.
_STORE_FAILS = (SQLAlchemyError, TalaiaError, OSError)
# When a gateway is to come back whose hub has no database just now.
STORE_AFTER_S = 2.0


class _LinkParts(NamedTuple):
    """What is of one link alone, and takes what its gateway says."""

    ingest: Ingest
    lists: ChannelMaps
    redescription: Redescription


class LinkService:
    """Takes links in, reads them, and lets them go."""

    def __init__(
        self,
        *,
        sites: Sites,
        describing: DescriptionIntake,
        reporting: RobotEvents,
        samples: LiveSamples,
        sightings: SightingJournal,
        media: PictureFanout,
        taps: TapFanout,
        assets: RobotAssets,
        watched: WatchedSignals,
        nights: NightLink,
        robot_log: RobotLogIntake,
        history: History,
        attendance: GatewayPresence,
        links: OpenLinks,
        admission: JoinQueue,
        flood_guard: FloodGuard,
        places: GatewayPlaces,
        settings: Settings,
        clock: Clock,
    ) -> None:
        """Lead what gateways say to the parts that it is for.

        Args:
            sites: the sites as they are now.
            describing: takes a site's description.
            reporting: takes events and states for pages and the log.
            samples: takes live samples.
            sightings: takes what cameras have seen.
            media: is told when a link can be asked for pictures.
            taps: is told when a link can be asked for raw topics, and when it is gone.
            assets: the same, of files of robots.
            watched: is told when a link can be asked to send soon what is on a screen.
            nights: takes how nights stand and what was observed.
            robot_log: takes lines of robots' own logs.
            history: keeps samples.
            attendance: keeps when a gateway was there.
            links: closes a link whose key is revoked.
            admission: lets so many in at a time.
            flood_guard: slows whoever says too much, and cuts them off.
            places: tells who of two gateways with one key has the place.
            settings: times of the link.
            clock: dates what comes.

        """
        self._sites = sites
        self._describing = describing
        self._reporting = reporting
        self._samples = samples
        self._sightings = sightings
        self._media, self._taps, self._assets = media, taps, assets
        self._watched = watched
        self._nights, self._history, self._robot_log = nights, history, robot_log
        self._attendance, self._links, self._admission = attendance, links, admission
        self._settings, self._clock = settings, clock
        self._pace = StoringPace(settings.commit_s)
        self._flood_guard, self._places = flood_guard, places
        # Comings and goings of links are written down one after the other.
        self._parting = asyncio.Lock()

    async def serve_socket(self, socket: WebSocket, key: GatewayKey) -> None:
        """Serve the link of a gateway until it ends."""
        link = GatewayLink(socket)
        # Counted from the start, so that a key that is revoked during the hello ends this link too.
        with self._links.count_open(key.id, link):
            await self._serve_link(link, key, socket.client.host if socket.client else "")

    async def _serve_link(self, link: GatewayLink, key: GatewayKey, address: str) -> None:
        site = key.site
        try:
            hello, description = await receive_hello(
                link, self._sites.find_site(site), site, self._settings.hello_s
            )
            source = "" if hello is None else source_of(hello)
        # Before `GONE`, which has `TimeoutError` too: one that is late with its hello is told why.
        except (PeerError, DescriptionError, TimeoutError) as error:
            reason = str(error) or "no hello in time"
            _LOG.warning("the gateway of %s is refused: %s", site, reason)
            await link.send_farewell(reason, _refusal_code(error))
            return
        except GONE:
            return
        if hello is None or description is None:
            return
        told = fingerprint_of(hello.description, hello.catalogue)
        # Before anything is looked up: a rival dials again and again.
        if not await self._places.wait_place(link, key, hello, address):
            return
        if held_s := self._flood_guard.held_s(key):
            await link.send_farewell(HELD_OFF, TRY_LATER, held_s)
            return
        ingest = Ingest(self._history, site, link.send, self._pace)
        try:
            later = await self._describing.handle_hello(
                hello, description, source, gateway=key.id, turns=self._admission
            )
            acked = await _first_missing(ingest, hello)
        except HubBusy as error:
            await link.send_farewell(str(error), TRY_LATER, self._admission.after_s)
            return
        except _STORE_FAILS as error:
            _LOG.error("the gateway of %s must wait: the database fails: %s", site, error)
            said = "the hub cannot store anything now; try again later"
            await link.send_farewell(said, TRY_LATER, STORE_AFTER_S)
            return
        if later:
            ingest.rename_channels(later)
        # Again: while this one waited for its turn another may have been linked. Nothing is
        # awaited from the last look to `_attach_link`, so no other comes between.
        if not await self._places.wait_place(link, key, hello, address):
            return
        gateway = LinkedGateway(key.id, hello.boot, told, source, accepts=hello.accepts)
        gateway.takes = tuple(hello.takes)
        gateway.digest = digest_of(source or hello.description)
        self._places.assign_place(gateway, key)
        # Only queued; `_run_link` writes it.
        link.send(
            frames.Welcome(
                version=__version__,
                acked=acked,
                time_us=self._clock.wall_ns() // 1000,
                takes=list(_TAKES),
                resume=self._places.words_of(gateway),
            )
        )
        self._flood_guard.begin_link(key, gateway.issued.lineage)
        # What it says is held against the place that it has now, not the one that it has shown.
        speaker = key._replace(resumed=gateway.issued)
        link.charge_kind = partial(self._flood_guard.charge_kind, speaker)
        live = self._attach_link(link, hello, description, gateway)
        self._attendance.record_link(key.id, site, hello.version, address)
        storing = asyncio.create_task(ingest.run())
        try:
            await self._run_link(link, live, ingest)
        finally:
            # Pages see it as away at once; what came is stored after that.
            self._detach_link(link, live)
            ingest.finish_storing()
            await asyncio.wait({storing}, timeout=_FINISH_S)
            storing.cancel()
            await asyncio.gather(storing, return_exceptions=True)
            self._attendance.record_leave(key.id, site)

    def _attach_link(
        self, link: GatewayLink, hello: frames.Hello, description: Site, gateway: LinkedGateway
    ) -> LiveSite:
        site = description.site
        before = self._sites.find_site(site)
        if before is not None and before.link is not None:
            # Its own `_serve_link` ends by this, and `_detach_link` there finds that another
            # has its place.
            before.link.dismiss_gateway("another gateway of this site has connected")
            # Before the new link begins: its leases are free and its commands unknown.
            self._reporting.link_lost(before)
        changed = before is None or before.description != description
        renamed = {} if before is None else list_renames(before.description, description)
        live = self._sites.describe_site(description, hello.catalogue, renamed)
        live.renamed = _former_channels(live, renamed)
        live.attach_link(link, gateway, self._clock.wall_ns() // 1000)
        link.handed_down = live.handed_down
        self._sightings.handle_attach(live)
        live.presence.measure_skew(hello.time_us, self._clock.wall_ns())
        if changed:
            self._describing.notify_followers(live)
        self._reporting.publish_site(live)
        # Founding gateways name none.
        version = f"it runs version {hello.version}" if hello.version else ""
        self._reporting.report_event(live, "gateway connected", message=version)
        if changed and before is not None:
            self._reporting.report_event(
                live, "description changed", message=f"catalogue {hello.catalogue}"
            )
        self._media.watch(site)
        self._taps.link_up(site)
        self._assets.link_up(site)
        self._watched.link_up(site)
        _LOG.info("the gateway of %s is connected", site)
        return live

    def _detach_link(self, link: GatewayLink, live: LiveSite) -> None:
        # Another link has taken its place: what stands now belongs to that one.
        if live.link is not link:
            return
        live.detach_link(self._clock.wall_ns() // 1000)
        self._taps.link_lost(live.name)
        self._assets.link_lost(live.name)
        self._nights.link_lost(live.name)
        self._describing.link_lost(live)
        self._reporting.link_lost(live)
        self._reporting.publish_site(live)
        self._reporting.report_event(live, "gateway lost", good=False)
        _LOG.warning("the gateway of %s is gone", live.name)

    async def _run_link(self, link: GatewayLink, live: LiveSite, ingest: Ingest) -> None:
        addresses = [channel.address for channel in live.channels]
        lists = ChannelMaps(live.catalogue, addresses, live.renamed)
        redescription = Redescription(self._describing, live, lists, ingest)
        # Whichever ends first ends the link: a hang-up, a fault, missed beats, or a dismissal.
        results = await until_first(
            self._read_all(link, live, _LinkParts(ingest, lists, redescription)),
            redescription.run(),
            self._send_beats(link, live),
            link.write_queued(),
            link.wait_dismissed(),
        )
        # The last is `dismissed`: a text if somebody has ended the link.
        said = results[-1] if isinstance(results[-1], str) else ""
        # 1000 is a normal closure (RFC 6455, 7.4.1).
        code = REPLACED if said else 1000
        for result in results:
            if isinstance(result, PeerError):
                said, code = str(result), result.code
                _LOG.warning("the gateway of %s is sent away: %s", live.name, result)
            # Parts that were cancelled return no `Exception`; a socket that has gone is no fault of
            # ours.
            elif isinstance(result, Exception) and not isinstance(result, GONE):
                # 1011: the server met something that it did not expect (RFC 6455).
                await link.send_farewell("the hub failed; see its log", 1011)
                raise result
        await link.send_farewell(said, code)

    async def _read_all(self, link: GatewayLink, live: LiveSite, parts: _LinkParts) -> None:
        await link.read_messages(partial(self._handle_message, link, live, parts))
        # When a switch dies, hundreds go at one blow: one by one, and the loop's turn in between.
        async with self._parting:
            await asyncio.sleep(0)

    def _handle_message(
        self, link: GatewayLink, live: LiveSite, parts: _LinkParts, message: frames.FromGateway
    ) -> bool:
        """Lead a message to the part that it is for; False: it was the last. Never waits."""
        ingest, lists, redescription = parts
        match message:
            case frames.SampleBatch():
                batch = lists.read_batch(message)
                if not message.addresses:
                    shown = lists.live_columns(batch)
                    if message.live:
                        end = batch.first + len(batch.columns)
                        self._samples.publish_batch(live, shown, boot=batch.boot, end=end)
                    else:
                        self._samples.publish_late_batch(live, shown)
                ingest.enqueue_batch(batch)
            case frames.NewestBatch():
                self._tell_newest(live, message, lists, ingest)
            case frames.DescriptionUpdate():
                redescription.enqueue_description(message)
            case frames.ChangeState():
                self._describing.receive_change_state(live, message)
            case frames.SampleGap():
                ingest.enqueue_batch(message)
            case frames.SightingReport():
                self._sightings.handle_report(live, message)
            case (
                frames.NightState()
                | frames.NightPlan()
                | frames.RequestRevision()
                | frames.ObservationUpdate()
            ):
                self._nights.handle_message(live, message)
            case frames.RobotLogBatch():
                self._robot_log.handle_batch(live, message)
            case frames.Beat():
                mine = self._now_us()
                link.send(frames.BeatReply(n=message.n, mono_us=message.mono_us, peer_us=mine))
            case frames.BeatReply():
                link.offset.add_beat(message.mono_us, self._now_us(), message.peer_us)
                live.presence.loop_ms = round(link.offset.loop_us / 1000, 2)
            case frames.ResumeSaved():
                live.gateway.saved |= message.serial == live.gateway.issued.serial
            case frames.AssetState():
                self._assets.handle_state(live.name, message)
            case frames.ReleaseState():
                live.gateway.releases = message
            case frames.Bye():
                return False
            case frames.Hello():
                raise PeerError("hello is said once, at the beginning")
            case _:
                if isinstance(message, frames.Event):
                    self._nights.handle_event(live, message)
                if not redescription.defers(message):
                    self._reporting.publish_message(live, message)
        return True

    def _tell_newest(
        self, live: LiveSite, message: frames.NewestBatch, lists: ChannelMaps, ingest: Ingest
    ) -> None:
        """Take what was said while nobody heard it for what counts now, and keep it first."""
        addresses, told = lists.read_newest(message)
        shown, now_ns = lists.live_newest(addresses, told), self._clock.monotonic_ns()
        current = message.boot == live.gateway.boot
        newer = live.latest.newer_samples(shown, message.boot, now_ns, current=current)
        if newer.any():
            fresh = chosen_newest(shown, newer)
            self._samples.publish_newest(live, fresh, message.boot, now_ns)
        # What is stored already is left out.
        for first, columns in runs_of(told, ingest.first_unstored(message.boot)):
            ingest.enqueue_batch(Batch(message.boot, first, addresses, columns))

    async def _send_beats(self, link: GatewayLink, live: LiveSite) -> None:
        sent = 0
        while True:
            # Read before the next beat goes, whose answer cannot be there yet.
            heard = link.offset.heard
            link.send(frames.Beat(n=sent, mono_us=self._now_us()))
            sent += 1
            if sent - heard > _MISSED_BEATS:
                link.dismiss_gateway("it has not answered for three beats")
            # A rival that dials no more is forgotten before the site is shown.
            if sent % _NEWS_EVERY == 0:
                self._reporting.forget_rival(live)
                self._reporting.publish_site(live)
            await asyncio.sleep(self._settings.beat_s)

    def _now_us(self) -> int:
        # Beats measure spans, which a clock that is set must not change.
        return self._clock.monotonic_ns() // 1000


async def _first_missing(ingest: Ingest, hello: frames.Hello) -> int:
    """Give what is stored of a gateway's run; what it was told last, while its history is away.

    Raises:
        HistoryAway: it is, and the gateway is of a version that does not say what it was told.

    """
    try:
        return await ingest.first_missing(hello.boot)
    except HistoryAway as error:
        # Less would be taken for samples that the hub has lost, and more would lose some.
        if hello.acked < 0:
            raise
        _LOG.warning("samples of %s wait at its gateway: %s", hello.site, error)
        return hello.acked


def _refusal_code(error: Exception) -> int:
    """Give the close code of a hello that is not taken; of a flood it says to come back."""
    flooded = isinstance(error, PeerError) and error.code == TRY_LATER
    return TRY_LATER if flooded else REFUSED


def _former_channels(live: LiveSite, renamed: Mapping[str, str]) -> dict[str, str]:
    """Give channels that have another address now, by former ones."""
    # A channel that was renamed twice is found by its first address too.
    known = {old: renamed.get(new, new) for old, new in live.renamed.items()}
    return {**former_addresses(live.description), **known, **renamed}
