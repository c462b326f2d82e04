"""Files of robots for whoever may see their model: from the hub's folder, its cache, or the robot.

Long, because asking, taking in and handing out wait for each other.

A file is asked of the gateway once for each link and each time the robot's description comes;
its bytes cross the line only if no file of that content is here.
"""

from __future__ import annotations

import asyncio
import hashlib
from dataclasses import dataclass, field
from typing import TYPE_CHECKING, NamedTuple

from talaia.hub.errors import AssetMissing, AssetRefused, StoreDown
from talaia.hub.live.files.uploads import Uploads
from talaia.wire.asset_uris import is_asset_name, parse_asset_uri
from talaia.wire.frames import ASSET_KIND, MAX_ASSET, AssetRequest, FileProgress, asset_file_id

if TYPE_CHECKING:
    from collections.abc import Callable
    from pathlib import Path

    from talaia.hub.auth.permissions import Grants
    from talaia.hub.live.assets.asset_cache import AssetCache
    from talaia.hub.live.assets.asset_folder import AssetFolder
    from talaia.hub.live.site_state import SiteLink
    from talaia.hub.live.sites import LiveSite, Sites
    from talaia.hub.live.taps.tap_fanout import TapFanout
    from talaia.wire.frames import ArchiveOffer, AssetState, FilePiece

__all__ = ["AssetTimes", "RobotAsset", "RobotAssets"]

# Files of one site that are asked for at once.
_MOST_ASKED = 500
# What a robot's model is published as.
_MODEL, _MODEL_TYPES = "robot_description", frozenset({"std_msgs/msg/String", "std_msgs/String"})
_TAKES = AssetRequest.__struct_config__.tag


class AssetTimes(NamedTuple):
    """How long is waited for a gateway (s).

    Attributes:
        state: until it tells of a file, which it may have to read.
        file: until the file is here, behind others that wait.

    """

    state: float = 30.0
    file: float = 300.0


class RobotAsset(NamedTuple):
    """A file, and the SHA-256 of it."""

    data: bytes
    digest: str


@dataclass(slots=True)
class _SiteAssets:
    """What is under way of one site.

    Attributes:
        turn: counts links and descriptions: what was said before may be otherwise now.
        said: by name, the digest that the gateway has told since.
        asked: by name, who finds out.
        states: by name, who waits for the gateway's word.
        coming: by digest, who wait for a file.

    """

    turn: int = 0
    said: dict[str, str] = field(default_factory=dict)
    asked: dict[str, asyncio.Task[str]] = field(default_factory=dict)
    states: dict[str, asyncio.Future[AssetState]] = field(default_factory=dict)
    coming: dict[str, list[asyncio.Future[None]]] = field(default_factory=dict)


class RobotAssets:
    """See the module. For the loop's thread.

    Attributes:
        cache: what gateways have handed over.
        times: how long is waited for them.

    """

    def __init__(
        self,
        *,
        folder: AssetFolder,
        cache: AssetCache,
        uploads: Path,
        sites: Sites,
        taps: TapFanout,
        times: AssetTimes | None = None,
        has_site: Callable[[str], bool] = lambda _site: True,
    ) -> None:
        """Look in ``folder`` first; gather what comes in ``uploads``, and keep it in ``cache``.

        Of what stands still there, only that of sites which ``has_site`` ends.
        """
        self._folder, self.cache = folder, cache
        self._sites, self._taps = sites, taps
        self.times = times or AssetTimes()
        self._uploads = Uploads(
            uploads,
            {ASSET_KIND: self._keep_file},
            most_bytes=MAX_ASSET,
            share=_allow_share,
            has_site=has_site,
        )
        self._known: dict[str, _SiteAssets] = {}
        taps.on_message = self._hear_message

    def serves_site(self, site: str) -> bool:
        """Tell whether there may be files of a site's robots."""
        live = self._sites.find_site(site)
        return self._folder.has_site(site) or (live is not None and _TAKES in live.gateway.takes)

    async def read_asset(self, site: str, uri: str, grants: Grants) -> RobotAsset:
        """Give a file by its name, ``package://…``, to whom the site's devices are open.

        Raises:
            AssetRefused: there is none that may be sent; in words for people.

        """
        name = parse_asset_uri(uri)
        if name is None:
            raise AssetRefused("files are named package://<package>/<path>")
        if not is_asset_name(name.parts[-1]):
            raise AssetRefused("only meshes, and pictures and materials of meshes, are sent")
        try:
            # A disk may take its time.
            data = await asyncio.to_thread(self._folder.read_file, site, uri)
            digest = await asyncio.to_thread(lambda: hashlib.sha256(data).hexdigest())
            return RobotAsset(data, digest)
        except AssetMissing:
            live = self._sites.find_site(site)
            # What its description names is for those who may have its description.
            if live is None or not self._sees_model(live, grants):
                raise
        digest = await self._find_digest(live, uri)
        kept = await asyncio.to_thread(self.cache.read_file, site, digest)
        if kept is None:
            self._begin_turn(site)
            raise AssetRefused("the hub's copy was damaged; try again")
        return RobotAsset(kept, digest)

    # ── from the links ──

    def link_up(self, site: str) -> None:
        """Ask anew for what was told on the link before: the robot may have other files."""
        self._begin_turn(site)

    def link_lost(self, site: str) -> None:
        """Let nobody wait for a gateway that is gone."""
        known = self._begin_turn(site)
        why = "the connection to the robot's gateway was lost; try again"
        for asked in known.states.values():
            _fail(asked, why)
        for coming in known.coming.values():
            for file in coming:
                _fail(file, why)

    def handle_state(self, site: str, state: AssetState) -> None:
        """Take what a gateway tells; what nobody has asked for is passed over."""
        future = self._of(site).states.pop(state.uri, None)
        if future is not None and not future.done():
            future.set_result(state)

    async def answer_offer(self, site: str, offer: ArchiveOffer) -> FileProgress:
        """Answer the offer of a file: only what was asked for is taken.

        Raises:
            StoreDown: it cannot be taken now.

        """
        waiting = self._of(site).coming.get(offer.digest)
        if not waiting or offer.id != asset_file_id(offer.digest):
            return FileProgress(id=offer.id, refused="nobody asks for it")
        progress = await self._uploads.answer_offer(site, offer)
        for future in waiting if progress.refused else ():
            _fail(future, progress.refused)
        return progress

    async def append_piece(self, site: str, offer: ArchiveOffer, piece: FilePiece) -> FileProgress:
        """Take a piece of an offered file.

        Raises:
            PeerError: it does not fit.
            StoreDown: it cannot be taken now.

        """
        try:
            progress = await self._uploads.append_piece(site, offer, piece)
        except StoreDown as error:
            for future in self._of(site).coming.get(offer.digest, ()):
                _fail(future, str(error))
            raise
        # All of it is there and its digest is another: the gateway may send it again and again.
        if not progress.done and piece.at + len(piece.data) >= offer.size:
            for future in self._of(site).coming.get(offer.digest, ()):
                _fail(future, progress.refused or "the file came damaged from the robot's gateway")
        return progress

    async def end_standing_uploads(self) -> None:
        """End uploads that nobody has gone on with for long."""
        await self._uploads.end_standing_uploads()

    async def close(self) -> None:
        """Wait for nothing any more."""
        tasks = [task for known in self._known.values() for task in known.asked.values()]
        for task in tasks:
            task.cancel()
        await asyncio.gather(*tasks, return_exceptions=True)

    # ── inside ──

    def _hear_message(self, site: str, topic: str, type_name: str) -> None:
        if _is_model(topic, type_name):
            self._begin_turn(site)

    def _of(self, site: str) -> _SiteAssets:
        return self._known.setdefault(site, _SiteAssets())

    def _begin_turn(self, site: str) -> _SiteAssets:
        known = self._of(site)
        known.turn += 1
        known.said.clear()
        return known

    def _sees_model(self, live: LiveSite, grants: Grants) -> bool:
        listed = self._taps.topics(live.name, None)
        topics = [found.topic for found in listed if _is_model(found.topic, found.type)]
        # Of a robot whose topics are not known: what it is published as nearly everywhere.
        return any(self._taps.allows(grants, live, topic) for topic in topics or [f"/{_MODEL}"])

    async def _find_digest(self, live: LiveSite, uri: str) -> str:
        known = self._of(live.name)
        if digest := known.said.get(uri):
            return digest
        task = known.asked.get(uri)
        if task is None:
            if len(known.asked) >= _MOST_ASKED:
                raise AssetRefused("too many files are asked for at once; try again")
            task = asyncio.create_task(self._learn_digest(live, known, uri))
            known.asked[uri] = task
            task.add_done_callback(lambda ended: _forget_task(known, uri, ended))
        # One for all who ask; a page that goes away ends nobody else's.
        return await asyncio.shield(task)

    async def _learn_digest(self, live: LiveSite, known: _SiteAssets, uri: str) -> str:
        """Ask the gateway, and have the file fetched; what was here before counts if it fails."""
        before = await asyncio.to_thread(self.cache.find_digest, live.name, uri)
        turn = known.turn
        try:
            digest = await self._ask_gateway(live, known, uri)
        except AssetRefused:
            # A model of the past, or of a robot that is away, is drawn by what it had last.
            if not before:
                raise
            return before
        if digest != before:
            await asyncio.to_thread(self.cache.name_file, live.name, uri, digest)
        if known.turn == turn:
            known.said[uri] = digest
        return digest

    async def _ask_gateway(self, live: LiveSite, known: _SiteAssets, uri: str) -> str:
        link = live.link
        if link is None:
            raise AssetRefused("the robot's gateway is not connected, and the hub has no copy")
        if _TAKES not in live.gateway.takes:
            raise AssetRefused(
                "the robot's gateway hands out no meshes (it is of an older version, or was told"
                " not to); update it, or put the file into the hub's folder (--assets)"
            )
        digest = await self._ask_state(link, known, uri, fetch=False)
        if await asyncio.to_thread(self.cache.has_file, live.name, digest):
            return digest
        arrived: asyncio.Future[None] = asyncio.get_running_loop().create_future()
        known.coming.setdefault(digest, []).append(arrived)
        try:
            if await self._ask_state(link, known, uri, fetch=True) != digest:
                raise AssetRefused("the file was changed while it was asked for; try again")
            async with asyncio.timeout(self.times.file):
                await arrived
        except TimeoutError as error:
            raise AssetRefused("the file did not come from the robot's gateway in time") from error
        finally:
            known.coming[digest].remove(arrived)
            if not known.coming[digest]:
                del known.coming[digest]
        return digest

    async def _ask_state(self, link: SiteLink, known: _SiteAssets, uri: str, *, fetch: bool) -> str:
        """Ask, and wait for the answer; give the file's digest."""
        future: asyncio.Future[AssetState] = asyncio.get_running_loop().create_future()
        known.states[uri] = future
        link.send(AssetRequest(uri=uri, fetch=fetch))
        try:
            async with asyncio.timeout(self.times.state):
                state = await future
        except TimeoutError as error:
            raise AssetRefused("the robot's gateway does not answer") from error
        finally:
            known.states.pop(uri, None)
        if state.problem or state.digest is None:
            raise AssetRefused(state.problem or "the robot's gateway does not hand it out")
        return state.digest

    async def _keep_file(self, site: str, offer: ArchiveOffer, path: Path) -> None:
        """Take a file that is whole; see `Keeper`."""
        await asyncio.to_thread(self.cache.keep_file, site, offer.digest, path)
        for future in self._of(site).coming.get(offer.digest, ()):
            if not future.done():
                future.set_result(None)


def _is_model(topic: str, type_name: str) -> bool:
    return topic.rsplit("/", 1)[-1] == _MODEL and type_name in _MODEL_TYPES


def _fail(future: asyncio.Future[None] | asyncio.Future[AssetState], why: str) -> None:
    if not future.done():
        future.set_exception(AssetRefused(why))


def _forget_task(known: _SiteAssets, uri: str, ended: asyncio.Task[str]) -> None:
    known.asked.pop(uri, None)
    # Its error is for those who wait; where nobody does any more it is nobody's.
    if not ended.cancelled():
        ended.exception()


async def _allow_share(_site: str, _size: int) -> bool:
    # The cache has a bound of its own.
    return True
