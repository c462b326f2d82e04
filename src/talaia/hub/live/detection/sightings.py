"""What cameras have seen: kept, and told to alarms, pages and the logbook.

What a gateway says is taken at once and bounded; one task writes what has gathered, the newest
word on each sighting, and tells nobody of anything before it is in the database. So the same word
said twice changes nothing, and raises no alarm twice.

Long, because a sighting's whole way through the hub is told here, in its order.
"""

from __future__ import annotations

import asyncio
import contextlib
import logging
from typing import TYPE_CHECKING

from sqlalchemy.exc import SQLAlchemyError

from talaia.hub.errors import StoreDown
from talaia.hub.live.detection.sighting_limits import (
    Key,
    KnownSighting,
    SiteSightings,
    detect_of,
    merge_sightings,
    said_of,
    story_text,
)
from talaia.hub.live.pictures.jpeg_validator import NotAPicture, bare_jpeg
from talaia.hub.ports import SightingEvent
from talaia.hub.store.audit import AuditEntry
from talaia.hub.store.safe_text import safe_text
from talaia.hub.store.sites.sightings import Sighted
from talaia.model.detection import DetectAt
from talaia.wire import browser as page

if TYPE_CHECKING:
    from collections.abc import Callable, Sequence

    from talaia.clock import Clock
    from talaia.hub.live.pages.page_connections import Browser, Browsers
    from talaia.hub.live.sites import LiveSite, Sites
    from talaia.hub.ports import SightingSink
    from talaia.hub.store.sites.sightings import Put, SightingStore
    from talaia.wire.frames import SightingReport

__all__ = ["KIND", "OWN", "SightingJournal"]

_LOG = logging.getLogger(__name__)
# What the logbook calls them.
KIND = "sighting"
# What gathers meanwhile is one transaction.
_GATHER_S = 0.1
# Between two attempts while the database fails (s).
_RETRY_S = 1.0
# How often sightings that nobody speaks of any more are looked for (s).
_TICK_S = 2.0
# How often old ones are deleted (s).
_TRIM_S = 3600.0
# More things at once than any camera shows: a number from a gateway is not to be believed.
_MOST_MANY = 10_000
# So long after its gateway was lost, nobody says of anything any more that it is in sight (s).
_AWAY_S = 60.0
# A gateway's new run has so long to say itself how what the one before saw has ended (s).
GRACE_S = 10.0
_DAY_US = 86_400_000_000
# Times from here on are no times (µs): the year 2255.
# Beyond 2**53 JavaScript does not hold every whole number.
_LAST_US = 2**53
# Names the runs of the hub's own looking.
OWN = "hub "


class SightingJournal:
    """Takes, keeps and tells what cameras have seen."""

    def __init__(
        self,
        *,
        sites: Sites,
        browsers: Browsers,
        store: SightingStore,
        clock: Clock,
        days: float,
        most: int,
    ) -> None:
        """Keep in ``store`` for ``days`` (0: for good), and at most ``most`` of each site."""
        # The sites as they are now; whether they are linked decides what ends.
        self._sites = sites
        # Pages; told only of what is in the database.
        self._browsers = browsers
        self._store = store
        # Wall for when things were seen, monotonic for limits and waits.
        self._clock = clock
        # Older ones are deleted (days); 0: none for its age.
        self._days = days
        # Of each site the oldest above this number are deleted.
        self._most = most
        # Told of each beginning and end, the alarms among them.
        self._sinks: list[SightingSink] = []
        # By site: what is in sight, and its limits.
        self._of: dict[str, SiteSightings] = {}
        # What is to be written, the newest word on each; emptied by `settle_writes`.
        self._waiting: dict[Key, Sighted] = {}
        # Something is to be written, or the end.
        self._news = asyncio.Event()
        # Set once: what waits is written, and `run` ends.
        self._stopping = False
        # It was logged that the database fails; once for each failure.
        self._failing = False
        # When old ones were last deleted (monotonic, s).
        self._trimmed_s = self._now_s()

    def add_listener(self, sink: SightingSink) -> None:
        """Tell ``sink`` of everything that is kept from now on, and of what is in sight."""
        self._sinks.append(sink)

    async def open(self) -> None:
        """Bring back what was in sight, and tell the sinks.

        Raises:
            StoreDown: the database does not answer.

        """
        for kept in await self._store.list_open():
            sighted = kept.sighted
            self._site_of(sighted.site).open[sighted.key] = KnownSighting(sighted, kept.id)
            # Conditions that held when the hub was ended must hold again.
            self._tell_sinks(sighted)
            if sighted.boot.startswith(OWN):
                # The hub was killed while it looked.
                self._put_end(sighted, 0)
        await self._trim_old()

    # ── what is told ────────────────────────────────────────────────────────────────────────

    def handle_report(self, live: LiveSite, seen: SightingReport) -> None:
        """Take what a gateway says; what its description does not let it say is left out."""
        detect = detect_of(live.description, seen.stream)
        key = (live.name, seen.stream, seen.label, seen.began_us)
        # One that has begun is followed to its end, even if the description looks for it no more.
        known = key in self._site_of(live.name).open or key in self._waiting
        if not known and (detect is None or detect.at is not DetectAt.GATEWAY):
            self._leave_out(live, f"{seen.stream!r} is not watched by this gateway")
        elif not known and detect is not None and seen.label not in detect.classes:
            self._leave_out(live, f"{seen.label!r} is not looked for on {seen.stream}")
        else:
            self.record_sighting(live, seen, live.gateway.boot)

    def record_sighting(self, live: LiveSite, seen: SightingReport, boot: str) -> None:
        """Take what is seen, by whomever (``boot`` names the run)."""
        if not (0 < seen.began_us < _LAST_US and 0 <= seen.ended_us < _LAST_US):
            self._leave_out(live, "its time cannot be right")
            return
        site = self._site_of(live.name)
        ended_us = seen.ended_us
        # An end before the beginning: the gateway's clock was set meanwhile.
        if ended_us and ended_us < seen.began_us:
            ended_us = seen.began_us
        sighted = Sighted(
            live.name,
            seen.stream,
            seen.label,
            seen.began_us,
            ended_us,
            min(seen.many, _MOST_MANY),
            seen.confidence,
            self._now_us(),
            safe_text(boot, 200),
            story_text(seen),
        )
        picture = b""
        waits = self._waiting.get(sighted.key)
        if waits is None and sighted.key not in site.open:
            waiting = sum(key[0] == live.name for key in self._waiting)
            # Only what is new is held back: the end of what is in sight must always come through.
            if not site.takes_more(waiting, self._now_s()):
                self._leave_out(live, "more is seen than anybody could follow")
                return
        # Bounded too, for each picture is read and stored.
        if seen.thumbnail and site.spend_token(self._now_s()):
            picture = self._check_thumbnail(live, seen)
        if waits is not None and not picture:
            picture = waits.picture
        self._waiting[sighted.key] = sighted._replace(picture=picture)
        self._news.set()

    def handle_attach(self, live: LiveSite) -> None:
        """Wait for what this run of the gateway says of what another one saw last."""
        self._site_of(live.name).asked_s = self._now_s()

    def redescribe(self, live: LiveSite) -> None:
        """End what nobody watches any more."""
        site = live.description
        self._end_matching(
            live.name, lambda known: detect_of(site, known.camera) is None, self._now_us()
        )

    def greet(self, browser: Browser) -> None:
        """Tell a page that has just come what is in sight."""
        for site in self._of.values():
            for told in site.open.values():
                browser.send_message(_sighting_update(told.id, told.sighted))

    def _end_matching(self, name: str, which: Callable[[Sighted], bool], at_us: int) -> None:
        site = self._site_of(name)
        # What waits is newer than what the database has.
        for key, told in list(site.open.items()):
            latest = self._waiting.get(key, told.sighted)
            if not latest.ended_us and which(latest):
                self._put_end(latest, at_us)
        # Those that are not in the database yet, so not in `open` either.
        for latest in list(self._waiting.values()):
            if latest.site == name and not latest.ended_us and which(latest):
                self._put_end(latest, at_us)

    def _put_end(self, sighted: Sighted, at_us: int) -> None:
        # Never before its beginning, nor before it was last spoken of.
        ended_us = max(sighted.began_us, sighted.told_us, at_us)
        self._waiting[sighted.key] = sighted._replace(ended_us=ended_us, told_us=self._now_us())
        self._news.set()

    def _check_thumbnail(self, live: LiveSite, seen: SightingReport) -> bytes:
        try:
            return bare_jpeg(seen.thumbnail)
        except NotAPicture as error:
            self._leave_out(live, f"a picture of {seen.label!r} cannot be kept: {error}")
            return b""

    def _leave_out(self, live: LiveSite, why: str) -> None:
        """Say once that something is not kept, until all is well again."""
        if self._site_of(live.name).leaves_out(self._now_s()):
            _LOG.warning("sightings of %s are left out: %s", live.name, why)

    # ── what comes of it ────────────────────────────────────────────────────────────────────

    async def run(self) -> None:
        """Write and tell until `stop`, and then what still waits."""
        while self._waiting or not self._stopping:
            with contextlib.suppress(TimeoutError):
                async with asyncio.timeout(_TICK_S):
                    await self._news.wait()
            self._news.clear()
            # At the end nothing more gathers.
            if not self._stopping:
                await asyncio.sleep(_GATHER_S)
            try:
                self.end_forgotten()
                await self.settle_writes()
                if self._now_s() - self._trimmed_s > _TRIM_S:
                    await self._trim_old()
            except StoreDown:
                if not self._failing:
                    _LOG.exception("sightings cannot be kept; they wait")
                self._failing = True
                # The end of the hub does not wait for a database.
                if self._stopping:
                    return
                await asyncio.sleep(_RETRY_S)
                self._news.set()
            except Exception:  # noqa: BLE001 - logged, and the next ones are taken
                # Sightings, and their alarms, that end without a word would be the worst of all.
                _LOG.exception("some sightings could not be dealt with")
                if self._stopping:
                    return
                await asyncio.sleep(_RETRY_S)
            else:
                if self._failing:
                    _LOG.warning("sightings are kept again")
                self._failing = False

    def stop(self) -> None:
        """Let `run` end once everything is written."""
        self._stopping = True
        self._news.set()

    def end_forgotten(self) -> None:
        """End what nobody speaks of any more: a gateway that is away, or knows nothing of it."""
        now_us, now_s = self._now_us(), self._now_s()
        for name, site in self._of.items():
            if were := site.calm_again(now_s):
                _LOG.info("no more sightings of %s are left out; %d were", name, were)
            live = self._sites.find_site(name)
            if live is None:
                continue
            # A new run has had its time: what it has not spoken of has ended.
            if site.asked_s and now_s - site.asked_s >= GRACE_S:
                site.asked_s = 0.0
                self._end_matching(
                    name, _of_others(safe_text(live.gateway.boot, 200)), live.presence.last_seen_us
                )
            if not site.open or live.online:
                continue
            # By wall times, for `since_us` is one; a clock that is set ends them early or late.
            if now_us - live.presence.since_us > _AWAY_S * 1e6:
                self._end_matching(name, lambda _each: True, live.presence.last_seen_us)

    async def settle_writes(self) -> None:
        """Write what waits, and tell of it.

        Raises:
            StoreDown: nothing of it was written; it waits.

        """
        while self._waiting:
            # Swapped, so that what comes during the write waits apart.
            batch, self._waiting = self._waiting, {}
            try:
                kept = await self._store.save_sightings(list(batch.values()), self._audit_line)
            except StoreDown:
                # What came meanwhile is newer; a picture is not said twice.
                self._waiting = merge_sightings(batch, self._waiting)
                raise
            except SQLAlchemyError:
                # It answers, and does not take this: nor would it take it again.
                _LOG.exception("sightings cannot be kept, and are left out: %d", len(batch))
                continue
            self._publish_written(kept)

    def _publish_written(self, written: Sequence[Put]) -> None:
        for kept, again, entry in written:
            sighted = kept.sighted
            open_ = self._site_of(sighted.site).open
            if sighted.ended_us:
                open_.pop(sighted.key, None)
            else:
                open_[sighted.key] = KnownSighting(sighted, kept.id)
            # The same word again: shown anew, but no alarm is raised twice.
            if not again:
                self._tell_sinks(sighted)
            self._browsers.broadcast_message(_sighting_update(kept.id, sighted))
            if entry is not None:
                self._tell_line(entry, sighted.began_us)

    def _tell_sinks(self, sighted: Sighted) -> None:
        news = SightingEvent(
            sighted.site,
            sighted.camera,
            sighted.label,
            sighted.many,
            sighted.confidence,
            sighted.began_us,
            sighted.ended_us or None,
        )
        for sink in self._sinks:
            sink.report_sighting(news)

    def _tell_line(self, entry: AuditEntry, began_us: int) -> None:
        """Let logbooks on pages, and marks on charts, follow."""
        self._browsers.broadcast_message(
            page.EventUpdate(
                site=entry.site,
                kind=entry.kind,
                device=entry.device,
                message=entry.message,
                time_us=began_us,
            )
        )

    def _audit_line(self, sighted: Sighted) -> AuditEntry:
        """Give the logbook's line of what is over."""
        live = self._sites.find_site(sighted.site)
        device, _, _ = sighted.camera.partition("/")
        message = said_of(sighted, None if live is None else live.description)
        return AuditEntry(
            self._now_us(),
            KIND,
            site=sighted.site,
            device=device,
            message=message,
            source="gateway",
        )

    async def _trim_old(self) -> None:
        self._trimmed_s = self._now_s()
        before_us = self._now_us() - round(self._days * _DAY_US) if self._days else 0
        gone = await self._store.delete_old(before_us, self._most)
        if gone:
            _LOG.info("%d old sightings were forgotten", gone)

    def _site_of(self, name: str) -> SiteSightings:
        found = self._of.get(name)
        if found is None:
            found = self._of[name] = SiteSightings(self._now_s())
        return found

    def _now_us(self) -> int:
        return self._clock.wall_ns() // 1000

    def _now_s(self) -> float:
        return self._clock.monotonic_ns() / 1e9


def _of_others(boot: str) -> Callable[[Sighted], bool]:
    """Tell what another run of the gateway saw, and not the hub itself."""
    return lambda known: known.boot != boot and not known.boot.startswith(OWN)


def _sighting_update(number: int, sighted: Sighted) -> page.SightingUpdate:
    return page.SightingUpdate(
        site=sighted.site,
        id=number,
        camera=sighted.camera,
        label=sighted.label,
        many=sighted.many,
        confidence=sighted.confidence,
        began_us=sighted.began_us,
        ended_us=sighted.ended_us,
    )
