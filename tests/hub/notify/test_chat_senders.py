"""ntfy, Matrix and Telegram by the real apprise, against servers on loopback that look closely."""

# ruff: noqa: D107

from __future__ import annotations

import ipaddress
import json
import os
import re
from urllib.parse import unquote

import pytest

from talaia.clock import SECOND, HandClock
from talaia.hub.auth.secret_box import Seal
from talaia.hub.notify.delivery_worker import DeliveryWorker
from talaia.hub.notify.message import AlarmMessage
from talaia.hub.notify.senders import Outcome, Sender
from talaia.hub.store.alarms.notification_channels import NotifyStore, Way, WayKind
from talaia.hub.store.alarms.notification_outbox import NotificationOutbox
from talaia.hub.store.database import Database

from .peers import Peer, certified, served
from .raised_alarm import raise_alarm

SAID = AlarmMessage("the-key", "AGV: Battery low", "Voltage is 10 V", "critical", ("agv",))
LOOPBACK = [ipaddress.ip_network("127.0.0.1/32")]


async def chat(url: str, networks=LOOPBACK):
    return await Sender(networks).send_message(
        Way(1, "way", WayKind.CHAT, {}, ()), {"url": url}, target="", message=SAID
    )


async def test_ntfy_gets_title_text_and_urgency() -> None:
    peer, server = await served("127.0.0.1")
    went = await chat(f"ntfy://ada:secret@127.0.0.1:{peer.port}/alarms?priority=high")
    server.close()
    assert went.outcome is Outcome.SENT, went
    [(line, fields, body)] = peer.asked
    assert line.startswith("POST / ")
    assert fields["authorization"].startswith("Basic ")
    said = json.loads(body)
    assert said == {"topic": "alarms", "title": SAID.title, "message": SAID.body}
    assert fields["x-priority"] == "high"


class Homeserver(Peer):
    """The part of a Matrix homeserver (client-server API v3) that a message needs."""

    TOKEN = "syt_of_the_hub"  # noqa: S105 - the test's own

    def __init__(self) -> None:
        super().__init__()
        self.messages = {}
        self.hangs_up_at = "nothing"

    def answered(self, line: str, fields: dict[str, str], body: bytes) -> tuple[str, str]:
        method, path, _ = line.split(" ")
        path = unquote(path.partition("?")[0])
        said = json.loads(body or b"{}")
        self.hangs_up = self.hangs_up_at in path
        if path.endswith("/login"):
            if said.get("password") != "right":
                return "403 Forbidden", json.dumps({"errcode": "M_FORBIDDEN", "error": "no"})
            return "200 OK", json.dumps(
                {"access_token": self.TOKEN, "user_id": "@hub:house", "device_id": "ONE"}
            )
        if fields.get("authorization") != f"Bearer {self.TOKEN}":
            return "401 Unauthorized", json.dumps({"errcode": "M_UNKNOWN_TOKEN", "error": "who?"})
        if method == "POST" and "/join/" in path:
            if not path.endswith("/join/#alarms:house"):
                return "404 Not Found", json.dumps({"errcode": "M_NOT_FOUND", "error": "no room"})
            return "200 OK", json.dumps({"room_id": "!room:house"})
        sent = re.search(r"/rooms/!room:house/send/m\.room\.message/(.+)$", path)
        if method == "PUT" and sent:
            # By its number a homeserver knows a message that comes twice.
            self.messages[sent[1]] = said
            return "200 OK", json.dumps({"event_id": f"$event{len(self.messages)}"})
        return "200 OK", "{}"


@pytest.fixture
async def homeserver():
    peer, server = await served("127.0.0.1", Homeserver())
    yield peer
    server.close()


def room(homeserver: Homeserver, name: str = "#alarms:house", password: str = "right") -> str:  # noqa: S107
    return f"matrix://hub:{password}@127.0.0.1:{homeserver.port}/{name}"


async def test_matrix_room_gets_one_message_of_the_signed_in_hub(homeserver) -> None:
    went = await chat(room(homeserver))
    assert went.outcome is Outcome.SENT, went
    [said] = homeserver.messages.values()
    assert said["msgtype"] == "m.text"
    assert SAID.title in said["body"]
    assert SAID.body in said["body"]


@pytest.mark.parametrize(
    ("name", "password", "code"),
    [("#alarms:house", "wrong", "403"), ("#other:house", "right", "404")],
)
async def test_matrix_that_takes_no_message_is_tried_again(
    homeserver, name, password, code
) -> None:
    went = await chat(room(homeserver, name, password))
    assert went.outcome is Outcome.AGAIN
    assert f"error={code}" in went.problem
    assert homeserver.messages == {}


async def test_only_a_matrix_message_that_had_left_may_have_arrived(homeserver) -> None:
    homeserver.hangs_up_at = "/login"
    assert (await chat(room(homeserver))).outcome is Outcome.AGAIN
    homeserver.hangs_up_at = "/send/"
    assert (await chat(room(homeserver))).outcome is Outcome.UNSURE


async def test_address_of_several_rooms_is_refused_for_one_could_get_it_twice(homeserver) -> None:
    went = await chat(room(homeserver) + "/#second:house")
    assert (went.outcome, went.problem) == (
        Outcome.FAILED,
        "it names 2 targets; make a way for each of them",
    )
    assert homeserver.asked == []


# apprise speaks to https://api.telegram.org whatever the address says: in the process that sends,
# that name leads to loopback here, at the port of the test, and its certificate is trusted.
ELSEWHERE = """
import os, socket
_resolve = socket.getaddrinfo
def _here(host, port, *args, **kwargs):
    if host == "api.telegram.org":
        return _resolve("127.0.0.1", {port}, *args, **kwargs)
    return _resolve(host, port, *args, **kwargs)
socket.getaddrinfo = _here
"""


@pytest.fixture
def telegram_is_at(tmp_path, monkeypatch):
    """Let the sending process find Telegram at a port of this machine."""

    def at(port: int) -> None:
        (tmp_path / "sitecustomize.py").write_text(ELSEWHERE.replace("{port}", str(port)))
        path = [str(tmp_path), os.environ.get("PYTHONPATH", "")]
        monkeypatch.setenv("PYTHONPATH", os.pathsep.join(filter(None, path)))

    return at


TELEGRAM = "tgram://123456789:abcdefg_hijklmnop/42"


class Telegram(Peer):
    """Telegram's Bot API, as far as a message needs it."""

    def answered(self, line: str, _fields: dict[str, str], body: bytes) -> tuple[str, str]:
        said = json.loads(body or b"{}")
        right = line.startswith("POST /bot123456789:abcdefg_hijklmnop/sendMessage ")
        if right and said.get("chat_id") == 42:
            return "200 OK", json.dumps({"ok": True, "result": {"message_id": 1}})
        return "400 Bad Request", json.dumps({"ok": False, "description": "chat not found"})


async def test_telegram_gets_the_message_at_its_own_address(
    tmp_path, monkeypatch, telegram_is_at
) -> None:
    context, trusted = certified(tmp_path, "api.telegram.org")
    monkeypatch.setenv("REQUESTS_CA_BUNDLE", str(trusted))
    peer, server = await served("127.0.0.1", Telegram(), context)
    telegram_is_at(peer.port)
    went = await chat(TELEGRAM)
    refused = await chat(TELEGRAM.replace("/42", "/43"))
    server.close()
    assert went.outcome is Outcome.SENT, went
    said = json.loads(peer.asked[0][2])
    assert SAID.title in said["text"]
    assert SAID.body in said["text"]
    assert (refused.outcome, "error=400" in refused.problem) == (Outcome.AGAIN, True)


async def test_telegram_that_cannot_be_reached_is_tried_again(telegram_is_at) -> None:
    # Nobody listens there.
    telegram_is_at(9)
    went = await chat(TELEGRAM)
    assert went.outcome is Outcome.AGAIN
    assert "onnection" in went.problem


async def test_alarm_says_that_telegram_is_not_reached_until_it_is_and_then_it_came_once(
    tmp_path, monkeypatch, telegram_is_at, caplog
) -> None:
    database = Database(f"sqlite:///{tmp_path}/talaia.db")
    await database.migrate()
    clock = HandClock()
    store, outbox = NotifyStore(database, lambda: Seal(bytes(32))), NotificationOutbox(database)
    await raise_alarm(database, clock, store, WayKind.CHAT, secrets={"url": TELEGRAM})

    async def told() -> None: ...

    delivering = DeliveryWorker(
        notices=outbox, store=store, sender=Sender(LOOPBACK), clock=clock, told=told
    )
    telegram_is_at(9)
    for wait_s in (10, 60, 300):
        await delivering.deliver_due()
        assert "onnection" in (await outbox.failed_alarms())["agv", "low"]
        assert await outbox.next_due_us() == clock.wall_ns() // 1000 + wait_s * 1_000_000
        clock.advance(wait_s * SECOND)
    # The loss is in the log once, whatever was tried since.
    assert caplog.text.count("was not delivered") == 1

    context, trusted = certified(tmp_path, "api.telegram.org")
    monkeypatch.setenv("REQUESTS_CA_BUNDLE", str(trusted))
    peer, server = await served("127.0.0.1", Telegram(), context)
    telegram_is_at(peer.port)
    await delivering.deliver_due()
    clock.advance(86_400 * SECOND)
    await delivering.deliver_due()
    server.close()
    assert len(peer.asked) == 1
    assert await outbox.failed_alarms() == {}
    await database.close()
