"""Recordings to the hub: on a connection of their own, slowly, and on from where it was cut."""

from __future__ import annotations

import asyncio
import logging
from typing import TYPE_CHECKING
from zlib import crc32

from talaia.gateway.errors import LinkLost
from talaia.gateway.uplink.connection import dial
from talaia.wire.frames import (
    FILES_FROM_GATEWAY,
    FILES_FROM_HUB,
    PIECE,
    FileHave,
    FileOffer,
    FilePiece,
)

if TYPE_CHECKING:
    from collections.abc import Callable

    from websockets.asyncio.client import ClientConnection

    from talaia.gateway.recording.shelf import Kept, Shelf
    from talaia.gateway.settings import Settings
    from talaia.gateway.uplink.tls import Trust

__all__ = ["offer_of", "send_files"]

log = logging.getLogger(__name__)
ANSWER_S = 20.0
# The hub checks the digest of the whole file before it says that it has it.
DONE_S = 120.0
REST_S = 0.05


async def send_files(
    settings: Settings,
    trust: Trust,
    shelf: Shelf,
    rate: float,
    busy: Callable[[], bool],
    up: Callable[[], None],
) -> None:
    """Hand over all that waits; returns when nothing does.

    Args:
        settings: where the hub is, and who we are.
        trust: how the hub proves itself.
        shelf: what waits.
        rate: bytes a second, at the most.
        busy: tells that something more urgent waits to be sent.
        up: called once the connection stands.

    Raises:
        LinkLost: the connection was lost, or the hub does not answer.

    """
    waiting = await asyncio.to_thread(shelf.waiting)
    if not waiting:
        return
    async with dial(settings, trust, "/gateway/files") as socket:
        up()
        while waiting:
            for kept in waiting:
                await _send(socket, shelf, kept, rate, busy)
            waiting = await asyncio.to_thread(shelf.waiting)


def offer_of(kept: Kept) -> FileOffer:
    """Say what a recording is."""
    return FileOffer(
        id=kept.id,
        size=kept.size,
        digest=kept.digest,
        begin_us=kept.begin_us,
        end_us=kept.end_us,
        why=kept.why[:2000],
        who=kept.who[:200],
        messages=kept.messages,
        topics=kept.topics[:1000],
        note=kept.note[:2000],
    )


async def _send(
    socket: ClientConnection, shelf: Shelf, kept: Kept, rate: float, busy: Callable[[], bool]
) -> None:
    has = await _ask(socket, offer_of(kept), DONE_S)
    while not has.done and not has.refused:
        if not 0 <= has.have < kept.size:
            raise LinkLost(f"the hub says it has {has.have} of {kept.size} bytes, and is not done")
        data = await asyncio.to_thread(shelf.read, kept.id, has.have, PIECE)
        while busy():  # noqa: ASYNC110 - who is more urgent has more to do than to tell us
            await asyncio.sleep(REST_S)
        last = has.have + len(data) >= kept.size
        piece = FilePiece(id=kept.id, at=has.have, check=crc32(data), data=data)
        has = await _ask(socket, piece, DONE_S if last else ANSWER_S)
        await asyncio.sleep(len(data) / rate)
    if has.refused:
        log.warning("the hub does not take the recording %s: %s", kept.id, has.refused)
        shelf.refuse(kept.id)
    else:
        log.info("the recording %s is at the hub", kept.id)
        await asyncio.to_thread(shelf.remove, kept.id)


async def _ask(socket: ClientConnection, frame: FileOffer | FilePiece, within_s: float) -> FileHave:
    await socket.send(FILES_FROM_GATEWAY.encode(frame))
    try:
        async with asyncio.timeout(within_s):
            data = await socket.recv()
    except TimeoutError as error:
        raise LinkLost(f"the hub has not answered for {within_s:.0f} s") from error
    answer = FILES_FROM_HUB.decode(data)
    if not isinstance(answer, FileHave):
        raise LinkLost(f"the hub closes the connection: {answer.reason}")
    if answer.id != frame.id:
        raise LinkLost(f"the hub answers for {answer.id} instead of {frame.id}")
    return answer
