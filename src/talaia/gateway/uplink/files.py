"""Files to the hub: on a connection of their own, slowly, and on from where it was cut.

Recordings and pictures go the same way. Nothing of it is on the link, so that not even one piece
ever stands before a driving frame.
"""

from __future__ import annotations

import asyncio
import logging
from typing import TYPE_CHECKING, NamedTuple, Protocol
from zlib import crc32

from talaia.gateway.errors import LinkLost
from talaia.gateway.uplink.connection import dial
from talaia.wire.frames import (
    FILES_FROM_GATEWAY,
    FILES_FROM_HUB,
    PIECE,
    Bye,
    FilePiece,
    FileProgress,
)

if TYPE_CHECKING:
    from collections.abc import Callable, Sequence

    from websockets.asyncio.client import ClientConnection

    from talaia.gateway.uplink.key_prover import KeyProver
    from talaia.gateway.uplink.tls import HubTrust
    from talaia.wire.frames import ArchiveOffer, FileOffer, FilmOffer

    Offer = FileOffer | FilmOffer | ArchiveOffer

__all__ = ["FileLane", "FileSource", "TransferCallbacks", "send_files"]

log = logging.getLogger(__name__)
# For a piece: the hub only writes it down.
ANSWER_S = 20.0
# The hub checks the digest of the whole file before it says that it has it.
DONE_S = 120.0
# Between two looks whether something more urgent still waits.
REST_S = 0.05
# A file that comes damaged so often is damaged here.
MOST_DAMAGED = 3


class FileSource(Protocol):
    """Where files wait on the disk. Its methods block; any thread."""

    def offers(self) -> Sequence[Offer]:
        """List what waits, oldest first."""
        ...

    def read_part(self, name: str, at: int, size: int, /) -> bytes:
        """Read a part; shorter at its end.

        Raises:
            OSError: it cannot be read, or has given way meanwhile.

        """
        ...

    def remove(self, name: str, /) -> None:
        """Forget a file: the hub has it."""
        ...

    def refuse(self, name: str, /) -> None:
        """Offer a file no more: the hub does not want it."""
        ...


class FileLane(NamedTuple):
    """Files of one kind, and how many bytes of them may go in a second.

    Attributes:
        linger_s: after one of them the connection waits so long for another: they are asked for
            one by one, and each new connection costs a proof of the key.

    """

    what: str
    source: FileSource
    rate: float
    linger_s: float = 0.0


class TransferCallbacks(NamedTuple):
    """Who is asked and told meanwhile.

    Attributes:
        busy: tells that something more urgent waits to be sent.
        up: called once the connection stands.
        refused: told what the hub does not take, and why.

    """

    busy: Callable[[], bool]
    up: Callable[[], None]
    refused: Callable[[Offer, str], None]


class _Unknown(Exception):
    """A hub of a version before does not know these files, and says nothing."""


async def send_files(
    trust: HubTrust,
    prover: KeyProver,
    *,
    lanes: Sequence[FileLane],
    sending: TransferCallbacks,
) -> None:
    """Hand over all that waits; returns when nothing does.

    Args:
        trust: where the hub is, and how it proves itself.
        prover: how we do.
        lanes: what waits; what stands first goes first, and in the middle of the others.
        sending: see there.

    Raises:
        LinkLost: the connection was lost, or the hub does not answer.

    """
    # Nothing waits: no connection is opened only to be closed.
    if await _next(lanes) is None:
        return
    async with dial(trust, prover, "/gateway/files") as socket:
        sending.up()
        left, linger_s = list(lanes), 0.0
        while (found := await _next_within(left, linger_s)) is not None:
            lane, offer = found
            linger_s = lane.linger_s
            try:
                await _send(
                    socket=socket,
                    lane=lane,
                    offer=offer,
                    sending=sending,
                    before=left[: left.index(lane)],
                )
            except _Unknown:
                log.warning("the hub takes no %s; they wait until it is updated", lane.what)
                left.remove(lane)


async def _next(lanes: Sequence[FileLane]) -> tuple[FileLane, Offer] | None:
    for lane in lanes:
        offers = await asyncio.to_thread(lane.source.offers)
        if offers:
            return lane, offers[0]
    return None


async def _next_within(lanes: Sequence[FileLane], seconds: float) -> tuple[FileLane, Offer] | None:
    """Give what waits, or comes within ``seconds``."""
    found = await _next(lanes)
    for _ in range(round(seconds / REST_S)):
        if found is not None:
            break
        await asyncio.sleep(REST_S)
        found = await _next(lanes)
    return found


async def _send(
    *,
    socket: ClientConnection,
    lane: FileLane,
    offer: Offer,
    sending: TransferCallbacks,
    before: Sequence[FileLane],
) -> None:
    """Send a file, or as much of it as goes before one of the lanes ``before`` has something."""
    has = await _ask(socket, offer, DONE_S)
    damaged = 0
    while not has.done and not has.refused:
        if not 0 <= has.have < offer.size:
            raise LinkLost(f"the hub says it has {has.have} of {offer.size} bytes, and is not done")
        try:
            data = await asyncio.to_thread(lane.source.read_part, offer.id, has.have, PIECE)
        except OSError as error:
            # It gave way to a newer one, or the disk fails; what is there the next time tells.
            raise LinkLost(f"{offer.id} cannot be read: {error}") from error
        while sending.busy():  # noqa: ASYNC110 - who is more urgent has more to do than to tell us
            await asyncio.sleep(REST_S)
        last = has.have + len(data) >= offer.size
        piece = FilePiece(id=offer.id, at=has.have, check=crc32(data), data=data)
        has = await _ask(socket, piece, DONE_S if last else ANSWER_S)
        if last and not has.done and not has.refused and (damaged := damaged + 1) >= MOST_DAMAGED:
            has = FileProgress(id=offer.id, refused="it is not what its digest says")
            break
        await asyncio.sleep(len(data) / lane.rate)
        if not has.done and before and await _next(before) is not None:
            return
    if has.refused:
        log.warning("the hub does not take %s (%s): %s", offer.id, lane.what, has.refused)
        await asyncio.to_thread(lane.source.refuse, offer.id)
        sending.refused(offer, has.refused)
    else:
        log.info("%s (%s) is at the hub", offer.id, lane.what)
        await asyncio.to_thread(lane.source.remove, offer.id)


async def _ask(socket: ClientConnection, frame: Offer | FilePiece, within_s: float) -> FileProgress:
    await socket.send(FILES_FROM_GATEWAY.encode(frame))
    try:
        async with asyncio.timeout(within_s):
            data = await socket.recv()
    except TimeoutError as error:
        if not isinstance(frame, FilePiece):
            raise _Unknown from error
        raise LinkLost(f"the hub has not answered for {within_s:.0f} s") from error
    answer = FILES_FROM_HUB.decode(data)
    if isinstance(answer, Bye):
        raise LinkLost(f"the hub closes the connection: {answer.reason}")
    if not isinstance(answer, FileProgress):
        raise LinkLost("the hub answers with a release to a file")
    if answer.id != frame.id:
        raise LinkLost(f"the hub answers for {answer.id} instead of {frame.id}")
    return answer
