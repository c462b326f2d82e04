"""A gateway with a valid key against one hub on each database: for all others it is not there.

One site is the attacker's, another is honest. After each attack the honest site, its files, the
people and their rights are looked at; the audit log holds, and says whose word each row is.
"""

# ruff: noqa: D107

from __future__ import annotations

import asyncio
import dataclasses
import hashlib
import os
import zlib
from pathlib import Path
from zlib import crc32

import pytest
import pytest_asyncio
import websockets
from patience import PATIENCE_S
from sqlalchemy import select

from talaia.hub.live.gateways import frame_limits
from talaia.hub.store.sites.site_registry import add_key
from talaia.hub.store.tables import permissions, role_permissions, roles, users
from talaia.wire.browser import CommandUpdate, EventUpdate, PageCommand
from talaia.wire.frames import (
    FILES_FROM_GATEWAY,
    FILES_FROM_HUB,
    LINK_FROM_GATEWAY,
    LINK_FROM_HUB,
    Ack,
    ArchiveOffer,
    Beat,
    CommandPhase,
    CommandRequest,
    CommandState,
    DescriptionUpdate,
    DeviceState,
    Event,
    FileOffer,
    FilePiece,
    FilmOffer,
    LeaseState,
    PictureFrame,
    StopState,
)

from ...conftest import DESCRIPTION, Gateway, RunningHub, settings_in
from ...databases import database_with_tables

pytestmark = pytest.mark.asyncio(loop_scope="module")

NOW_US = 1_700_000_000_000_000
HONEST = DESCRIPTION.replace("site: agv", "site: moon")
BODY = os.urandom(5_000)
KEPT = "20260101T120000Z-abcdef"
WHO_MAY = (users, roles, permissions, role_permissions)
# Of all attacks together; what a hub takes for them is given back or bounded.
MOST_GROWN_KIB = 120 * 1024


class Siege:
    """A hub with an honest site, whose gateway is there, and the key of a hostile one."""

    def __init__(self, hub: RunningHub) -> None:
        self.hub = hub
        self._said = 0
        self._attacker: Gateway | None = None

    async def begin(self) -> None:
        await self.hub.populate()
        async with self.hub.hub.core.database.write() as connection:
            _, self.hub.keys["moon"], _ = await add_key(connection, "moon", "", NOW_US)
        self.honest = await self.hub.gateway(key=self.hub.keys["moon"])
        await self.honest.hello(HONEST, site="moon")
        self.admin = await self.hub.client("admin")
        # Whoever signs in later is in the rows of people.
        await self.hub.cookie("operator")
        done = await (await self.files("moon")).bring(BODY)
        assert done.done
        self.before = await self.snapshot()

    async def attacker(self) -> Gateway:
        """Give the hostile gateway, let in as the site that its key is for."""
        live = self.hub.hub.core.sites.find_site("agv")
        if live is not None:
            # Each attack begins with the whole allowance.
            live.frame_limits = frame_limits.FrameLimits()
        if self._attacker is not None:
            await self._attacker.close()
        gateway = self._attacker = await self.hub.gateway()
        await gateway.hello(boot=f"boot-{os.urandom(4).hex()}")
        return gateway

    async def files(self, site: str) -> Files:
        key = {"Authorization": f"Bearer {self.hub.keys[site]}"}
        return Files(await self.hub.dial("/gateway/files", key))

    async def snapshot(self) -> dict[str, object]:
        """Give all that an attack must leave as it is."""
        found: dict[str, object] = {}
        async with self.hub.hub.core.database.read() as connection:
            for table in WHO_MAY:
                rows = await connection.execute(select(table))
                found[table.name] = sorted(map(repr, rows))
        listed = (await self.admin.get("/api/sites/moon/recordings")).json()["recordings"]
        found["recordings"] = listed
        live = self.hub.hub.core.sites.find_site("moon")
        current = live.current
        found["states"] = [
            sorted(part) for part in (current.leases, current.drives, current.unreached)
        ]
        found["stops"] = sorted(live.retained.stops)
        return found

    async def others_are_as_before(self) -> None:
        """Look at everything that is not the attacker's; the honest site goes on meanwhile."""
        self._said += 1
        await self.honest.samples(("base/speed", NOW_US + self._said, 0.5))
        await self.honest.hear(Ack)
        assert await self.snapshot() == self.before
        kept = await self.admin.get(f"/api/sites/moon/recordings/{KEPT}/file")
        assert kept.content == BODY
        chain = (await self.admin.get("/api/audit/verify")).json()
        assert (chain["ok"], chain["broken"]) == (True, 0)
        rows = await self.audit(site="moon")
        assert {row["who"] for row in rows} <= {"", "gateway: ada", "operator", "admin"}

    async def audit(self, source: str = "", **wanted: object) -> list[dict]:
        answer = await self.admin.get("/api/audit", params={"limit": 500, **wanted})
        rows = answer.json()["rows"]
        return [row for row in rows if not source or row["source"] == source]


class Files:
    """A gateway's connection that brings files."""

    def __init__(self, connection) -> None:
        self.connection = connection

    async def ask(self, message):
        await self.connection.send(FILES_FROM_GATEWAY.encode(message))
        return FILES_FROM_HUB.decode(await self.connection.recv())

    async def bring(self, body: bytes, name: str = KEPT):
        has = await self.ask(offer_of(body, name))
        while not has.done and not has.refused:
            part = body[has.have : has.have + 2_000]
            has = await self.ask(FilePiece(id=name, at=has.have, check=crc32(part), data=part))
        return has


def offer_of(body: bytes, name: str = KEPT) -> FileOffer:
    digest = hashlib.sha256(body).hexdigest()
    return FileOffer(id=name, size=len(body), digest=digest, who="ada", begin_us=1, end_us=2)


@pytest.fixture(scope="module", params=["sqlite", "postgresql"])
def settings_of_database(request, tmp_path_factory):
    """Outside of any loop, for tables are made in one of their own."""
    settings = settings_in(tmp_path_factory.mktemp("hostile"))
    if request.param == "sqlite":
        yield settings
        return
    with database_with_tables(request.param, settings.data) as url:
        yield dataclasses.replace(settings, database_url=url)


@pytest_asyncio.fixture(scope="module", loop_scope="module")
async def siege(settings_of_database):
    """One hub for all attacks, on each database."""
    async with RunningHub(settings_of_database, None) as hub:
        siege = Siege(hub)
        await siege.begin()
        siege.began_kib = begin_to_measure_memory()
        yield siege


def begin_to_measure_memory() -> int:
    """Let ``VmHWM`` be the most from here on (proc(5)), whatever ran before; give what is (KiB)."""
    Path("/proc/self/clear_refs").write_text("5")
    return memory_kib("VmRSS")


def memory_kib(field: str) -> int:
    """Read a field of this process's status (KiB)."""
    status = Path("/proc/self/status").read_text()
    return int(status.partition(f"{field}:")[2].split()[0])


async def test_announced_and_never_sent_files_take_nobody_s_room(siege) -> None:
    await siege.attacker()
    files = await siege.files("agv")
    huge = {"size": 20 * 2**30, "digest": "0" * 64}
    for number in range(5):
        await files.ask(FileOffer(id=f"2026010{number}T000000Z-a", begin_us=1, end_us=2, **huge))
        await files.ask(
            FilmOffer(
                id=f"2026020{number}T000000Z-a", stream="camera/front", begin_us=1, end_us=2, **huge
            )
        )
    refused = await files.ask(ArchiveOffer(id="1" * 32, kind="fits", device="camera", **huge))
    assert not refused.done
    await siege.others_are_as_before()
    # And the honest site brings another, and has room for it.
    done = await (await siege.files("moon")).bring(BODY[::-1], "20260102T120000Z-abcdef")
    assert done.done
    answer = await siege.admin.delete("/api/sites/moon/recordings/20260102T120000Z-abcdef")
    assert answer.status_code == 204


async def test_flood_of_states_and_events_ends_its_own_link_alone(siege) -> None:
    gateway = await siege.attacker()
    page = await siege.hub.page("admin")
    live = siege.hub.hub.core.sites.find_site("agv")
    few = frame_limits.Allowance(rate=50.0, burst=100.0)
    live.frame_limits = frame_limits.FrameLimits(few, longest_over_s=0.3)
    before = len(await siege.audit("gateway", site="agv"))
    try:
        for number in range(2_000):
            await gateway.say(DeviceState(device=f"made-up-{number}", reached=False))
            await gateway.say(Event(kind="robot_log", who="admin", message=f"flood {number}"))
    except websockets.ConnectionClosed:
        pass
    assert await gateway.closed() == 1013
    assert not (await page.hear(EventUpdate, lambda news: news.kind == "gateway cut off")).good
    await siege.others_are_as_before()
    assert len(await siege.audit("gateway", site="agv")) - before < 300
    assert not live.current.unreached
    live.frame_limits = frame_limits.FrameLimits()


async def test_lies_and_forged_names_stand_as_its_own_word(siege) -> None:
    gateway = await siege.attacker()
    for kind in ("login", "person changed", "role changed\nlogin"):
        await gateway.say(Event(kind=kind, who="admin", message="forged", good=True))
    await gateway.say(LeaseState(device="base", session="made-up", who="admin", epoch=3))
    await gateway.say(StopState(device="base", latched=True, who="admin", id="made-up"))
    done = CommandState(
        id="nobody-asked",
        device="base",
        command="wander",
        phase=CommandPhase.SUCCEEDED,
        who="admin",
    )
    await gateway.say(done)
    await read_by_the_hub(gateway)
    told = await siege.audit("gateway", site="agv")
    assert "forged" in " ".join(row["message"] for row in told)
    assert {row["who"] for row in told if "admin" in row["who"]} == {"gateway: admin"}
    assert not {row["kind"] for row in told} & {"login", "person changed", "command succeeded"}
    await siege.others_are_as_before()
    # STOP is latched at its own robot alone.
    await gateway.say(StopState(device="base", latched=False, who="admin", id="made-up"))


async def read_by_the_hub(gateway: Gateway) -> None:
    """Wait until all that was said is read: it takes samples in the same order."""
    await gateway.samples(("base/speed", NOW_US, 0.5))
    await gateway.hear(Ack)


async def test_replayed_and_reordered_frames_change_nothing_twice(siege) -> None:
    gateway = await siege.attacker()
    row = ("base/speed", NOW_US + 77_000_000, 3.25)
    for _ in range(3):
        await gateway.samples(row, first=5)
    await gateway.samples(row, first=0)
    page = await siege.hub.page("operator")
    asked = PageCommand(
        site="agv", id="once", device="base", command="wander", args={"active": True}
    )
    await page.say(asked)
    await gateway.hear(CommandRequest)
    states = (CommandPhase.SUCCEEDED, CommandPhase.RUNNING, CommandPhase.SUCCEEDED)
    for phase in (*states, CommandPhase.FAILED, *states):
        state = CommandState(id="once", device="base", command="wander", phase=phase, who="admin")
        await gateway.say(state)
    await read_by_the_hub(gateway)
    ends = [row for row in await siege.audit(site="agv") if row["kind"].startswith("command ")]
    of_operator = [row["kind"] for row in ends if row["who"] == "operator"]
    assert of_operator.count("command succeeded") == 1
    assert "command failed" not in of_operator
    # What contradicts the end stands as the gateway's own word.
    assert "command of the site failed" in [
        row["kind"] for row in ends if row["who"] == "gateway: operator"
    ]
    store = siege.hub.hub.history.store
    (series,) = await store.read_series("agv", ["base/speed"], row[1], row[1] + 1, width=10)
    # By its number it is one sample, and by another number another.
    assert len(series.time_us) == 2
    await siege.others_are_as_before()


async def test_half_a_frame_and_frames_of_nonsense_cost_nobody_anything(siege) -> None:
    whole = LINK_FROM_GATEWAY.encode(Event(kind="robot_log", message="x" * 200))
    for nonsense in (whole[: len(whole) // 2], b"\x91" * 5_000, b"", b"\xc1", whole + b"\0"):
        gateway = await siege.attacker()
        await gateway.connection.send(nonsense)
        assert await gateway.closed() in {1002, 1007, 1008, 1009}
    # Half of a frame of the socket's own: the rest never comes.
    reader, writer = await asyncio.open_connection("127.0.0.1", siege.hub.port)
    writer.write(
        b"GET /gateway/link HTTP/1.1\r\nHost: 127.0.0.1\r\nUpgrade: websocket\r\n"
        b"Connection: Upgrade\r\nSec-WebSocket-Version: 13\r\n"
        b"Sec-WebSocket-Key: dGhlIHNhbXBsZSBub25jZQ==\r\n"
        + f"Authorization: Bearer {siege.hub.keys['agv']}\r\n\r\n".encode()
    )
    answer = await asyncio.wait_for(reader.readuntil(b"\r\n\r\n"), PATIENCE_S)
    assert answer.startswith(b"HTTP/1.1 101")
    # It says that 64 KiB come, masked, and sends ten bytes.
    writer.write(b"\x82\xff" + (65_536).to_bytes(8, "big") + b"mask" + b"0123456789")
    await writer.drain()
    await siege.others_are_as_before()
    writer.close()


class Silent(Gateway):
    """Answers nothing by itself, also no beats."""

    async def take(self, message) -> None:
        if not isinstance(message, Beat):
            await super().take(message)


async def test_gateway_that_never_acknowledges_holds_up_no_other(siege) -> None:
    headers = {"Authorization": f"Bearer {siege.hub.keys['agv']}"}
    connection = await siege.hub.dial("/gateway/link", headers)
    silent = siege.hub._keep(Silent(connection, LINK_FROM_GATEWAY, LINK_FROM_HUB))
    await silent.hello(boot="boot-silent")
    page = await siege.hub.page("operator")
    for number in range(20):
        args = {"site": "agv", "device": "base", "command": "wander", "args": {"active": True}}
        await page.say(PageCommand(id=f"unheard-{number}", **args))
    # The same person is served by the honest site meanwhile.
    command = {"device": "base", "command": "wander"}
    await page.say(PageCommand(site="moon", id="heard", **command, args={"active": True}))
    await siege.honest.hear(CommandRequest)
    done = CommandState(id="heard", **command, phase=CommandPhase.SUCCEEDED, who="operator")
    await siege.honest.say(done)
    heard = await page.hear(
        CommandUpdate, lambda news: news.id == "heard" and news.phase == done.phase
    )
    assert heard.site == "moon"
    # Whose beats nobody answers is cut off by the hub.
    assert await silent.closed() >= 1000
    await siege.others_are_as_before()


async def test_claim_to_another_site_is_refused_and_its_gateway_stays(siege) -> None:
    thief = await siege.hub.gateway()
    await thief.say(thief.hello_message(HONEST, boot="boot-thief", site="moon"))
    assert await thief.closed() >= 1000
    gateway, files = await siege.attacker(), await siege.files("agv")
    # A recording of the same name is the attacker's own, beside the honest one's.
    assert (await files.bring(b"forged", KEPT)).done
    await gateway.say(gateway.hello_message(HONEST, boot="boot-again", site="moon"))
    await gateway.say(Event(kind="robot_log", message="moon: login by admin"))
    await siege.others_are_as_before()
    own = await siege.admin.get(f"/api/sites/agv/recordings/{KEPT}/file")
    assert own.content == b"forged"


def squeezed(packer, begin: bytes, mebibytes: int) -> bytes:
    """Pack so many MiB of nothing, without ever having them whole here."""
    parts = [packer.compress(begin)]
    parts += [packer.compress(bytes(2**20)) for _ in range(mebibytes)]
    return b"".join([*parts, packer.flush()])


async def test_bombs_are_refused_or_cost_their_own_site_alone(siege) -> None:
    gateway, files = await siege.attacker(), await siege.files("agv")
    card = b"SIMPLE  =                    T".ljust(80)
    packed = squeezed(zlib.compressobj(6, wbits=31), card.ljust(2880), 130)
    digest = hashlib.sha256(packed).hexdigest()
    offer = ArchiveOffer(
        id=digest[:32], kind="fits", device="camera", size=len(packed), digest=digest, time_us=1
    )
    has = await files.ask(offer)
    while not has.done and not has.refused:
        part = packed[has.have : has.have + 60_000]
        has = await files.ask(FilePiece(id=offer.id, at=has.have, check=crc32(part), data=part))
    assert "its first card is not SIMPLE" in has.refused
    # A description that unpacks to more than one may have: on the link, and within hello.
    bomb = squeezed(zlib.compressobj(9), b"talaia: 1\n", 40)
    await gateway.say(DescriptionUpdate(description=bomb, catalogue="bomb", addresses=[]))
    assert await gateway.closed() >= 1000
    # A picture that says it has 60 000 rows is in no frame, and one of 16 384 is never unpacked.
    camera = await siege.hub.camera()
    large = {"stream": "camera/front", "seq": 1, "time_us": 1, "mono_us": 1, "data": b"\xff\xd8"}
    await camera.say(PictureFrame(**large, width=60_000, height=60_000))
    assert await camera.closed() == 1002
    await siege.others_are_as_before()


async def test_memory_is_as_if_it_had_not_been_there(siege) -> None:
    # Nothing of what was unpacked, announced or said stayed, not even for a moment.
    assert memory_kib("VmHWM") - siege.began_kib < MOST_GROWN_KIB
