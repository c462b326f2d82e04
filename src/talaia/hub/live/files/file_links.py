"""The third connection of a gateway: files to the hub, and releases from it, piece by piece."""

from __future__ import annotations

import asyncio
from typing import TYPE_CHECKING

from starlette.websockets import WebSocketDisconnect

from talaia.first_completed import until_first
from talaia.hub.errors import StoreDown
from talaia.hub.live.gateways.doubles.duplicate_gateways import KEPT_OUT, is_beside_link
from talaia.hub.live.gateways.flood_guard import HELD_OFF, TRY_LATER
from talaia.hub.live.gateways.gateway_words import with_known_who
from talaia.hub.live.gateways.handed_down import HandedDown
from talaia.wire.errors import PeerError
from talaia.wire.frames import (
    ASSET_KIND,
    FILES_FROM_GATEWAY,
    FILES_FROM_HUB,
    ArchiveOffer,
    Bye,
    FileOffer,
    FilmOffer,
    ReleaseRequest,
)

if TYPE_CHECKING:
    from starlette.websockets import WebSocket

    from talaia.hub.live.assets.robot_assets import RobotAssets
    from talaia.hub.live.files.recordings import Recordings
    from talaia.hub.live.files.uploads import Uploads
    from talaia.hub.live.gateways.flood_guard import FloodGuard
    from talaia.hub.live.gateways.open_links import OpenLinks
    from talaia.hub.live.releases.release_folder import ReleaseFolder
    from talaia.hub.live.sites import Sites
    from talaia.hub.store.sites.site_registry import GatewayKey
    from talaia.wire.frames import FilePiece, FileProgress, ReleasePiece

__all__ = ["FileLinks", "GatewayFiles"]

# One that does not read must not hold up the end (s).
_FAREWELL_S = 0.5
# What a socket raises when the other side has gone or does not take anything.
_GONE = (WebSocketDisconnect, RuntimeError, OSError, TimeoutError)


class GatewayFiles:
    """One open connection that brings files."""

    def __init__(self, socket: WebSocket) -> None:
        """Speak over ``socket``, which is accepted already."""
        self._socket = socket
        # Somebody has dismissed it.
        self._over = asyncio.Event()
        # Why; the first reason stays.
        self._reason = ""

    def dismiss_gateway(self, reason: str) -> None:
        """Say good-bye and close."""
        self._reason = self._reason or reason
        self._over.set()

    async def serve_files(self, keepers: FileLinks, key: GatewayKey) -> None:
        """Take files until either side ends it."""
        results = await until_first(self._read_events(keepers, key), self._over.wait())
        reason, code = self._reason, 1000
        for result in results:
            if isinstance(result, PeerError):
                reason, code = result.problem, result.code
            elif isinstance(result, StoreDown):
                # 1013: try again later; what has come stays.
                reason, code = "the hub cannot store anything now; try again later", 1013
            elif isinstance(result, Exception) and not isinstance(result, _GONE):
                raise result
        await self.send_farewell(reason, code)

    async def send_farewell(self, reason: str, code: int, after_s: float = 0.0) -> None:
        """Say one last thing and close; ``after_s`` is when to come back, 0 leaves that open."""
        try:
            async with asyncio.timeout(_FAREWELL_S):
                said = Bye(reason=reason[:2000], after_s=after_s)
                await self._socket.send_bytes(FILES_FROM_HUB.encode(said))
                await self._socket.close(code)
        except _GONE:
            return

    async def _read_events(self, keepers: FileLinks, key: GatewayKey) -> None:
        site = key.site
        # The file that is being sent on this connection: pieces name it by its id.
        offered: FileOffer | FilmOffer | ArchiveOffer | None = None
        while True:
            event = await self._socket.receive()
            if event["type"] == "websocket.disconnect":
                return
            data = event.get("bytes")
            message = FILES_FROM_GATEWAY.decode(event.get("text", "") if data is None else data)
            await keepers.flood_guard.admit_frame(key, message)
            match message:
                case FileOffer() | FilmOffer() | ArchiveOffer():
                    offered = message
                    answer = await keepers.answer_offer(site, message)
                case ReleaseRequest():
                    piece = await keepers.read_release(site, message)
                    await self._socket.send_bytes(FILES_FROM_HUB.encode(piece))
                    continue
                case _:
                    if offered is None or offered.id != message.id:
                        raise PeerError("a piece of a file that was not offered")
                    answer = await keepers.append_piece(site, offered, message)
            await self._socket.send_bytes(FILES_FROM_HUB.encode(answer))


class FileLinks:
    """Takes in the files of gateways: recordings, films and pictures for the archive.

    Attributes:
        flood_guard: slows who says too much, and cuts them off.

    """

    def __init__(
        self,
        *,
        sites: Sites,
        links: OpenLinks,
        flood_guard: FloodGuard,
        recordings: Recordings,
        uploads: Uploads,
        assets: RobotAssets,
        releases: ReleaseFolder,
    ) -> None:
        """Keep in ``recordings``, ``uploads`` and ``assets``; ``links`` closes revoked keys'.

        ``sites`` know in whose names something was asked of each; ``flood_guard`` slows who says
        too much; ``releases`` are for gateways to fetch.
        """
        self.flood_guard = flood_guard
        self._sites = sites
        self._links = links
        self._recordings = recordings
        self._uploads = uploads
        self._assets = assets
        self._releases = releases

    async def serve_socket(self, socket: WebSocket, key: GatewayKey) -> None:
        """Take a gateway's recordings and pictures until it has handed over all."""
        files = GatewayFiles(socket)
        # As on the link itself: files are no way round a hold.
        if held_s := self.flood_guard.held_s(key):
            await files.send_farewell(HELD_OFF, TRY_LATER, held_s)
            return
        # What a gateway that waits would hand over stands under the site's name.
        if not is_beside_link(self._sites.find_site(key.site), key):
            await files.send_farewell(KEPT_OUT, TRY_LATER)
            return
        with self._links.count_open(key.id, files):
            await files.serve_files(self, key)

    async def answer_offer(
        self, site: str, offer: FileOffer | FilmOffer | ArchiveOffer
    ) -> FileProgress:
        """Lead an offer to who keeps its kind."""
        if isinstance(offer, ArchiveOffer):
            return await self._keeper_of(offer).answer_offer(site, offer)
        live = self._sites.find_site(site)
        known = HandedDown() if live is None else live.handed_down
        return await self._recordings.answer_offer(site, with_known_who(known, offer))

    async def read_release(self, site: str, asked: ReleaseRequest) -> ReleasePiece:
        """Read a piece of a release that the site's gateway was offered."""
        return await asyncio.to_thread(self._releases.read_piece, asked.version, site, asked.at)

    async def append_piece(
        self, site: str, offer: FileOffer | FilmOffer | ArchiveOffer, piece: FilePiece
    ) -> FileProgress:
        """Lead a piece to who keeps its file."""
        if isinstance(offer, ArchiveOffer):
            return await self._keeper_of(offer).append_piece(site, offer, piece)
        return await self._recordings.append_piece(site, offer, piece)

    def _keeper_of(self, offer: ArchiveOffer) -> Uploads | RobotAssets:
        return self._assets if offer.kind == ASSET_KIND else self._uploads
