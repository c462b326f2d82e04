"""Every way out against a real peer: what arrives there, and what is said when it does not."""

from __future__ import annotations

import base64
import ipaddress
import json
import os

import http_ece
import pytest
from cryptography.hazmat.primitives.asymmetric import ec
from cryptography.hazmat.primitives.serialization import Encoding, PublicFormat

from talaia.hub.notify.message import AlarmMessage, AlarmPicture
from talaia.hub.notify.senders import Outcome, Sender
from talaia.hub.store.alarms.notification_channels import PushBrowser, Way, WayKind

from .peers import served

LOOPBACK = [ipaddress.ip_network("127.0.0.1/32")]
SAID = AlarmMessage("the-key", "AGV: Battery low", "Voltage is 10 V", "critical", ("agv",))


@pytest.fixture
async def peer():
    peer, server = await served("127.0.0.1")
    yield peer
    server.close()


async def send(kind: WayKind, secrets: dict[str, str], **more):
    way = Way(1, "way", kind, more.pop("settings", {}), ())
    return await Sender(more.pop("networks", LOOPBACK)).send_message(
        way, secrets, target="", message=SAID, **more
    )


async def test_webhook_gets_the_message_with_its_key(peer) -> None:
    secrets = {"url": f"http://127.0.0.1:{peer.port}/hook?a=1", "token": "secret"}
    assert (await send(WayKind.WEBHOOK, secrets)).outcome is Outcome.SENT
    line, fields, body = peer.asked[0]
    assert line == "POST /hook?a=1 HTTP/1.1"
    assert (fields["idempotency-key"], fields["authorization"]) == ("the-key", "Bearer secret")
    expected = {**SAID._asdict(), "sites": ["agv"]}
    # A path says nothing to who is not at the hub.
    del expected["open"]
    # Nor is there a picture of what no camera saw.
    del expected["picture"], expected["picture_path"]
    assert json.loads(body) == expected


async def test_webhook_gets_the_picture_of_what_was_seen(peer) -> None:
    way = Way(1, "way", WayKind.WEBHOOK, {}, ())
    shown = SAID.with_picture(AlarmPicture(b"jpeg", "/api/sites/agv/sightings/7/picture"))
    secrets = {"url": f"http://127.0.0.1:{peer.port}/hook"}
    went = await Sender(LOOPBACK).send_message(way, secrets, target="", message=shown)
    assert went.outcome is Outcome.SENT
    document = json.loads(peer.asked[0][2])
    assert base64.b64decode(document["picture"]) == b"jpeg"
    # Only who is signed in at the hub gets it there.
    assert "picture_path" not in document


@pytest.mark.parametrize(
    ("answer", "outcome"),
    [
        ("503 Busy", Outcome.AGAIN),
        ("429 Slower", Outcome.AGAIN),
        ("404 Nothing here", Outcome.FAILED),
        # It could lead anywhere.
        ("302 Found", Outcome.FAILED),
    ],
)
async def test_what_a_webhook_answers_is_told(peer, answer, outcome) -> None:
    peer.answer, peer.headers = answer, "Location: http://127.0.0.2/\r\n"
    went = await send(WayKind.WEBHOOK, {"url": f"http://127.0.0.1:{peer.port}/"})
    assert went.outcome is outcome
    assert answer in went.problem


async def test_message_that_may_have_arrived_is_told_from_one_that_has_not(peer) -> None:
    peer.hangs_up = True
    url = f"http://127.0.0.1:{peer.port}/"
    assert (await send(WayKind.WEBHOOK, {"url": url})).outcome is Outcome.UNSURE
    # Nobody listens there.
    assert (await send(WayKind.WEBHOOK, {"url": "http://127.0.0.1:9/"})).outcome is Outcome.AGAIN


@pytest.mark.parametrize(
    "host", ["127.0.0.1", "0x7f000001", "2130706433", "localhost", "[::ffff:127.0.0.1]"]
)
async def test_whatever_its_spelling_an_inner_address_is_not_reached(peer, host) -> None:
    url = f"http://{host}:{peer.port}/"
    went = await send(WayKind.WEBHOOK, {"url": url}, networks=[])
    assert went.outcome is Outcome.FAILED
    assert "no public address" in went.problem
    assert peer.asked == []


@pytest.mark.parametrize("url", ["file:///etc/passwd", "gopher://127.0.0.1/", "exec://ls"])
async def test_other_schemes_are_refused(url) -> None:
    assert (await send(WayKind.WEBHOOK, {"url": url})).outcome is Outcome.FAILED
    assert (await send(WayKind.CHAT, {"url": url})).outcome is Outcome.FAILED


@pytest.mark.parametrize("host", ["127.0.0.1:80800", "127.0.0.1:http", "127.0.0.1:-1", "[::1"])
async def test_webhook_whose_address_cannot_be_read_is_not_tried_again(host) -> None:
    went = await send(WayKind.WEBHOOK, {"url": f"http://{host}/"})
    assert went.outcome is Outcome.FAILED
    assert "the address is not valid" in went.problem


async def test_ntfy_gets_the_message_by_apprise(peer) -> None:
    went = await send(WayKind.CHAT, {"url": f"ntfy://127.0.0.1:{peer.port}/topic"})
    assert went.outcome is Outcome.SENT, went
    assert "Battery low" in json.dumps([str(each) for each in peer.asked])
    peer.answer = "403 Forbidden"
    refused = await send(WayKind.CHAT, {"url": f"ntfy://127.0.0.1:{peer.port}/topic"})
    assert refused.outcome is Outcome.AGAIN
    assert "403" in refused.problem


async def test_redirect_of_a_chat_leads_nowhere_inside(peer) -> None:
    inside, server = await served("127.0.0.2")
    peer.answer = "307 Elsewhere"
    peer.headers = f"Location: http://127.0.0.2:{inside.port}/\r\n"
    went = await send(WayKind.CHAT, {"url": f"ntfy://127.0.0.1:{peer.port}/topic"})
    server.close()
    assert went.outcome is not Outcome.SENT
    assert inside.asked == []


def b64(raw: bytes) -> str:
    return base64.urlsafe_b64encode(raw).decode().rstrip("=")


def point(key: ec.EllipticCurvePrivateKey) -> str:
    return b64(key.public_key().public_bytes(Encoding.X962, PublicFormat.UncompressedPoint))


async def test_push_service_gets_what_only_the_browser_can_read(peer, monkeypatch) -> None:
    theirs, ours = ec.generate_private_key(ec.SECP256R1()), ec.generate_private_key(ec.SECP256R1())
    secret = os.urandom(16)
    subscription = {
        "endpoint": f"http://127.0.0.1:{peer.port}/push",
        "p256dh": point(theirs),
        "auth": b64(secret),
    }
    keys = {"private_key": b64(ours.private_numbers().private_value.to_bytes(32, "big"))}
    browser = PushBrowser(7, "Firefox", 0, subscription)

    async def push():
        settings = {"subject": "mailto:a@example.org"}
        return await send(WayKind.PUSH, keys, settings=settings, browsers=[browser])

    # A browser says where to, so an inner address is not reached in any case.
    assert "no public address" in (await push()).problem
    assert peer.asked == []
    monkeypatch.setattr("talaia.hub.notify.senders._NETWORKS_OF_PUSH", ("127.0.0.1/32",))
    peer.answer = "201 Created"
    assert (await push()).outcome is Outcome.SENT
    _, fields, body = peer.asked[0]
    assert fields["authorization"].startswith("vapid t=")
    assert b"Battery" not in body
    read = http_ece.decrypt(body, private_key=theirs, auth_secret=secret, version="aes128gcm")
    assert json.loads(read)["title"] == "AGV: Battery low"
    peer.answer = "410 Gone"
    went = await push()
    assert (went.outcome, went.gone) == (Outcome.FAILED, (7,))
