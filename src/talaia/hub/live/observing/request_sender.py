"""Sends each gateway what is asked of its nights, whenever that changes and it does not have it."""

from __future__ import annotations

import asyncio
import logging
from typing import TYPE_CHECKING

import msgspec

from talaia.hub.errors import StoreDown
from talaia.wire.frames import RequestSync
from talaia.wire.gateway_messages.night import MAX_GROUPS

if TYPE_CHECKING:
    from collections.abc import Iterable, Iterator, Sequence

    from talaia.hub.live.sites import LiveSite, Sites
    from talaia.hub.store.observing.proposals import ProposalStore
    from talaia.hub.store.observing.request_store import RequestStore
    from talaia.model.observing.requests import Proposal, RequestGroup

__all__ = ["RequestSender", "sync_pieces"]

_LOG = logging.getLogger(__name__)
# A driving frame waits for one piece at the most: less than 0.1 s on a line of 4 Mbit/s (bytes).
PIECE_BYTES = 48 * 1024
# Changes that come together make one set (s).
_GATHER_S = 0.2
_RETRY_S = 2.0


class RequestSender:
    """Knows which revision each gateway goes by."""

    def __init__(self, sites: Sites, requests: RequestStore, proposals: ProposalStore) -> None:
        """Send to the gateways of ``sites`` what is kept in the stores."""
        self._sites = sites
        self._requests = requests
        self._proposals = proposals
        # By site: the revision that its gateway has, of this link.
        self._known: dict[str, int] = {}
        self._changed: set[str] = set()
        self._wake = asyncio.Event()

    def requests_changed(self, site: str) -> None:
        """Proposals or requests have changed; never waits."""
        self._changed.add(site)
        self._wake.set()

    def handle_revision(self, live: LiveSite, revision: int) -> None:
        """A gateway says which revision it goes by: at the start of a link, and after each set."""
        self._known[live.name] = revision
        self.requests_changed(live.name)

    def link_lost(self, site: str) -> None:
        """Nothing is known of what a gateway has."""
        self._known.pop(site, None)

    async def run(self) -> None:
        """Send until cancelled."""
        while True:
            await self._wake.wait()
            await asyncio.sleep(_GATHER_S)
            self._wake.clear()
            changed, self._changed = self._changed, set()
            for site in sorted(changed):
                try:
                    await self.send_set(site)
                except StoreDown as error:
                    _LOG.warning("requests of %s are not sent yet: %s", site, error)
                    self._changed.add(site)
            if self._changed:
                await asyncio.sleep(_RETRY_S)
                self._wake.set()

    async def send_set(self, site: str) -> None:
        """Send a site's requests, unless its gateway has them or does not go by them.

        Raises:
            StoreDown: they cannot be read now.

        """
        known = self._known.get(site)
        # One that has not said which it has is older than the night, or not linked.
        if known is None:
            return
        pending = await self._requests.pending_set(site)
        if pending.revision == known:
            return
        revision = pending.revision
        if revision < known:
            # The database was restored from an older backup.
            revision = await self._requests.raise_revision(site, known)
        planned = [kept.planned() for kept in await self._proposals.list_proposals(site)]
        live = self._sites.find_site(site)
        # It may have gone while these were read.
        if live is None or live.link is None or site not in self._known:
            return
        groups = [kept.group for kept in pending.groups]
        for piece in sync_pieces(revision, planned, groups):
            live.link.send(piece)
            # Each is encoded as it is written; the loop has its turn in between.
            await asyncio.sleep(0)


def sync_pieces(
    revision: int, proposals: Sequence[Proposal], groups: Sequence[RequestGroup]
) -> list[RequestSync]:
    """Cut a set into messages; an empty set is one message, too."""
    cut = list(_cut_groups(groups)) or [[]]
    return [
        RequestSync(
            revision=revision,
            piece=at,
            pieces=len(cut),
            proposals=list(proposals) if at == 0 else [],
            groups=piece,
        )
        for at, piece in enumerate(cut)
    ]


def _cut_groups(groups: Iterable[RequestGroup]) -> Iterator[list[RequestGroup]]:
    piece: list[RequestGroup] = []
    size = 0
    for group in groups:
        more = len(msgspec.msgpack.encode(group))
        if piece and (len(piece) == MAX_GROUPS or size + more > PIECE_BYTES):
            yield piece
            piece, size = [], 0
        piece.append(group)
        size += more
    if piece:
        yield piece
