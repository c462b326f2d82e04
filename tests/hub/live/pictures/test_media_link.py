"""What a gateway's media connection leaves to everything else in the hub."""

from __future__ import annotations

import asyncio

from talaia.hub.live.pictures.media_link import GatewayCamera, MediaReceivers
from talaia.wire.frames import MEDIA_FROM_GATEWAY, TapMessage

PIECE = 64 * 1024


class ReadySocket:
    """A socket of which all has come already, so that nobody waits for it."""

    def __init__(self, frames: list[bytes]) -> None:  # noqa: D107
        self._events = [{"type": "websocket.receive", "bytes": frame} for frame in frames]
        self._events.append({"type": "websocket.disconnect"})

    async def receive(self) -> dict[str, object]:
        return self._events.pop(0)

    async def send_bytes(self, data: bytes) -> None:
        """Nobody reads it."""

    async def close(self, code: int) -> None:
        """It is closed already."""


async def test_between_the_pieces_of_a_large_message_everything_else_has_a_turn() -> None:
    size = 16 * PIECE
    frames = [
        MEDIA_FROM_GATEWAY.encode(
            TapMessage(
                number=1, seq=1, log_us=0, publish_us=0, kept=False,
                size=size, at=at, data=bytes(PIECE),
            )
        )
        for at in range(0, size, PIECE)
    ]  # fmt: skip
    events: list[str] = []

    async def drive() -> None:
        for _ in frames:
            events.append("drive")
            await asyncio.sleep(0)

    async def admit(_message: object) -> None:
        """Let it in."""

    receivers = MediaReceivers(
        picture=lambda _: None,
        trouble=lambda _: None,
        boxes=lambda _: None,
        overlay=lambda _: None,
        taps=lambda _: events.append("piece"),
        admit=admit,
    )
    driving = asyncio.create_task(drive())
    camera = GatewayCamera(ReadySocket(frames))  # type: ignore[arg-type]
    await camera.serve(receivers, lambda: 0)
    await driving
    # One after the other, but for where the two begin.
    first = events.index("piece")
    assert events[first : first + 20] == ["piece", "drive"] * 10
