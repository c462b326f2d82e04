"""A notifier that an extension brings, against a real server, in the process that sends."""

from __future__ import annotations

import asyncio
import ipaddress
import json
from typing import TYPE_CHECKING

import pytest

from talaia.hub.notify.message import AlarmMessage
from talaia.hub.notify.senders import DeliveryResult, Outcome, Sender
from talaia.hub.store.alarms.notification_channels import Way, WayKind

from .broken_packages import write_package

if TYPE_CHECKING:
    from collections.abc import AsyncIterator, Mapping
    from pathlib import Path

LOOPBACK = [ipaddress.ip_network("127.0.0.1/32")]
SAID = AlarmMessage(
    "the-key", "AGV: Battery low", "Voltage is 10 V\r\nQUIT :no\x01", "critical", ("agv",)
)
NOTIFIER = """
from talaia.extend.notifier import ExtensionKeys, NotDelivered, NotifierExtension
def send(keys, message):
    {send}
extension = NotifierExtension(api=1, summary="test", keys=ExtensionKeys, send=send)
"""


class IrcServer:
    """As much of an IRC server as a client that writes one message meets."""

    def __init__(self) -> None:
        """Let everybody in."""
        self.lines: list[str] = []
        self.refuse = ""
        self.port = 0

    async def meet(self, reader: asyncio.StreamReader, writer: asyncio.StreamWriter) -> None:
        while raw := await reader.readline():
            line = raw.decode().rstrip("\r\n")
            self.lines.append(line)
            word = line.split()[0]
            if word == "NICK":
                writer.write(b"PING :are-you-there\r\n")
            elif word == "PONG":
                writer.write(self.refuse.encode() or b":irc.test 001 talaia :Welcome\r\n")
            elif word == "JOIN":
                writer.write(b":irc.test 366 talaia #observatory :End of /NAMES list.\r\n")
            elif word == "QUIT":
                writer.write(b"ERROR :Closing link\r\n")
                break
        writer.close()


@pytest.fixture
async def server(beside: Path) -> AsyncIterator[IrcServer]:
    irc = IrcServer()
    listening = await asyncio.start_server(irc.meet, "127.0.0.1", 0)
    irc.port = listening.sockets[0].getsockname()[1]
    yield irc
    listening.close()


async def send(name: str, keys: Mapping[str, str], networks=LOOPBACK) -> DeliveryResult:
    way = Way(1, "way", WayKind.EXTENSION, {"extension": name}, ("keys",))
    return await Sender(networks).send_message(
        way, {"keys": json.dumps(keys)}, target="", message=SAID
    )


def keys_for(server: IrcServer, **more: str) -> dict[str, str]:
    return {
        "host": "127.0.0.1", "port": str(server.port), "channel": "#observatory", "tls": "false",
        **more,
    }  # fmt: skip


async def test_a_message_arrives_in_the_channel_and_is_no_command_there(server: IrcServer) -> None:
    assert await send("irc", keys_for(server)) == DeliveryResult(Outcome.SENT)
    assert server.lines == [
        "NICK talaia",
        "USER talaia 0 * :Talaia",
        "PONG :are-you-there",
        "JOIN #observatory",
        "PRIVMSG #observatory :AGV: Battery low",
        "PRIVMSG #observatory :Voltage is 10 V",
        "PRIVMSG #observatory :QUIT :no ",
        "QUIT :done",
    ]


async def test_what_the_server_answers_is_told(server: IrcServer) -> None:
    server.refuse = ":irc.test 433 * talaia :Nickname is already in use\r\n"
    went = await send("irc", keys_for(server))
    assert went.outcome is Outcome.AGAIN
    assert "Nickname is already in use" in went.problem


async def test_an_extension_reaches_no_address_that_messages_may_not_go_to(
    server: IrcServer,
) -> None:
    for host in ("127.0.0.1", "localhost"):
        went = await send("irc", {**keys_for(server), "host": host}, networks=())
        assert went.outcome is not Outcome.SENT
        assert "no public address" in went.problem
    assert server.lines == []


async def test_keys_that_do_not_fit_are_told_and_nothing_is_sent(server: IrcServer) -> None:
    went = await send("irc", keys_for(server, channel="#a b"))
    assert went.outcome is Outcome.FAILED
    assert "expected a name such as #observatory" in went.problem
    assert server.lines == []


@pytest.mark.parametrize(
    ("code", "outcome", "problem"),
    [
        ("raise RuntimeError('boom')", Outcome.UNSURE, "failed: RuntimeError: boom"),
        ("raise NotDelivered('busy')", Outcome.AGAIN, "busy"),
        ("raise NotDelivered('no such room', again=False)", Outcome.FAILED, "no such room"),
        ("import os; os._exit(4)", Outcome.UNSURE, "ended badly"),
        ("print('{\"outcome\": \"sent\"}'); raise NotDelivered('x')", Outcome.AGAIN, "x"),
        (
            "import socket; socket.socket().connect(('127.0.0.2', 9))",
            Outcome.FAILED,
            "127.0.0.2 is no public address",
        ),
        (
            "import socket; socket.socket().connect_ex(('127.0.0.2', 9))",
            Outcome.FAILED,
            "127.0.0.2 is no public address",
        ),
    ],
)
async def test_a_notifier_that_fails_is_told_and_harms_nobody(
    code: str, outcome: Outcome, problem: str, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    write_package(tmp_path, "n", "talaia.notifiers", "n", NOTIFIER.format(send=code))
    monkeypatch.setenv("PYTHONPATH", str(tmp_path))
    went = await send("n", {})
    assert went.outcome is outcome
    assert problem in went.problem


async def test_one_that_is_not_installed_any_more_is_told(beside: Path) -> None:
    went = await send("gone", {})
    assert went == DeliveryResult(
        Outcome.FAILED, "the extension 'gone' is not installed at this hub"
    )
