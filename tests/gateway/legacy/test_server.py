"""Clients of the founding observatory: their WebSocket messages over TLS, and the answers."""

from __future__ import annotations

import asyncio
import base64
import contextlib
import json
import ssl
import sys
from pathlib import Path
from typing import TYPE_CHECKING, Any

import pytest
from hypothesis import given, strategies as st
from patience import PATIENCE_S
from websockets.asyncio.client import connect
from websockets.exceptions import ConnectionClosed, InvalidStatus

from talaia.clock import SystemClock
from talaia.gateway.app import Gateway
from talaia.gateway.command_line import parse_arguments
from talaia.gateway.legacy.messages import LegacyRequestError, read_message
from talaia.gateway.settings import GatewaySettings, HubAddress, LegacySettings
from talaia.model.discovery.command_file import site_of

if TYPE_CHECKING:
    from collections.abc import AsyncIterator

RECORDED = Path(__file__).parents[2] / "wire" / "recorded"
COMMANDS = (RECORDED / "observatory_commands.json").read_text()
SITE = site_of(COMMANDS, "observatory")
# Clients that answer as those of the recorded session did.
CLIENTS = """\
import pathlib, sys
state = pathlib.Path({folder!r}, "state")
with pathlib.Path({folder!r}, "log").open("a") as file:
    file.write(" ".join(sys.argv[1:]) + chr(10))
program, _, action = sys.argv[1:4]
if action == "status":
    print("", state.read_text())
elif action in ("open", "close"):
    state.write_text("opened" if action == "open" else "closed")
elif action == "info":
    print(" ['Clouds', 'broken clouds', '18.74', '1016', '77', '2.57', '40']")
elif action == "getcoord":
    print(" Alt:10.000000 Az:10.000000")
elif action != "goto":
    print(" Invalid dome action")
"""


class House:
    """A gateway with its door open, and how one gets in."""

    def __init__(self, gateway: Gateway, folder: Path) -> None:  # noqa: D107
        assert gateway.legacy.server is not None
        self.door, self.folder = gateway.legacy.server, folder
        self.token = (folder / "data" / "classic.token").read_text().strip()
        self.context = ssl.create_default_context(cafile=folder / "data" / "classic.crt")

    def url(self, scheme: str = "wss", tail: str = "") -> str:
        return f"{scheme}://localhost:{self.door.port}/{tail}"

    def come_in(self, **headers: str) -> connect:
        given = headers or {"Authorization": f"Bearer {self.token}"}
        return connect(self.url(), ssl=self.context, additional_headers=given, proxy=None)

    def did(self, words: str) -> list[str]:
        log = self.folder / "log"
        lines = log.read_text().splitlines() if log.exists() else []
        return [line for line in lines if words in line]


@pytest.fixture
async def house(tmp_path: Path) -> AsyncIterator[House]:
    (tmp_path / "state").write_text("closed")
    (tmp_path / "clients.py").write_text(CLIENTS.format(folder=str(tmp_path)))
    text = COMMANDS.replace("ros2 run", f"{sys.executable} -S {tmp_path / 'clients.py'}")
    hub = HubAddress.from_text("ws://127.0.0.1:9", allow_plain=True)
    settings = GatewaySettings(
        hub=hub, key="k", data=tmp_path / "data", door=LegacySettings(port=0)
    )
    gateway = Gateway(site=site_of(text, "observatory"), settings=settings, clock=SystemClock())
    ended = asyncio.Event()
    task = asyncio.ensure_future(gateway.run(ended))
    try:
        assert gateway.legacy.server is not None
        async with asyncio.timeout(PATIENCE_S):
            while not gateway.legacy.server.port:  # noqa: ASYNC110 - it says so in the log only
                await asyncio.sleep(0.01)
        yield House(gateway, tmp_path)
    finally:
        ended.set()
        await asyncio.wait_for(task, PATIENCE_S)


async def answer(socket: Any, message: object) -> dict[str, Any]:
    await socket.send(message if isinstance(message, str) else json.dumps(message))
    return json.loads(await socket.recv())


async def until(socket: Any, word: str) -> dict[str, Any]:
    """Ask for the status, as the founding client does, until all was read and the dome is so."""
    async with asyncio.timeout(PATIENCE_S):
        while True:
            said = await answer(socket, {"msg": "status"})
            fields = [each for device in said["status"].values() for each in device.values()]
            if "unknown" not in fields and said["status"]["dome"]["status"] == word:
                return said
            await asyncio.sleep(0.1)


async def test_a_recorded_session_plays_against_the_gateway(house: House) -> None:
    session = json.loads((RECORDED / "observatory_session.json").read_text())
    async with house.come_in() as socket:
        said: dict[str, Any] = {}
        for line in session:
            if "server" in line:
                assert said == line["server"]
            elif line["client"] == {"msg": "status"}:
                said = await until(socket, line.get("until", "closed"))
            else:
                said = await answer(socket, line["client"])
                assert set(said) == {"status", "action"}
    assert house.did("dome_servcli client open") == ["dome_servcli client open"]
    assert house.did("goto") == ["telescope_servcli client goto 5.59 -5.39"]
    assert house.did("dome_servcli client close") == ["dome_servcli client close"]


@pytest.mark.parametrize(
    "headers",
    [
        {"X-Nothing": "x"},
        {"Authorization": "Bearer wrong"},
        {"Authorization": "Basic " + base64.b64encode(b"admin:admin").decode()},
        {"Authorization": "Basic not base64!"},
        {"Authorization": "Bearer "},
    ],
)
async def test_nobody_comes_in_without_the_token(house: House, headers: dict[str, str]) -> None:
    with pytest.raises(InvalidStatus) as caught:
        async with house.come_in(**headers):
            pass
    assert caught.value.response.status_code == 401


async def test_the_token_may_be_a_password_or_stand_in_the_address(house: House) -> None:
    basic = base64.b64encode(f"anybody:{house.token}".encode()).decode()
    async with house.come_in(Authorization=f"Basic {basic}") as socket:
        assert "status" in await answer(socket, {"msg": "status"})
    address = house.url(tail=f"?token={house.token}")
    async with connect(address, ssl=house.context, proxy=None) as socket:
        assert "status" in await answer(socket, {"msg": "status"})


async def test_plain_text_is_not_spoken(house: House) -> None:
    reader, writer = await asyncio.open_connection("127.0.0.1", house.door.port)
    ask = f"GET /?token={house.token} HTTP/1.1\r\nHost: localhost\r\nUpgrade: websocket\r\n\r\n"
    writer.write(ask.encode())
    said = b""
    with contextlib.suppress(ConnectionError):
        said = await asyncio.wait_for(reader.read(), PATIENCE_S)
    assert b"HTTP" not in said
    writer.close()
    with contextlib.suppress(ConnectionError):
        await writer.wait_closed()


async def test_what_the_door_keeps_is_for_its_owner_only(house: House) -> None:
    for name in ("classic.token", "classic-tls.key"):
        assert (house.folder / "data" / name).stat().st_mode & 0o077 == 0


async def test_bad_asks_are_told_and_nothing_moves(house: House) -> None:
    async with house.come_in() as socket:
        for message, said in (
            ("{", "is not JSON"),
            ("[" * 5000, "is not JSON"),
            ({"msg": "open"}, "expected"),
            ({"msg": {"action": {"roof": {"action": {"open": " "}}}}}, "there is no device 'roof'"),
            ({"msg": {"action": {"dome": {"action": {"burn": " "}}}}}, "no action 'burn'"),
            ({"msg": {"action": {"dome": {"action": {"open": [1]}}}}}, "parameters as one text"),
            ({"msg": {"action": {"telescope": {"action": {"goto": "x 1"}}}}}, "expected a number"),
            ({"msg": {"action": {"telescope": {"action": {"goto": "1 2 3"}}}}}, "3 parameters"),
        ):
            told = await answer(socket, message)
            assert said in told["error"]
            assert "status" in told
        far = {"msg": {"action": {"telescope": {"action": {"goto": "25 0"}}}}}
        told = await answer(socket, far)
        assert told["action"]["telescope"]["goto"] == "refused: ra: 25.0 is above 24.0"
    for words in ("open", "close", "goto"):
        assert house.did(f"client {words}") == []


async def test_a_message_that_is_too_long_or_too_many_of_them_end_the_talk(house: House) -> None:
    async with house.come_in() as socket:
        await socket.send("x" * 20_000)
        with pytest.raises(ConnectionClosed):
            await socket.recv()
    async with house.come_in() as socket:
        with pytest.raises(ConnectionClosed):
            await chatter(socket)


async def chatter(socket: Any) -> None:
    for _ in range(100):
        await answer(socket, {"msg": "status"})


anything = st.recursive(
    st.none() | st.booleans() | st.integers() | st.floats() | st.text(max_size=8),
    lambda inner: (
        st.lists(inner, max_size=2)
        | st.dictionaries(
            st.sampled_from(["msg", "action", "dome", "telescope", "open", "goto", "status"]), inner
        )
    ),
    max_leaves=10,
)


@given(anything)
def test_no_message_breaks_the_reader(document: object) -> None:
    with contextlib.suppress(LegacyRequestError):
        for each in read_message(json.dumps(document), SITE):
            assert each.command in SITE.devices[each.device].commands


@pytest.mark.parametrize("port", ["-1", "65536", "x", "1e3"])
def test_a_port_that_is_none_is_refused_at_the_start(
    port: str, capsys: pytest.CaptureFixture[str]
) -> None:
    with pytest.raises(SystemExit):
        parse_arguments(["site.yaml", "--key-file", "k", "--classic-port", port])
    assert "is not a port from 0 to 65535" in capsys.readouterr().err
