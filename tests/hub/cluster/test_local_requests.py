"""Requests that came to the lead itself: they are answered, and end when its hub begins anew."""

# ruff: noqa: D107
from __future__ import annotations

import asyncio

import pytest
from patience import PATIENCE_S

from talaia.hub.cluster.local_requests import LocalRequests

SOCKET = {"type": "websocket", "path": "/ws"}
REQUEST = {"type": "http", "path": "/api/sites"}


class Asker:
    """Whoever came."""

    def __init__(self) -> None:
        self.says: asyncio.Queue = asyncio.Queue()
        self.told = []
        self.let_in, self.answered = asyncio.Event(), asyncio.Event()

    async def send(self, message) -> None:
        self.told.append(message)
        (self.answered if message["type"] == "websocket.send" else self.let_in).set()


async def listen(_scope, receive, send) -> None:
    """Let somebody in, and answer each word until they have gone."""
    assert (await receive())["type"] == "websocket.connect"
    await send({"type": "websocket.accept"})
    while (said := await receive())["type"] == "websocket.receive":
        await send({"type": "websocket.send", "text": said["text"]})


async def stay(_scope, _receive, send) -> None:
    """Let somebody in, and hear nothing of them."""
    await send({"type": "websocket.accept"})
    await asyncio.get_running_loop().create_future()


async def answer(_scope, receive, send) -> None:
    assert (await receive())["type"] == "http.request"
    await send({"type": "http.response.start", "status": 200})
    await send({"type": "http.response.body"})


async def fail(_scope, _receive, _send) -> None:
    raise ValueError("no")


async def test_a_socket_hears_what_is_said_and_is_sent_away_when_all_end() -> None:
    requests, asker = LocalRequests(), Asker()
    asker.says.put_nowait({"type": "websocket.connect"})
    asker.says.put_nowait({"type": "websocket.receive", "text": "one"})
    serving = asyncio.create_task(requests.serve(listen, SOCKET, asker.says.get, asker.send))
    await asyncio.wait_for(asker.answered.wait(), PATIENCE_S)
    await requests.end_all()
    assert await asyncio.wait_for(serving, PATIENCE_S)
    assert [message["type"].partition(".")[2] for message in asker.told] == [
        "accept", "send", "close",
    ]  # fmt: skip
    assert asker.told[-1]["code"] == 1012


async def test_an_application_that_hears_nothing_is_ended() -> None:
    requests, asker = LocalRequests(), Asker()
    serving = asyncio.create_task(requests.serve(stay, SOCKET, asker.says.get, asker.send))
    await asyncio.wait_for(asker.let_in.wait(), PATIENCE_S)
    await requests.end_all()
    await asyncio.wait_for(serving, PATIENCE_S)
    assert [message["type"] for message in asker.told] == ["websocket.accept", "websocket.close"]


async def test_a_request_is_answered_though_all_end_meanwhile() -> None:
    requests, asker = LocalRequests(), Asker()
    serving = asyncio.create_task(requests.serve(answer, REQUEST, asker.says.get, asker.send))
    ending = asyncio.create_task(requests.end_all())
    asker.says.put_nowait({"type": "http.request"})
    await asyncio.wait_for(asyncio.gather(serving, ending), PATIENCE_S)
    assert asker.told[0]["status"] == 200


async def test_what_an_application_raises_is_raised_and_a_server_may_end_it() -> None:
    requests, asker = LocalRequests(), Asker()
    with pytest.raises(ValueError, match="no"):
        await requests.serve(fail, REQUEST, asker.says.get, asker.send)
    serving = asyncio.create_task(requests.serve(stay, SOCKET, asker.says.get, asker.send))
    await asyncio.wait_for(asker.let_in.wait(), PATIENCE_S)
    serving.cancel()
    with pytest.raises(asyncio.CancelledError):
        await serving


async def hold(_scope, receive, _send) -> None:
    """Neither answer nor let anybody in."""
    await receive()
    await asyncio.get_running_loop().create_future()


async def fail_late(_scope, receive, send) -> None:
    """Find the database closed."""
    await receive()
    await send({"type": "http.response.start", "status": 500})
    await send({"type": "http.response.body"})
    raise OSError("closed")


@pytest.mark.parametrize(("app", "scope"), [(hold, SOCKET), (hold, REQUEST), (fail_late, REQUEST)])
async def test_of_one_that_was_not_answered_it_is_said_so(app, scope) -> None:
    requests, asker = LocalRequests(), Asker()
    serving = asyncio.create_task(requests.serve(app, scope, asker.says.get, asker.send))
    ending = asyncio.create_task(until_begun(requests, serving))
    asker.says.put_nowait({"type": "http.request"})
    assert not (await asyncio.wait_for(asyncio.gather(serving, ending), PATIENCE_S))[0]
    assert asker.told == []


async def until_begun(requests, serving) -> None:
    # The request begins before this one has its turn.
    assert not serving.done()
    await requests.end_all()
