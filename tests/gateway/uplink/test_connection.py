"""Uplink: lanes, waits, beats, catching up, trust, and keys that are refused."""

from __future__ import annotations

import asyncio
import contextlib
import datetime
import hashlib
import random
import ssl
from typing import TYPE_CHECKING

import pytest
from cryptography import x509
from cryptography.hazmat.primitives import hashes, serialization
from cryptography.hazmat.primitives.asymmetric import ec
from fake_hub import fake_hub
from gateway_bench import addresses_of, running
from hypothesis import given, strategies as st

from talaia.clock import SECOND
from talaia.gateway.errors import LinkLost, SettingsError
from talaia.gateway.settings import HubAddress
from talaia.gateway.spool.journal import SegmentHead, StoredRecord
from talaia.gateway.spool.segment import SampleRecord
from talaia.gateway.uplink import dialling
from talaia.gateway.uplink.backoff import Backoff
from talaia.gateway.uplink.catchup import as_old
from talaia.gateway.uplink.dialling import OutageLog
from talaia.gateway.uplink.heartbeat import HeartbeatMonitor, reply_to
from talaia.gateway.uplink.send_lanes import SendLanes
from talaia.gateway.uplink.tls import HubTrust
from talaia.wire.frames import LINK_FROM_GATEWAY, ControlTick, Event, SampleBatch, StopState

if TYPE_CHECKING:
    from pathlib import Path

QUIET = """
talaia: 1
site: quiet
name: Quiet
devices:
  hut: {name: Hut}
"""


def lanes() -> SendLanes:
    one = SendLanes(lambda: None)
    one.link_up()
    return one


def drained(one: SendLanes) -> list[object]:
    found = []
    while (data := one.next()) is not None:
        found.append(data if data.startswith(b"!") else LINK_FROM_GATEWAY.decode(data))
    return found


def test_urgent_frames_go_first() -> None:
    one = lanes()
    one.backfill(b"!old")
    one.live(b"!live", 0, 1)
    one.send(Event(kind="k"))
    one.send(ControlTick(tick=1))
    assert drained(one) == [ControlTick(tick=1), Event(kind="k"), b"!live", b"!old"]


def test_live_samples_go_at_once_where_the_socket_takes_them_and_nothing_as_urgent_waits() -> None:
    one, sent, room = SendLanes(lambda: None), [], 0

    def write(data: bytes) -> bool:
        if len(sent) < room:
            sent.append(data)
        return data in sent

    one.link_up(write)
    room = 1
    one.live(b"!first", 0, 1)
    # The socket is full.
    one.live(b"!second", 1, 2)
    room = 9
    # Behind the one that waits.
    one.live(b"!third", 2, 3)
    one.backfill(b"!old")
    assert sent == [b"!first"]
    assert drained(one) == [b"!second", b"!third", b"!old"]
    # What is old goes by its lane, in which it can be overtaken.
    one.backfill(b"!older")
    one.live(b"!fourth", 3, 4)
    assert sent[1:] == [b"!fourth"]
    # What tells of a state is said before it and goes behind it, and samples behind both.
    one.send(Event(kind="drive_ended"))
    one.send(ControlTick(tick=1))
    one.live(b"!fifth", 4, 5)
    assert sent[2:] == []
    told = [ControlTick(tick=1), Event(kind="drive_ended"), b"!fifth", b"!older"]
    assert drained(one) == told
    one.link_lost()
    one.live(b"!sixth", 5, 6)
    assert sent[2:] == []


def test_results_and_events_outlive_a_lost_link_and_nothing_else_does() -> None:
    one = lanes()
    one.send(StopState(device="base", latched=False))
    one.send(Event(kind="k"))
    one.live(b"!live", 0, 1)
    one.link_lost()
    one.send(ControlTick(tick=1))
    one.send(Event(kind="while away"))
    one.link_up()
    assert drained(one) == [Event(kind="k"), Event(kind="while away")]


def test_live_lane_that_overflows_is_emptied_and_says_what_is_owed() -> None:
    one = lanes()
    big = b"!" * (one.MAX_LIVE // 4)
    for number in range(6):
        one.live(big, number * 10, number * 10 + 10)
    assert one.overflowed == (0, 40)
    assert drained(one) == [big, big]


def test_lanes_are_bounded() -> None:
    one = lanes()
    for number in range(3 * one.MAX_COMMANDS):
        one.send(Event(kind=f"k{number}"))
        one.send(ControlTick(tick=number))
    assert len(drained(one)) == one.MAX_COMMANDS + one.MAX_CONTROL
    assert one.dropped_events == 2 * one.MAX_COMMANDS


@given(st.lists(st.floats(0, 9.9), min_size=1, max_size=40), st.floats(0, 0.999))
def test_waits_grow_to_a_bound_and_a_mere_handshake_does_not_reset_them(
    lasted: list[float], luck: float
) -> None:
    backoff = Backoff(lambda: luck)
    waits = [backoff.after(each) for each in lasted]
    assert waits == sorted(waits)
    assert 0.25 <= waits[0] <= 0.5
    assert waits[-1] <= Backoff.QUICK_S
    assert backoff.after(Backoff.STABLE_S) <= 0.5


@given(st.lists(st.floats(0, 9.9), max_size=40), st.floats(0, 0.999))
def test_site_whose_link_flapped_for_long_dials_again_within_two_seconds(
    lasted: list[float], luck: float
) -> None:
    """What it had been sent away for before is over, too."""
    backoff = Backoff(lambda: luck)
    for each in lasted:
        backoff.after(each, sent_away_s=0.0)
    assert backoff.after(0.0) <= 2.0


@given(st.floats(0.1, 20), st.floats(0, 0.999), st.integers(0, 10))
def test_who_is_sent_away_comes_back_about_when_the_hub_said(
    after_s: float, luck: float, before: int
) -> None:
    backoff = Backoff(lambda: luck)
    for _ in range(before):
        backoff.after(0.0)
    assert 0.5 * after_s <= backoff.after(0.0, sent_away_s=after_s) <= 1.5 * after_s


def test_who_is_sent_away_without_a_time_waits_longer_each_time() -> None:
    backoff = Backoff(lambda: 1.0)
    waits = [backoff.after(0.0, sent_away_s=0.0) for _ in range(9)]
    assert waits == [0.5, 1.0, 2.0, 4.0, 8.0, 16.0, 30.0, 30.0, 30.0]


def test_five_hundred_that_lose_the_hub_at_once_do_not_come_back_at_once() -> None:
    """Each tries until the hub is there again; of them a fifth at most comes in any 0.2 s."""
    chance = random.Random(1)  # noqa: S311 - not a secret
    came = []
    for _ in range(500):
        backoff, at = Backoff(chance.random), 0.0
        while at < 10.0:
            at += backoff.after(0.0)
        came.append(at)
    assert max(came) < 12.0
    for tenth in range(10):
        begin = 10.0 + tenth * 0.2
        assert sum(begin <= each < begin + 0.2 for each in came) < 100


def test_refused_key_waits_long() -> None:
    assert Backoff(lambda: 0.0).after(0, refused=True) == Backoff.REFUSED_S


def test_loss_is_said_once_until_it_is_back() -> None:
    outage = OutageLog()
    assert not outage.back()
    assert outage.lost(refused=False)
    assert not outage.lost(refused=False)
    assert outage.back()
    assert not outage.back()
    assert outage.lost(refused=False)


def test_key_that_is_turned_down_in_an_outage_is_said_besides() -> None:
    outage = OutageLog()
    assert outage.lost(refused=False)
    assert outage.lost(refused=True)
    assert not outage.lost(refused=False)
    assert not outage.lost(refused=True)


@pytest.mark.parametrize("link", ["stays", "falls", "is another"])
async def test_what_falls_with_the_link_has_no_loss_of_its_own(
    link: str, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(dialling, "GRACE_S", 0.0)
    linked, links = asyncio.Event(), [1]
    linked.set()

    async def fall() -> None:
        if link == "falls":
            linked.clear()
        if link == "is another":
            links.append(2)
        raise LinkLost("the same blow")

    expected = pytest.raises(LinkLost) if link == "stays" else contextlib.nullcontext()
    with expected:
        await dialling.beside_link(linked, lambda: links[-1], fall)


def test_three_beats_without_answer_and_the_peer_is_gone() -> None:
    beats = HeartbeatMonitor(0)
    answer = reply_to(beats.next(0), 0)
    beats.answered(answer, 5_000_000)
    assert beats.round_trip_ms == 5
    for _ in range(3):
        assert not beats.dead
        beats.next(0)
    assert beats.dead


def test_answer_to_a_beat_never_sent_changes_nothing() -> None:
    beats = HeartbeatMonitor(0)
    for number in range(3):
        beats.next(number)
    beats.answered(reply_to(beats.next(0), 0).__class__(n=99, mono_us=0, peer_us=0), 0)
    assert beats.dead


def test_process_that_stood_still_knows_it() -> None:
    beats = HeartbeatMonitor(0)
    beats.next(10 * SECOND)
    assert beats.stood_still_s(11 * SECOND) == 0
    assert beats.stood_still_s(17 * SECOND) == 5
    beats.pulse(17 * SECOND)
    assert beats.stood_still_s(17 * SECOND) == 5


def test_old_batch_stands_alone_when_the_channel_list_changed() -> None:
    frame = SampleBatch(
        boot="b", first=0, catalogue="old", base_us=0, channel=b"", offset=b"", value=b""
    )
    stored = StoredRecord(
        SegmentHead("b", "old", ["a/x"]), SampleRecord(0, 1, 0, 0, LINK_FROM_GATEWAY.encode(frame))
    )
    assert LINK_FROM_GATEWAY.decode(as_old(stored, "new")).addresses == ["a/x"]
    same = LINK_FROM_GATEWAY.decode(as_old(stored, "old"))
    assert (same.addresses, same.live) == ([], False)


@pytest.mark.parametrize(
    ("url", "more"),
    [
        ("ws://127.0.0.1:1", {}),
        ("ws://10.0.0.1:1", {"allow_plain": True}),
        ("ftp://hub", {}),
        ("hub:1", {}),
        ("wss://hub", {"fingerprint": "abc"}),
    ],
)
def test_address_that_is_unsafe_or_none_is_refused(url: str, more: dict) -> None:
    with pytest.raises(SettingsError):
        HubAddress.from_text(url, **more)


def test_address_is_brought_to_its_plain_form() -> None:
    pin = ":".join(["AB"] * 32)
    hub = HubAddress.from_text("https://hub:1/x?y", fingerprint=pin)
    assert (hub.url, hub.fingerprint) == ("wss://hub:1", "ab" * 32)


@pytest.fixture(scope="module")
def certificate(tmp_path_factory: pytest.TempPathFactory) -> tuple[ssl.SSLContext, str]:
    """A server context with a certificate made for the test, and its fingerprint."""
    key = ec.generate_private_key(ec.SECP256R1())
    name = x509.Name([x509.NameAttribute(x509.NameOID.COMMON_NAME, "some hub")])
    now = datetime.datetime.now(datetime.UTC)
    made = (
        x509.CertificateBuilder()
        .subject_name(name)
        .issuer_name(name)
        .public_key(key.public_key())
        .serial_number(1)
        .not_valid_before(now - datetime.timedelta(days=1))
        .not_valid_after(now + datetime.timedelta(days=1))
        .sign(key, hashes.SHA256())
    )
    path = tmp_path_factory.mktemp("tls") / "hub.pem"
    private = key.private_bytes(
        serialization.Encoding.PEM,
        serialization.PrivateFormat.PKCS8,
        serialization.NoEncryption(),
    )
    path.write_bytes(private + made.public_bytes(serialization.Encoding.PEM))
    context = ssl.SSLContext(ssl.PROTOCOL_TLS_SERVER)
    context.load_cert_chain(path)
    shown = made.public_bytes(serialization.Encoding.DER)
    return context, hashlib.sha256(shown).hexdigest()


async def test_pinned_certificate_is_trusted(
    certificate: tuple[ssl.SSLContext, str], tmp_path: Path
) -> None:
    context, pin = certificate
    async with (
        fake_hub(addresses_of, context) as hub,
        running(hub.url, tmp_path, QUIET, fingerprint=pin),
    ):
        await hub.until(lambda: hub.hellos, "a hello")
        assert hub.hellos[0].site == "quiet"


async def test_other_certificate_never_sees_the_key(
    certificate: tuple[ssl.SSLContext, str], tmp_path: Path, caplog: pytest.LogCaptureFixture
) -> None:
    context, _ = certificate
    async with (
        fake_hub(addresses_of, context) as hub,
        running(hub.url, tmp_path, QUIET, fingerprint="00" * 32),
    ):
        await hub.until(lambda: "somebody stands between" in caplog.text, "a warning")
        assert hub.requests == 0


async def test_refused_key_is_said_once_and_tried_again_slowly(
    tmp_path: Path, caplog: pytest.LogCaptureFixture
) -> None:
    async with fake_hub(addresses_of) as hub, running(hub.url, tmp_path, QUIET, key="wrong"):
        await hub.until(lambda: "refuses this gateway's key" in caplog.text, "a warning")
        # It has asked for the hub's number, and has answered three: another hub might have come.
        assert hub.requests == 4


async def test_hub_that_stops_answering_is_left_after_three_beats(
    tmp_path: Path, caplog: pytest.LogCaptureFixture
) -> None:
    async with fake_hub(addresses_of) as hub:
        hub.answering = False
        async with running(hub.url, tmp_path, QUIET):
            await hub.until(lambda: len(hub.hellos) >= 2, "a second link")
    assert "has not answered for 3 s" in caplog.text


def test_addresses_of_hubs_that_are_one_are_read_and_written() -> None:
    hub = HubAddress.from_text("https://east:1/x, wss://west:2")
    assert (hub.url, hub.others) == ("wss://east:1", ("wss://west:2",))
    assert HubAddress.from_text(hub.text) == hub


def test_addresses_of_which_some_are_in_clear_text_are_refused() -> None:
    with pytest.raises(SettingsError, match="some of it is plain text"):
        HubAddress.from_text("wss://hub:1,ws://127.0.0.1:1", allow_plain=True)


def test_the_next_hub_is_dialled_once_for_each_loss_however_many_connections_see_it() -> None:
    trust = HubTrust(HubAddress.from_text("wss://east:1,wss://west:2"))
    # The link and the connection for pictures are lost with the hub that both had.
    for _ in ("link", "pictures"):
        trust.turn_away("wss://east:1")
    assert trust.url == "wss://west:2"
    trust.turn_away("wss://west:2")
    assert trust.url == "wss://east:1"


def test_one_hub_alone_is_dialled_again_and_again() -> None:
    trust = HubTrust(HubAddress.from_text("wss://east:1"))
    trust.turn_away("wss://east:1")
    assert trust.url == "wss://east:1"
