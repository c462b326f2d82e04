"""Releases that the hub offers: what was offered last, and how one is fetched.

They come on the connection for files, the other way round: the gateway asks for each piece, so
nothing of it stands before a driving frame, and what has come stays when the line is lost.
"""

from __future__ import annotations

import asyncio
import hashlib
import os
import shutil
from typing import TYPE_CHECKING
from zlib import crc32

from talaia.gateway.errors import LinkLost
from talaia.gateway.uplink.connection import dial
from talaia.updates.errors import UpdateError
from talaia.wire.frames import (
    FILES_FROM_GATEWAY,
    FILES_FROM_HUB,
    Bye,
    ReleasePiece,
    ReleaseRequest,
)

if TYPE_CHECKING:
    from collections.abc import Callable
    from pathlib import Path

    from talaia.gateway.uplink.key_prover import KeyProver
    from talaia.gateway.uplink.tls import HubTrust
    from talaia.wire.frames import FilesFromHub, ReleaseOffer

__all__ = ["MOST_RELEASE", "OfferedReleases", "fetch_release"]

# The hub reads a piece from its disk.
_ANSWER_S = 20.0
# As much as a release may hold (bytes); see `updates.signed_release`.
MOST_RELEASE = (1 << 30) + (1 << 24)
# The file, its wheels and their environment are on the disk at one time, for a while.
_ROOM = 5


class OfferedReleases:
    """What the hub has offered last. For the loop's thread.

    Attributes:
        takes: whether this hub wants to know how releases stand here.

    """

    def __init__(self) -> None:
        """Begin with no offer, and a hub that knows nothing of releases."""
        self.takes = False
        self._offer: ReleaseOffer | None = None
        self._came = asyncio.Event()

    def link_up(self, *, takes: bool) -> None:
        """Note whether the hub of this link wants to be told."""
        self.takes = takes

    def handle_offer(self, offer: ReleaseOffer) -> None:
        """Keep an offer in the place of one before."""
        self._offer = offer
        self._came.set()

    async def wait_offer(self) -> ReleaseOffer:
        """Wait for an offer that nobody has asked for yet."""
        while self._offer is None:
            self._came.clear()
            await self._came.wait()
        offer, self._offer = self._offer, None
        return offer


async def fetch_release(
    trust: HubTrust,
    prover: KeyProver,
    offer: ReleaseOffer,
    *,
    target: Path,
    rate: float,
    progress: Callable[[int], None],
) -> None:
    """Fetch an offered release into ``target``, on from where it was cut.

    Args:
        trust: where the hub is, and how it proves itself.
        prover: how we do.
        offer: what is fetched.
        target: a file; beside it lies what has not come whole.
        rate: at most so much (bytes/s).
        progress: told how many bytes are there.

    Raises:
        LinkLost: the connection was lost; what has come stays.
        UpdateError: it will not come: it is too large, or no more what was offered.
        OSError: the disk fails.

    """
    if not 0 < offer.size <= MOST_RELEASE:
        raise UpdateError(f"a release of {offer.size} bytes is more than a gateway takes")
    # Named by its content: parts of two files never come together.
    part = target.with_name(f"{offer.digest}.part")
    have = await asyncio.to_thread(_begin_part, part, offer.size)
    progress(have)
    async with dial(trust, prover, "/gateway/files") as socket:
        while have < offer.size:
            asked = ReleaseRequest(version=offer.version, at=have)
            await socket.send(FILES_FROM_GATEWAY.encode(asked))
            try:
                async with asyncio.timeout(_ANSWER_S):
                    answer = FILES_FROM_HUB.decode(await socket.recv())
            except TimeoutError as error:
                raise LinkLost(f"the hub has not answered for {_ANSWER_S:.0f} s") from error
            data = _data_of(answer, asked, offer.size - have)
            have = await asyncio.to_thread(_append_data, part, data)
            progress(have)
            await asyncio.sleep(len(data) / rate)
    if await asyncio.to_thread(_digest_of, part) != offer.digest:
        part.unlink(missing_ok=True)
        raise UpdateError("what came from the hub is not what it had offered")
    await asyncio.to_thread(part.replace, target)


def _data_of(answer: FilesFromHub, asked: ReleaseRequest, most: int) -> bytes:
    if isinstance(answer, Bye):
        raise LinkLost(f"the hub closes the connection: {answer.reason}")
    if isinstance(answer, ReleasePiece) and answer.refused:
        raise UpdateError(f"the hub does not hand it over: {answer.refused}")
    if (
        not isinstance(answer, ReleasePiece)
        or (answer.version, answer.at) != (asked.version, asked.at)
        or not 0 < len(answer.data) <= most
        or crc32(answer.data) != answer.check
    ):
        raise LinkLost("the hub has answered with another piece than was asked for")
    return answer.data


def _begin_part(part: Path, size: int) -> int:
    """Give how much is there; parts of other files go."""
    part.parent.mkdir(parents=True, exist_ok=True, mode=0o700)
    for other in part.parent.iterdir():
        if other != part:
            other.unlink()
    have = part.stat().st_size if part.exists() else 0
    if have > size:
        part.unlink()
        have = 0
    if shutil.disk_usage(part.parent).free < _ROOM * size - have:
        raise UpdateError(
            f"{_ROOM * size // 10**6} MB must be free on the gateway's disk, and are not"
        )
    return have


def _append_data(part: Path, data: bytes) -> int:
    number = os.open(part, os.O_WRONLY | os.O_APPEND | os.O_CREAT | os.O_CLOEXEC, 0o600)
    try:
        os.write(number, data)
        return os.fstat(number).st_size
    finally:
        os.close(number)


def _digest_of(path: Path) -> str:
    with path.open("rb") as file:
        return hashlib.file_digest(file, "sha256").hexdigest()
