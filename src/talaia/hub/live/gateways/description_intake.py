"""What a gateway says of its site while the link stands: taken in without holding up the link.

Long, because a description's way from its text to tables and pages is one sequence.
"""

from __future__ import annotations

import asyncio
import logging
from typing import TYPE_CHECKING

from sqlalchemy.exc import SQLAlchemyError

from talaia.errors import TalaiaError
from talaia.hub.history.errors import HistoryAway
from talaia.hub.live.gateways.fingerprint import fingerprint_of
from talaia.hub.live.gateways.gateway_words import is_described
from talaia.hub.live.gateways.handed_down import HandedDown
from talaia.model.checks.site_checks import raise_first
from talaia.model.errors import DescriptionError
from talaia.model.renames import list_renames
from talaia.model.yaml_text.load import load_site
from talaia.wire import frames
from talaia.wire.errors import PeerError
from talaia.wire.sealing import decompress_text, digest_of

if TYPE_CHECKING:
    from collections.abc import Mapping, Sequence

    from talaia.hub.live.gateways.change_requests import ChangeRequestClient
    from talaia.hub.live.gateways.channel_maps import ChannelMaps
    from talaia.hub.live.gateways.ingest import Ingest
    from talaia.hub.live.gateways.join_queue import JoinQueue
    from talaia.hub.live.gateways.robot_events import RobotEvents, RobotMessage
    from talaia.hub.live.pictures.picture_fanout import PictureFanout
    from talaia.hub.live.sites import LiveSite, Sites
    from talaia.hub.ports import History
    from talaia.hub.store.sites.descriptions import Descriptions
    from talaia.hub.store.sites.site_registry import SiteRegistry
    from talaia.model.description_follower import DescriptionFollower
    from talaia.model.site import Site

__all__ = ["DescriptionIntake", "Redescription", "source_of"]

_LOG = logging.getLogger(__name__)
# Between two attempts while the database fails (s).
_RETRY_S = 1.0
# States of things that are not known yet, and descriptions, that wait: a gateway that sends more
# does not mean them.
_MOST_DEFERRED = 1000
_MOST_PENDING = 20
# While these are raised the database is away; anything else is a defect.
_STORE_FAILS = (SQLAlchemyError, TalaiaError, OSError)


def source_of(message: frames.Hello | frames.DescriptionUpdate) -> str:
    """Give a description's text as a person wrote it; empty if the gateway says none.

    Raises:
        PeerError: it cannot be unpacked.

    """
    return decompress_text(message.source) if message.source else ""


class DescriptionIntake:
    """Puts another description in a site's place: history, tables, pages, versions."""

    def __init__(
        self,
        *,
        sites: Sites,
        followers: Sequence[DescriptionFollower[LiveSite]],
        reporting: RobotEvents,
        media: PictureFanout,
        history: History,
        registry: SiteRegistry,
        versions: Descriptions,
        changes: ChangeRequestClient,
    ) -> None:
        """Show a description to ``followers`` in their order, and keep it in ``versions``."""
        self._sites = sites
        self._followers = followers
        self._reporting = reporting
        self._media = media
        self._history = history
        self._registry = registry
        self._versions = versions
        # Knows why a change was asked for, and who waits for its end.
        self._changes = changes

    def has_news(self, hello: frames.Hello, site: str, source: str) -> bool:
        """Tell whether something of a hello is to be stored: it is not word for word as before."""
        live = self._sites.find_site(site)
        return (
            live is None
            or live.gateway.fingerprint != fingerprint_of(hello.description, hello.catalogue)
            or live.gateway.digest != digest_of(source or hello.description)
        )

    async def handle_hello(
        self,
        hello: frames.Hello,
        description: Site,
        source: str,
        *,
        gateway: int,
        turns: JoinQueue,
    ) -> Mapping[str, str]:
        """Take in what a gateway says of its site when it comes; one that says the same waits not.

        Returns:
            What channels are called from now on, by their former addresses, where the history is
            away and that has to be stored before anything else.

        Raises:
            SQLAlchemyError, TalaiaError, OSError: not all of it is stored.

        """
        # Turns are for what is stored.
        if not self.has_news(hello, description.site, source):
            return {}
        async with turns.wait_turn():
            return await self._store_hello(hello, description, source, gateway)

    async def _store_hello(
        self, hello: frames.Hello, description: Site, source: str, gateway: int
    ) -> Mapping[str, str]:
        site = description.site
        live = self._sites.find_site(site)
        told = fingerprint_of(hello.description, hello.catalogue)
        # Word for word what it said before: there is nothing to store.
        if live is None or live.gateway.fingerprint != told:
            # Before `describe`, which would make new channels for the new names.
            if live is not None:
                moves = list_renames(live.description, description)
                try:
                    await self._history.rename_channels(site, moves)
                except HistoryAway:
                    # The description of before stays in the registry: a hub that is started anew
                    # meanwhile finds the same new names again.
                    return moves
            await self._registry.said_hello(site, hello.description, hello.catalogue, hello.version)
            await self._history.describe_site(description)
        # The text that a person wrote may change while what it describes does not.
        if self.has_news(hello, site, source):
            note = "first seen" if live is None else "changed at the gateway"
            await self._versions.add_version(
                site, source or hello.description, gateway=gateway, who="", note=note
            )
        return {}

    def notify_followers(self, live: LiveSite) -> None:
        """Let every part that follows a description take the site's new one."""
        for follower in self._followers:
            follower.redescribe(live)

    def receive_change_state(self, live: LiveSite, state: frames.ChangeState) -> None:
        """Pass on what a gateway says of a change."""
        self._changes.receive_state(live, state)

    def link_lost(self, live: LiveSite) -> None:
        """Nobody answers for the changes that were asked for."""
        self._changes.link_lost(live)

    def report_devices(self, live: LiveSite, states: list[RobotMessage]) -> None:
        """Tell what was said of things that were not known yet."""
        for state in states:
            self._reporting.publish_message(live, state)

    def note_of(self, told: frames.DescriptionUpdate) -> str:
        """Say in a few words how a description came about; asked when it comes."""
        kept = "sent through the hub" if told.id else "changed at the gateway"
        return self._changes.note_of(told.id) or kept

    async def store_version(
        self,
        description: Site,
        told: frames.DescriptionUpdate,
        *,
        said: str,
        source: str,
        note: str,
    ) -> int:
        """Make room in the history for what is described, and keep it; the version's number.

        Raises:
            SQLAlchemyError, TalaiaError, OSError: not all of it is stored; it may be done again.

        """
        site = description.site
        live = self._sites.find_site(site)
        await self._history.describe_site(description)
        await self._registry.said_hello(site, said, told.catalogue)
        gateway = 0 if live is None else live.gateway.id
        return await self._versions.add_version(
            site, source or said, gateway=gateway, who=_known_who(live, told), note=note
        )

    def show_description(
        self,
        live: LiveSite,
        description: Site,
        told: frames.DescriptionUpdate,
        *,
        said: str,
        source: str,
        number: int,
    ) -> None:
        """Let pages follow: at one blow they are shown the new channels and devices."""
        for name in sorted(live.current.interlocks.keys() - description.interlocks.keys()):
            # Pages that show it as locked are told while it is known by name.
            self._reporting.publish_message(
                live, frames.InterlockState(interlock=name, locked=False)
            )
        # Nothing is awaited from here on: no page and no part sees half of it.
        self._sites.describe_site(description, told.catalogue, told.renamed)
        # A hello that says the same is known by it.
        live.gateway.fingerprint = fingerprint_of(said, told.catalogue)
        live.gateway.source = source
        live.gateway.digest = digest_of(source or said)
        # What was wrong with its file is put right: this text can be used.
        live.gateway.problem = None
        live.drop_undescribed()
        self.notify_followers(live)
        self._media.watch(live.name)
        self._reporting.publish_description(live)
        self._reporting.report_event(
            live,
            "description changed",
            who=_known_who(live, told),
            message=f"version {number} of the description",
        )


class Redescription:
    """The descriptions that come over one link, one after the other."""

    def __init__(
        self, describing: DescriptionIntake, live: LiveSite, lists: ChannelMaps, ingest: Ingest
    ) -> None:
        """Follow for ``live``; batches are read by ``lists`` and stored by ``ingest``."""
        self._describing = describing
        self._live = live
        self._lists = lists
        self._ingest = ingest
        # Each with its note, and what is set once its channels are renamed in the history.
        self._waiting: asyncio.Queue[tuple[frames.DescriptionUpdate, str, asyncio.Event]] = (
            asyncio.Queue()
        )
        # States of devices that came while a description was waiting; told after it is shown.
        self._later: list[RobotMessage] = []
        # Descriptions that came and are not shown yet.
        self.pending = 0

    def enqueue_description(self, told: frames.DescriptionUpdate) -> None:
        """Take a description; from here on batches may be numbered by its list."""
        # At once, though it is not stored yet: the next batch may be numbered by it.
        self._lists.add_map(told.catalogue, told.addresses, told.renamed)
        # Former addresses lead to the newest ones.
        renamed = {old: told.renamed.get(new, new) for old, new in self._live.renamed.items()}
        self._live.renamed = {**renamed, **told.renamed}
        if self.pending >= _MOST_PENDING:
            raise PeerError(f"{_MOST_PENDING} descriptions wait already")
        self.pending += 1
        # Asked now: whoever asked for the change may have given up waiting when it is stored.
        note = self._describing.note_of(told)
        self._waiting.put_nowait((told, note, self._ingest.rename_channels(told.renamed)))

    def defers(self, state: RobotMessage) -> bool:
        """Keep a state of what only the description in hand may bring; tell whether it is one."""
        if not self.pending or is_described(self._live, state):
            return False
        if len(self._later) < _MOST_DEFERRED:
            self._later.append(state)
        return True

    async def run(self) -> None:
        """Put each in its place until cancelled.

        Raises:
            PeerError: what came is no description that can be used.

        """
        while True:
            told, note, renamed = await self._waiting.get()
            # Before channels of the new names are made.
            await renamed.wait()
            await self._apply_update(told, note)
            self.pending -= 1
            later, self._later = self._later, []
            self._describing.report_devices(self._live, later)

    async def _apply_update(self, told: frames.DescriptionUpdate, note: str) -> None:
        live = self._live
        source = source_of(told)
        # A large description takes a while to read: not in the way of other links.
        said, description = await asyncio.to_thread(_read_description, told.description)
        if description.site != live.name:
            raise PeerError(f"the description is of {description.site!r}, not {live.name!r}")
        # Samples are numbered by that list: by another, values would go to other channels.
        if [channel.address for channel in description.channels()] != list(told.addresses):
            raise PeerError("the description has other channels than its list")
        number = await self._store_version(description, told, said=said, source=source, note=note)
        self._describing.show_description(
            live, description, told, said=said, source=source, number=number
        )
        # From here on samples are shown by the new numbers.
        self._lists.show_channels(tuple(channel.address for channel in live.channels))
        _LOG.info("%s is described anew: version %d", live.name, number)

    async def _store_version(
        self,
        description: Site,
        told: frames.DescriptionUpdate,
        *,
        said: str,
        source: str,
        note: str,
    ) -> int:
        """Store it, however long the database is away; give the version's number."""
        failing = False
        while True:
            try:
                return await self._describing.store_version(
                    description, told, said=said, source=source, note=note
                )
            except _STORE_FAILS:
                if not failing:
                    _LOG.exception(
                        "a description of %s cannot be stored; it waits", self._live.name
                    )
                failing = True
                await asyncio.sleep(_RETRY_S)


def _known_who(live: LiveSite | None, told: frames.DescriptionUpdate) -> str:
    """Give who is said to have changed it, marked where the hub never handed them down."""
    return (HandedDown() if live is None else live.handed_down).known_name(told.who)


def _read_description(data: bytes) -> tuple[str, Site]:
    said = decompress_text(data)
    try:
        return said, raise_first(load_site(said))
    except DescriptionError as error:
        raise PeerError(f"a description that cannot be used: {error}") from error
