"""Sites that the hub knows while no gateway speaks for them: of before, and of imports."""

from __future__ import annotations

import asyncio
import logging
from typing import TYPE_CHECKING

from talaia.hub.history.errors import HistoryAway
from talaia.hub.live.gateways.fingerprint import fingerprint_of
from talaia.model.errors import DescriptionError
from talaia.model.yaml_text.load import load_site

if TYPE_CHECKING:
    from talaia.clock import Clock
    from talaia.hub.history.import_file import Head
    from talaia.hub.live.alarms.alarm_engine import AlarmEngine
    from talaia.hub.live.files.import_inbox import ImportResult
    from talaia.hub.live.sites import LiveSite, Sites
    from talaia.hub.ports import History, Shard
    from talaia.hub.store.audit import Audit
    from talaia.hub.store.sites.descriptions import Descriptions
    from talaia.hub.store.sites.site_registry import KnownSite, SiteRegistry

__all__ = ["ImportedSites", "OfflineSites"]

_LOG = logging.getLogger(__name__)
# More at once would wait for the history's one writing connection all the same.
_AT_ONCE = 32
# Why, and where it is, is for admins.
_HISTORY_AWAY = "its history is on a server that is away, and its gateway has not connected"


class OfflineSites:
    """Has `Sites` know them by what the registry and the history have of them."""

    def __init__(
        self,
        *,
        sites: Sites,
        registry: SiteRegistry,
        versions: Descriptions,
        history: History,
        shard: Shard,
        clock: Clock,
    ) -> None:
        """Know none yet; those that are not of ``shard`` another hub shows."""
        self._shard = shard
        self._versions = versions
        self._sites = sites
        self._registry = registry
        self._history = history
        self._clock = clock

    async def restore_sites(self) -> None:
        """Know the sites of before, with their last values, though none is connected yet."""
        digests = await self._versions.newest_digests()
        listed = await self._registry.list_sites()
        every = [known for known in listed if self._shard.has_site(known.site)]
        # Several at once, which the history writes down together: who takes over for another hub
        # has all its gateways and pages waiting.
        for first in range(0, len(every), _AT_ONCE):
            some = every[first : first + _AT_ONCE]
            await asyncio.gather(
                *(self._restore_site(known, digests.get(known.site, "")) for known in some)
            )

    async def _restore_site(self, known: KnownSite, digest: str) -> None:
        try:
            description = load_site(known.description)
        except DescriptionError as error:
            # One that this version cannot read must not keep the others away.
            _LOG.warning("the kept description of %s is set aside: %s", known.site, error)
            return
        live = self._sites.describe_site(description, known.catalogue)
        await self._history.describe_site(description)
        # A gateway that says the same again need not have it read, or stored, a second time.
        live.gateway.fingerprint = fingerprint_of(known.description, known.catalogue)
        live.gateway.digest = digest
        # UTC, for no monotonic time outlives the process that took it.
        live.presence.since_us = live.presence.last_seen_us = known.last_seen_us
        # Shown in the place of a lost link, which this process has not seen.
        live.presence.why = "its gateway has not connected since the hub was started"
        try:
            await self._remember_values(known.site, live)
        except HistoryAway as error:
            # Its gateway comes all the same, and is watched, stopped and driven.
            live.presence.why = _HISTORY_AWAY
            _LOG.warning("the last values of %s are not known: %s", known.site, error)

    async def _remember_values(self, site: str, live: LiveSite) -> None:
        addresses = [channel.address for channel in live.every]
        # Of another process, so their ages can only be told by the wall clock.
        wall, monotonic = self._clock.wall_ns(), self._clock.monotonic_ns()
        last = await self._history.last_readings(site, addresses)
        for at, address in enumerate(addresses):
            if address in last:
                time_us, value, text = last[address]
                # A gateway's clock may be ahead of ours; no age is below 0.
                age_ns = max(0, wall - time_us * 1000)
                live.latest.remember_value(
                    at, time_us=time_us, value=value, text=text, arrived_ns=monotonic - age_ns
                )


class ImportedSites:
    """Writes imports down, and has `Sites` know sites of which only recordings came."""

    def __init__(
        self,
        *,
        sites: Sites,
        registry: SiteRegistry,
        history: History,
        alarms: AlarmEngine,
        audit: Audit,
    ) -> None:
        """Describe a site that nobody knows to all of them."""
        self._sites = sites
        self._registry = registry
        self._history = history
        self._alarms = alarms
        self._audit = audit

    async def record_import(self, head: Head, how: ImportResult) -> None:
        """Write an import down, and know a site of which only recordings came."""
        # What a gateway said is newer than the head of a recording: it stays.
        if self._sites.find_site(head.site) is None:
            description = load_site(head.description)
            await self._history.describe_site(description)
            await self._registry.said_hello(head.site, head.description, "", "")
            live = self._sites.describe_site(description, "")
            live.presence.why = "only recordings of it were imported"
            self._alarms.redescribe(live)
        message = f"{head.file}: {how.stored} samples, {how.there} were there already"
        self._audit.append_record(
            "history imported", who="command line", message=message, site=head.site
        )
