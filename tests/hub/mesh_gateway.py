"""A scripted gateway that hands out files of its robot, as a real one does or as none should."""

# ruff: noqa: D107
from __future__ import annotations

import asyncio
import hashlib
from zlib import crc32

import msgspec
import websockets
from patience import until_answered
from rosbags.typesys import Stores, get_typestore

from talaia.wire.frames import (
    ASSET_KIND,
    FILES_FROM_GATEWAY,
    FILES_FROM_HUB,
    ArchiveOffer,
    AssetRequest,
    AssetState,
    FilePiece,
    FileProgress,
    TapMessage,
    TapSchema,
    TapSubscription,
    TopicEntry,
    TopicList,
    Welcome,
    asset_file_id,
)

from .conftest import DESCRIPTION, Gateway, RunningHub

__all__ = ["DESCRIBED", "MODEL_TOPIC", "SHUT", "MeshGateway", "digest_of"]

# Whoever may view the robot may have its topics.
DESCRIBED = DESCRIPTION + '\ntopics:\n  - {pattern: "/**", right: view}\n'
SHUT = DESCRIBED.replace("right: view}\n", "right: admin}\n")
MODEL_TOPIC = "/robot_description"
_KIND = "std_msgs/msg/String"
_PIECE = 1_000


def digest_of(data: bytes) -> str:
    return hashlib.sha256(data).hexdigest()


class MeshGateway:
    """Answers what it is asked with ``files``; what it does else, a test says.

    Attributes:
        files: by name.
        asked: what the hub has asked for, with whether it wants the file.
        pieces: how many pieces of files it has sent.
        cut_after: the connection for files breaks off after so many pieces.
        sent: what goes in place of a file, by its name.
        answers: whether it answers at all.

    """

    def __init__(self, hub: RunningHub, files: dict[str, bytes]) -> None:
        self.hub, self.files = hub, files
        self.asked: list[tuple[str, bool]] = []
        self.pieces = 0
        self.cut_after = 10**9
        self.sent: dict[str, bytes] = {}
        self.answers = True
        self.progress: list[FileProgress] = []
        self.link: Gateway
        self._serving: list[asyncio.Task[None]] = []
        # What the robot publishes, whether somebody takes it, and how often it was said.
        self._model, self._taken, self._number = "", False, 0

    async def open(self, description: str = DESCRIBED, *, takes: bool = True) -> None:
        """Link; without ``takes`` as a gateway of before."""
        self.link = await self.hub.gateway()
        hello = self.link.hello_message(description)
        taken = [AssetRequest.__struct_config__.tag] if takes else []
        await self.link.say(msgspec.structs.replace(hello, takes=taken))
        await self.link.hear(Welcome)
        self.media = await self.hub.camera()
        topic = TopicEntry(number=1, topic=MODEL_TOPIC, type=_KIND, latched=True)
        await self.media.say(TopicList(topics=[topic]))
        serving = (self._serve(), self._serve_topics())
        self._serving = [asyncio.create_task(one) for one in serving]

    async def close(self) -> None:
        """Be gone."""
        self._taken = False
        for task in self._serving:
            task.cancel()
        await asyncio.gather(*self._serving, return_exceptions=True)
        await self.link.close()

    async def publish_model(self, text: str) -> None:
        """Say the robot's description, now and to whoever takes it later."""
        self._model = text
        if self._taken:
            await self._say_model()

    async def _serve_topics(self) -> None:
        while True:
            said = await self.link.hear(TapSubscription)
            if _KIND in said.types:
                schema = {"encoding": "ros2msg", "message_encoding": "cdr"}
                await self.media.say(TapSchema(type=_KIND, definition="string data", **schema))
            began, self._taken = not self._taken, MODEL_TOPIC in said.topics
            if began and self._taken and self._model:
                await self._say_model()

    async def _say_model(self) -> None:
        store = get_typestore(Stores.LATEST)
        raw = bytes(store.serialize_cdr(store.types[_KIND](data=self._model), _KIND))
        self._number += 1
        message = {"number": 1, "seq": self._number, "log_us": 1, "kept": True}
        await self.media.say(TapMessage(**message, size=len(raw), data=raw))

    async def _serve(self) -> None:
        while True:
            asked = await self.link.hear(AssetRequest)
            self.asked.append((asked.uri, asked.fetch))
            if self.answers:
                await self._answer(asked)

    async def _answer(self, asked: AssetRequest) -> None:
        data = self.files.get(asked.uri)
        if data is None:
            await self.link.say(AssetState(uri=asked.uri, problem="it is not there"))
            return
        state = AssetState(uri=asked.uri, size=len(data), digest=digest_of(data))
        await self.link.say(state)
        if asked.fetch:
            await self.send_file(self.sent.get(asked.uri, data), digest_of(data))

    async def until_asked(self, times: int) -> None:
        """Wait until the hub has asked so often."""

        async def asked() -> bool:
            return len(self.asked) >= times

        await until_answered(asked)

    async def send_file(self, data: bytes, digest: str, *, size: int = -1) -> FileProgress:
        """Hand a file over as one of a digest; gives the hub's last word."""
        offer = ArchiveOffer(
            id=asset_file_id(digest),
            kind=ASSET_KIND,
            size=len(data) if size < 0 else size,
            digest=digest,
        )
        files = await self.hub.dial(
            "/gateway/files", {"Authorization": f"Bearer {self.hub.keys['agv']}"}
        )
        try:
            said = await self._say(files, offer)
            while not said.done and not said.refused:
                part = data[said.have : said.have + _PIECE]
                if not part or self.pieces >= self.cut_after:
                    break
                self.pieces += 1
                piece = FilePiece(id=offer.id, at=said.have, check=crc32(part), data=part)
                have, said = said.have, await self._say(files, piece)
                # The hub wants all of it anew: it is not what its digest says.
                if said.have < have:
                    break
            return said
        finally:
            await files.close()

    async def _say(self, files: websockets.ClientConnection, message) -> FileProgress:
        await files.send(FILES_FROM_GATEWAY.encode(message))
        said = FILES_FROM_HUB.decode(await files.recv())
        assert isinstance(said, FileProgress)
        self.progress.append(said)
        return said
