"""A gateway with a valid key that lies and floods: the audit log and the hub's memory hold."""

from __future__ import annotations

import hashlib
from zlib import crc32

import msgspec
import pytest
import websockets

from talaia.hub.live.gateways import frame_limits
from talaia.hub.store.sites.site_registry import GatewayKey
from talaia.wire.browser import EventUpdate, NightUpdate, PageCommand
from talaia.wire.frames import (
    FILES_FROM_GATEWAY,
    Ack,
    ArchiveOffer,
    Bye,
    CommandPhase,
    CommandRequest,
    CommandState,
    DetectedBoxes,
    DeviceState,
    DriveState,
    Event,
    FileOffer,
    FilePiece,
    InterlockState,
    LeaseState,
    NightPhase,
    NightState,
    StopState,
    TwinState,
)

COMMANDS = {"device": "base", "command": "wander"}


async def audit_rows(hub, **wanted) -> list[dict]:
    admin = await hub.client("admin")
    answer = await admin.get("/api/audit", params={"limit": 200, **wanted})
    return answer.json()["rows"]


async def until_read(gateway) -> None:
    """Wait until the hub has read all that was said: it takes samples in the same order."""
    await gateway.samples(("base/speed", 1_700_000_000_000_000, 0.5))
    await gateway.hear(Ack)


# ── what it writes into the audit log ──


async def test_gateway_that_says_login_by_an_admin_writes_an_event_of_its_own(hub, gateway) -> None:
    for kind in ("login", "person changed", "camera\nlogin"):
        await gateway.say(Event(kind=kind, who="admin", message="forged", good=True))
    await until_read(gateway)
    forged = [row for row in await audit_rows(hub) if "forged" in row["message"]]
    assert [row["kind"] for row in forged] == ["gateway event"] * 3
    assert {row["source"] for row in forged} == {"gateway"}
    # No account can be called so.
    assert {row["who"] for row in forged} == {"gateway: admin"}
    assert forged[-1]["message"] == "login: forged"
    # What the hub wrote itself says so.
    assert {row["source"] for row in await audit_rows(hub, kind="login")} == {"hub"}


async def test_command_nobody_asked_for_succeeds_in_nobodys_name(hub, gateway) -> None:
    done = CommandState(id="c-1", **COMMANDS, phase=CommandPhase.SUCCEEDED, who="admin")
    await gateway.say(done)
    await until_read(gateway)
    (row,) = await audit_rows(hub, kind="command")
    assert (row["kind"], row["who"]) == ("command of the site succeeded", "gateway: admin")
    assert row["source"] == "gateway"


async def test_command_that_was_asked_for_ends_in_the_name_of_who_asked(hub, gateway) -> None:
    page = await hub.page("operator")
    await page.say(PageCommand(site="agv", id="c-2", **COMMANDS, args={"active": True}))
    await gateway.hear(CommandRequest)
    await gateway.say(CommandState(id="c-2", **COMMANDS, phase=CommandPhase.SUCCEEDED, who="admin"))
    await until_read(gateway)
    (row,) = await audit_rows(hub, kind="command succeeded")
    assert (row["who"], row["source"]) == ("operator", "gateway")


async def test_lease_and_stop_in_the_name_of_somebody_who_never_asked_are_told_as_said(
    hub, gateway
) -> None:
    page = await hub.page("operator")
    await gateway.say(LeaseState(device="base", session="made-up", who="admin", epoch=3))
    await gateway.say(StopState(device="base", latched=True, who="admin", id="made-up"))
    await gateway.say(Event(kind="recording_started", who="admin", message="forged"))
    told = await page.hear(EventUpdate, lambda news: news.kind == "recording_started")
    assert told.who == "gateway: admin"
    kinds = {row["kind"]: row["who"] for row in await audit_rows(hub, who="gateway: admin")}
    assert set(kinds) == {"lease taken", "stop latched", "recording_started"}


# ── what it fills ──


async def test_states_of_devices_that_it_does_not_have_are_not_kept(hub, gateway) -> None:
    for number in range(50):
        name = f"made-up-{number}"
        await gateway.say(DeviceState(device=name, reached=False))
        await gateway.say(LeaseState(device=name, session="s", who="admin", epoch=number + 1))
        await gateway.say(DriveState(device=name, linear=0.0, angular=0.0, cap=1.0))
        await gateway.say(TwinState(device=name, twin=name))
        await gateway.say(StopState(device=name, latched=True))
        await gateway.say(InterlockState(interlock=name, locked=True))
        await gateway.say(
            CommandState(id=name, device=name, command="x", phase=CommandPhase.RUNNING, acting="me")
        )
    await until_read(gateway)
    live = hub.hub.core.sites.find_site("agv")
    current = live.current
    kept = (
        current.leases,
        current.drives,
        current.twins,
        current.interlocks,
        current.unreached,
        current.acting,
    )
    assert [sorted(part) for part in kept] == [[]] * len(kept)
    assert not live.retained.stops
    assert not [row for row in await audit_rows(hub, site="agv") if "made-up" in row["device"]]


async def test_flood_is_slowed_then_cut_off_and_an_admin_sees_it(hub, gateway) -> None:
    live = hub.hub.core.sites.find_site("agv")
    live.frame_limits = frame_limits.FrameLimits(
        frame_limits.Allowance(rate=50.0, burst=100.0), longest_over_s=0.5
    )
    page = await hub.page("admin")
    for number in range(1_000):
        await gateway.say(Event(kind="robot_log", message=f"flood {number}"))
    assert await gateway.closed() == 1013
    assert not (await page.hear(EventUpdate, lambda news: news.kind == "gateway slowed")).good
    told = await page.hear(EventUpdate, lambda news: news.kind == "gateway cut off")
    assert "event" in told.message
    kept = await audit_rows(hub, kind="robot_log", limit=500)
    assert 100 <= len(kept) < 300
    # It is not let in again at once, and is told when to come back.
    again = await hub.gateway()
    await again.say(again.hello_message())
    assert 0 < (await again.hear(Bye)).after_s <= frame_limits.HELD_S


# ── what it says on its other connections ──

FEW = frame_limits.Allowance(rate=50.0, burst=100.0)
BOXES = DetectedBoxes(stream="camera/front", seq=1, time_us=1, things=[])
# A hub of a later version would know it.
UNKNOWN = msgspec.msgpack.encode({"t": "of_a_later_version"})


def hold_short(hub, **others: frame_limits.Allowance) -> frame_limits.FrameLimits:
    """Give the site little, so that a flood of a test is one."""
    live = hub.hub.core.sites.find_site("agv")
    live.frame_limits = frame_limits.FrameLimits(longest_over_s=0.5, others=others)
    return live.frame_limits


async def test_flood_of_unknown_messages_is_slowed_then_cut_off(hub, gateway) -> None:
    hold_short(hub, **{frame_limits.UNKNOWN: FEW})
    page = await hub.page("admin")
    for _ in range(1_000):
        await gateway.connection.send(UNKNOWN)
    assert await gateway.closed() == 1013
    assert not (await page.hear(EventUpdate, lambda news: news.kind == "gateway slowed")).good
    told = await page.hear(EventUpdate, lambda news: news.kind == "gateway cut off")
    assert "unknown" in told.message


async def test_flood_on_the_media_connection_is_cut_off_and_nobody_is_let_in_for_a_while(
    hub, gateway
) -> None:
    hold_short(hub, boxes=FEW)
    page, camera = await hub.page("admin"), await hub.camera()
    for _ in range(1_000):
        await camera.say(BOXES)
    assert await camera.closed() == 1013
    told = await page.hear(EventUpdate, lambda news: news.kind == "gateway cut off")
    assert "boxes" in told.message
    again = await hub.camera()
    assert 0 < (await again.hear(Bye)).after_s <= frame_limits.HELD_S
    # The link itself stands: STOP goes by it.
    await until_read(gateway)


async def test_flood_of_offers_of_files_is_cut_off(hub, gateway) -> None:
    del gateway
    hold_short(hub, **{"pictures for the archive": FEW})
    page = await hub.page("admin")
    files = await hub.dial("/gateway/files", {"Authorization": f"Bearer {hub.keys['agv']}"})
    offer = ArchiveOffer(id="0" * 32, kind="none", device="camera", size=1, digest="0" * 64)
    for _ in range(1_000):
        try:
            await files.send(FILES_FROM_GATEWAY.encode(offer))
            await files.recv()
        except websockets.ConnectionClosed:
            break
    assert files.close_code == 1013
    told = await page.hear(EventUpdate, lambda news: news.kind == "gateway cut off")
    assert "archive" in told.message


async def test_gateway_that_dials_without_end_is_sent_away_before_it_is_heard(hub, gateway) -> None:
    del gateway
    hold_short(hub, **{frame_limits.DIALS: frame_limits.Allowance(rate=0.1, burst=3.0)})
    refused = None
    for _ in range(10):
        try:
            await (await hub.camera()).close()
        except websockets.InvalidStatus as error:
            refused = error.response
            break
    assert refused is not None
    assert refused.status_code == 503
    assert int(refused.headers["Retry-After"]) >= 1


async def test_site_that_never_said_what_it_is_has_allowances_as_well(hub) -> None:
    guard = hub.hub.robot_events.flood_guard
    other = GatewayKey(2, "other")
    assert [guard.admit_dial(other) for _ in range(300)] == [0.0] * 300
    assert guard.admit_dial(other) >= 1.0
    # And no other site pays for it.
    assert guard.admit_dial(GatewayKey(1, "agv")) == 0.0


# ── in whose name its files and its night stand ──


async def test_recording_and_change_of_the_description_in_a_strange_name_are_its_own_word(
    hub, gateway
) -> None:
    files = await hub.dial("/gateway/files", {"Authorization": f"Bearer {hub.keys['agv']}"})
    body = b"recording"
    offer = FileOffer(
        id="20260101T120000Z-abcdef",
        size=len(body),
        digest=hashlib.sha256(body).hexdigest(),
        why="login by admin",
        who="admin",
        begin_us=1,
        end_us=2,
    )
    await files.send(FILES_FROM_GATEWAY.encode(offer))
    await files.recv()
    piece = FilePiece(id=offer.id, at=0, check=crc32(body), data=body)
    await files.send(FILES_FROM_GATEWAY.encode(piece))
    await files.recv()
    admin = await hub.client("admin")
    (found,) = (await admin.get("/api/sites/agv/recordings")).json()["recordings"]
    assert found["who"] == "gateway: admin"
    (row,) = await audit_rows(hub, kind="recording stored")
    assert row["source"] == "gateway"
    state = NightState(phase=NightPhase.WAITING, armed_by="admin")
    await gateway.say(state)
    page = await hub.page("admin")
    assert (await page.hear(NightUpdate)).armed_by == "gateway: admin"


@pytest.mark.parametrize("frames_sent", [30_000])
def test_spool_that_drains_is_slowed_at_the_most_and_never_cut_off(frames_sent) -> None:
    limits = frame_limits.FrameLimits()
    now_ns, over = 0, False
    for _ in range(frames_sent):
        verdict = limits.charge("samples", now_ns)
        over = over or verdict.cut_off
        now_ns += int(verdict.wait_s * 1e9) + 1000
    assert not over
