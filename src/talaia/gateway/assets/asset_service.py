"""Answers a hub that asks for files of the robot: one after the other, beside all else."""

from __future__ import annotations

import asyncio
import logging
from typing import TYPE_CHECKING

from talaia.gateway.assets.named_assets import NamedAssets, find_named, is_description
from talaia.gateway.errors import AssetUnavailable
from talaia.wire.asset_uris import parse_asset_uri
from talaia.wire.frames import AssetState

if TYPE_CHECKING:
    from collections.abc import Callable

    from talaia.gateway.assets.asset_outbox import AssetOutbox
    from talaia.gateway.assets.asset_reader import AssetReader, ReadAsset
    from talaia.gateway.tap_ports import ListedTopic
    from talaia.wire.asset_uris import AssetUri
    from talaia.wire.frames import AssetRequest, FromGateway

__all__ = ["AssetService"]

log = logging.getLogger(__name__)
# Requests that wait; a hub asks for some of a model at once.
_MOST_WAITING = 2_000
# Bytes of all files that were handed out since the description was another.
_MOST_MODEL = 256 * 1024 * 1024
_NOT_NAMED = "the robot's description, as it was heard here last, does not name it"


class AssetService:
    """See the module. For the loop's thread, but for `hear_message`."""

    def __init__(
        self,
        *,
        reader: AssetReader | None,
        outbox: AssetOutbox,
        send: Callable[[FromGateway], None],
        announce: Callable[[], None],
    ) -> None:
        """Read by ``reader`` (none: nothing is handed out).

        ``send`` queues an answer, ``announce`` tells that a file waits in the ``outbox``.
        """
        self._reader = reader
        self._outbox = outbox
        self._send, self._announce = send, announce
        self._waiting: asyncio.Queue[AssetRequest] = asyncio.Queue(_MOST_WAITING)
        # By topic: the last description. Replaced by adapters' threads, read on the loop.
        self._heard: dict[str, bytes] = {}
        # Descriptions that were not looked through yet; the newest of each topic counts.
        self._unread: dict[str, bytes] = {}
        self._named = NamedAssets()
        # Of what was handed out, by name (bytes).
        self._sizes: dict[AssetUri, int] = {}

    def hear_message(self, topic: ListedTopic, data: bytes) -> None:
        """Take a message that goes to the hub; any thread. What a description names may follow."""
        if is_description(topic.topic, topic.type_name) and self._heard.get(topic.topic) != data:
            self._heard[topic.topic] = self._unread[topic.topic] = data

    def handle_request(self, asked: AssetRequest) -> None:
        """Answer when those before it are answered."""
        try:
            self._waiting.put_nowait(asked)
        except asyncio.QueueFull:
            self._send(AssetState(uri=asked.uri, problem="too many files are asked for at once"))

    def link_lost(self) -> None:
        """Forget what a hub has asked for that is gone."""
        while not self._waiting.empty():
            self._waiting.get_nowait()
        self._outbox.clear()

    async def answer_requests(self) -> None:
        """Answer what is asked, until cancelled."""
        while True:
            asked = await self._waiting.get()
            try:
                found = await self._examine(asked.uri)
            except AssetUnavailable as refused:
                log.debug("the hub does not get %s: %s", asked.uri, refused)
                self._send(AssetState(uri=asked.uri, problem=str(refused)[:2000]))
                continue
            name = parse_asset_uri(asked.uri)
            if asked.fetch and name is not None:
                self._outbox.add_asset(name, found)
                self._announce()
            self._send(AssetState(uri=asked.uri, size=found.size, digest=found.digest))

    async def _examine(self, uri: str) -> ReadAsset:
        name = parse_asset_uri(uri)
        if self._reader is None:
            raise AssetUnavailable("this gateway hands out no files (--no-meshes)")
        if name is None:
            raise AssetUnavailable("it is no name of a file of a package")
        await self._read_descriptions()
        if not self._named.allows(name):
            raise AssetUnavailable(_NOT_NAMED)
        try:
            found = await asyncio.to_thread(self._reader.examine, name)
        except OSError as error:
            raise AssetUnavailable(f"the file cannot be read: {error.strerror}") from error
        others = sum(size for other, size in self._sizes.items() if other != name)
        if others + found.size > _MOST_MODEL:
            raise AssetUnavailable(
                f"the files of a robot are more than {_MOST_MODEL} bytes together"
            )
        self._sizes[name] = found.size
        self._named.add_companions(name, found.companions)
        return found

    async def _read_descriptions(self) -> None:
        while self._unread:
            topic, data = self._unread.popitem()
            self._named.replace_named(topic, await asyncio.to_thread(find_named, data))
            self._sizes = {
                name: size for name, size in self._sizes.items() if self._named.allows(name)
            }
