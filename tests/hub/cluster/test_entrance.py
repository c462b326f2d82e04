"""A hub that ends sends its sockets away a few at a time, and answers requests to their end."""

import asyncio

import msgspec

from talaia.hub.cluster.entrance import Entrance
from talaia.hub.cluster.frames import FrameKind, TunnelFrame


async def never() -> dict:
    return await asyncio.Future()


def scope_of(kind: str, path: str) -> dict:
    return {"type": kind, "path": path, "headers": [], "client": None, "server": None}


async def test_sockets_go_in_groups_pages_before_gateways_and_requests_stay() -> None:
    closed: list[str] = []
    ended: list[bytes] = []

    async def post(name, _lane, frame) -> None:
        # The lead lets each socket in at once.
        if frame.kind is FrameKind.OPEN:
            payload = msgspec.msgpack.encode({"type": "websocket.accept"})
            door.receive_frame(name, TunnelFrame(FrameKind.LAST, name.number, 0, payload))
        elif frame.kind is FrameKind.END:
            ended.append(frame.payload)

    door = Entrance(find_lead=lambda: "lead", post=post)

    def serve(kind: str, path: str) -> asyncio.Task:
        async def send(message) -> None:
            if message["type"] == "websocket.close":
                assert message["code"] == 1012
                closed.append(path)

        return asyncio.create_task(door.serve_request(scope_of(kind, path), never, send))

    tasks = [serve("websocket", "/gateway/link") for _ in range(50)]
    tasks += [serve("websocket", "/ws") for _ in range(50)]
    download = serve("http", "/api/files")
    for _ in range(4):
        # Their turns, until each has asked the lead.
        await asyncio.sleep(0)
    assert len(door._open) == 101
    sizes = []
    handing = asyncio.create_task(door.hand_over("the hub ends", pause_s=0.0))
    while not handing.done():
        before = len(door._open)
        await asyncio.sleep(0)
        sizes.append(before - len(door._open))
    await asyncio.gather(*tasks)
    # A hundred in twenty groups.
    assert max(sizes) <= 5
    assert closed == ["/ws"] * 50 + ["/gateway/link"] * 50
    # At the lead, what they held is free at once.
    assert ended == [b"the hub ends"] * 100
    assert not download.done()
    download.cancel()
    await asyncio.gather(download, return_exceptions=True)
