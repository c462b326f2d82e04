"""Hundreds of gateways that come back at once, and what must not wait for them."""

import asyncio
import datetime as dt
import gc
import socket
import ssl

import pytest
import websockets
from msgspec.structs import replace
from patience import PATIENCE_S
from sqlalchemy import select

from talaia.clock import HandClock
from talaia.hub.api.server.accept_queue import AcceptQueue
from talaia.hub.certificate import own_certificate
from talaia.hub.errors import HubBusy, StoreDown
from talaia.hub.live.gateways import hello_intake, link_service
from talaia.hub.live.gateways.join_queue import JoinQueue
from talaia.hub.live.gc_schedule import collect_at_rest, wants_collection, wants_whole
from talaia.hub.settings import Settings
from talaia.hub.store.sites.gateway_presence import GatewayPresence
from talaia.hub.store.sites.site_registry import SiteRegistry
from talaia.hub.store.tables import gateways, sites
from talaia.wire.browser import LeaseUpdate, SiteUpdate
from talaia.wire.frames import Bye, Hello, LeaseState, Welcome
from talaia.wire.sealing import compress_text

from ...conftest import DESCRIPTION, RunningHub, settings_in

KEPT_AT_A_HUT = "talaia: 1\nsite: {site}\nname: {site}\ndevices: {{hut: {{name: Hut}}}}\n"


async def test_description_known_word_for_word_is_not_read_again(hub, gateway, monkeypatch) -> None:
    await gateway.close()
    monkeypatch.setattr(hello_intake, "_read_site", lambda _text: pytest.fail("it was read"))
    again = await hub.gateway()
    await again.hello()
    await again.close()
    # One letter more is another one.
    monkeypatch.undo()
    other = await hub.gateway()
    await other.hello(DESCRIPTION.replace("name: AGV", "name: AGV 2", 1))
    page = await hub.page("operator")
    assert (await page.hear(SiteUpdate)).online


async def test_only_a_few_gateways_have_the_database_at_once_and_all_get_in(
    hub, history, monkeypatch
) -> None:
    inside, most, gate, full = 0, 0, asyncio.Event(), asyncio.Event()
    describe_site = history.describe_site

    async def counted(site) -> None:
        nonlocal inside, most
        inside += 1
        most = max(most, inside)
        if inside == JoinQueue.AT_ONCE:
            full.set()
        await gate.wait()
        inside -= 1
        await describe_site(site)

    monkeypatch.setattr(history, "describe_site", counted)
    registry = SiteRegistry(hub.hub.core.database, hub.hub.core.clock)
    crowd = []
    for number in range(JoinQueue.AT_ONCE + 2):
        site = f"hut{number}"
        crowd.append(await hub.gateway(key=await registry.new_key(site)))
        text = KEPT_AT_A_HUT.format(site=site)
        await crowd[-1].say(Hello(site=site, boot="b", description=text, catalogue="c"))
    async with asyncio.timeout(PATIENCE_S):
        await full.wait()
    # All turns are taken, and people still sign in.
    await hub.client("operator")
    gate.set()
    for each in crowd:
        await each.hear(Welcome)
    assert most == JoinQueue.AT_ONCE


async def test_after_a_restart_a_gateway_that_says_the_same_waits_for_no_turn(tmp_path) -> None:
    """Two hundred that come back to a hub that has taken over would take turns for nothing."""
    settings, keys, news = settings_in(tmp_path), {}, []
    for text in ("# one\n", "# one\n", "# two\n"):
        async with RunningHub(settings, None) as hub:
            if not keys:
                await hub.populate()
                keys.update(hub.keys)
            gateway = await hub.gateway(key=keys["agv"])
            source = DESCRIPTION + text
            hello = replace(gateway.hello_message(), source=compress_text(source))
            news.append(hub.hub.descriptions.describing.has_news(hello, "agv", source))
            await gateway.say(hello)
            await gateway.hear(Welcome)
            # What is stored by now is known at once, too.
            assert not hub.hub.descriptions.describing.has_news(hello, "agv", source)
    assert news == [True, False, True]


async def test_gateway_too_many_is_told_to_come_again(hub, monkeypatch) -> None:
    monkeypatch.setattr(JoinQueue, "MOST_WAITING", 0)
    with pytest.raises(websockets.InvalidStatus) as refused:
        await hub.gateway()
    assert refused.value.response.status_code == 503
    monkeypatch.undo()
    gateway = await hub.gateway()
    monkeypatch.setattr(JoinQueue, "MOST_WAITING", 0)
    await gateway.say(Hello(site="agv", boot="b", description=DESCRIPTION, catalogue="c"))
    assert "try again" in (await gateway.hear(Bye)).reason
    assert await gateway.closed() == link_service.TRY_LATER


async def test_turns_are_had_in_the_order_they_were_asked_for() -> None:
    admission, order = JoinQueue(), []

    async def come(number: int) -> None:
        async with admission.wait_turn():
            order.append(number)
            await asyncio.sleep(0)

    await asyncio.gather(*(come(number) for number in range(20)))
    assert order == list(range(20))
    with pytest.raises(ZeroDivisionError):
        async with admission.wait_turn():
            raise ZeroDivisionError
    await asyncio.gather(*(come(number) for number in range(20, 40)))


async def test_when_a_gateway_was_there_is_known_at_once_and_written_together(database) -> None:
    clock = HandClock(wall_ns=2_000_000_000)
    registry = SiteRegistry(database, clock)
    for number in range(3):
        await registry.new_key(f"s{number}")
        await registry.said_hello(f"s{number}", "text", "c", "1")
    numbers = [each.id for each in await registry.list_gateways()]
    clock.advance(5_000_000_000)
    for number, each in enumerate(numbers):
        registry.attendance.record_link(each, f"s{number}", "2.0", "10.0.0.1")
    registry.attendance.record_leave(numbers[0], "s0")
    assert {each.version for each in await registry.list_gateways()} == {"2.0"}
    fresh = SiteRegistry(database, clock)
    assert {each.version for each in await fresh.list_gateways()} == {""}
    await registry.attendance.write_pending()
    assert {(each.version, each.address, each.seen_us) for each in await fresh.list_gateways()} == {
        ("2.0", "10.0.0.1", 7_000_000)
    }
    async with database.read() as connection:
        seen = (await connection.execute(select(sites.c.last_seen_us, sites.c.version))).all()
    assert set(seen) == {(7_000_000, "2.0")}


async def test_what_could_not_be_written_of_who_was_there_is_written_the_next_time(
    database,
) -> None:
    clock = HandClock(wall_ns=1_000_000_000)
    registry = SiteRegistry(database, clock)
    await registry.new_key("s")
    [known] = await registry.list_gateways()

    class Down:
        """A database that does not answer once; a gateway comes meanwhile."""

        def write(self):
            attendance._database = database
            attendance.record_link(known.id, "s", "new", "b")
            raise StoreDown("no")

    attendance = GatewayPresence(Down(), clock)
    attendance.record_link(known.id, "s", "old", "a")
    with pytest.raises(StoreDown):
        await attendance.write_pending()
    await attendance.write_pending()
    async with database.read() as connection:
        row = (await connection.execute(select(gateways.c.version, gateways.c.address))).one()
    assert tuple(row) == ("new", "b")


class Echo(asyncio.Protocol):
    def connection_made(self, transport) -> None:
        self.transport = transport

    def data_received(self, data: bytes) -> None:
        self.transport.write(data)


@pytest.fixture
async def door(tmp_path):
    made = own_certificate(Settings(data=tmp_path, host="127.0.0.1"), dt.datetime.now(dt.UTC))
    server = ssl.SSLContext(ssl.PROTOCOL_TLS_SERVER)
    server.load_cert_chain(made.cert, made.key)
    with socket.create_server(("127.0.0.1", 0)) as listener:
        doorway = AcceptQueue(listener, Echo, server)
        doorway.open()
        trust = ssl.create_default_context(cafile=str(made.cert))
        trust.check_hostname = False
        yield listener.getsockname()[1], trust, doorway
        await doorway.close()


async def said(port: int, trust: ssl.SSLContext) -> bytes:
    reader, writer = await asyncio.open_connection("127.0.0.1", port, ssl=trust)
    writer.write(b"hello")
    answer = await reader.readexactly(5)
    writer.close()
    return answer


async def test_whoever_comes_in_a_crowd_is_taken_in_though_some_say_nothing_or_nonsense(
    door,
) -> None:
    port, trust, _ = door
    silent = [await asyncio.open_connection("127.0.0.1", port) for _ in range(30)]
    for _, writer in silent[:10]:
        writer.write(b"this is no TLS\r\n\r\n")
    for _, writer in silent[10:20]:
        writer.transport.abort()
    async with asyncio.timeout(PATIENCE_S):
        assert set(await asyncio.gather(*(said(port, trust) for _ in range(40)))) == {b"hello"}
    for _, writer in silent:
        writer.transport.abort()


async def test_door_that_is_closed_takes_nobody_in(door) -> None:
    port, trust, doorway = door
    assert await said(port, trust) == b"hello"
    await doorway.close()
    with pytest.raises(TimeoutError):
        async with asyncio.timeout(0.2):
            await said(port, trust)


def test_full_collection_waits_for_a_driver_but_not_for_ever() -> None:
    assert not wants_collection(9, driven=False)
    assert wants_collection(10, driven=False)
    assert not wants_collection(99, driven=True)
    assert wants_collection(100, driven=True)


def test_everything_is_looked_at_after_an_hour_or_when_much_more_is_set_aside() -> None:
    assert not wants_whole(3599.0, 1_000_000, 1_000_000)
    assert wants_whole(3600.0, 1_000_000, 1_000_000)
    assert not wants_whole(10.0, 1_350_000, 1_000_000)
    assert wants_whole(10.0, 1_350_001, 1_000_000)


async def test_pythons_own_full_collections_are_off_while_ours_run() -> None:
    before = gc.get_threshold()
    collecting = asyncio.create_task(collect_at_rest(lambda: False))
    await asyncio.sleep(0)
    assert gc.get_threshold()[:2] == before[:2]
    assert gc.get_threshold()[2] > 10_000
    assert gc.get_freeze_count() > 0
    collecting.cancel()
    await asyncio.gather(collecting, return_exceptions=True)
    assert gc.get_threshold() == before
    assert gc.get_freeze_count() == 0


async def test_somebody_has_control_from_the_grant_to_its_end(hub, gateway) -> None:
    page = await hub.page("operator")
    assert not hub.hub.is_driven()
    held = LeaseState(device="base", session="s", who="operator", epoch=1, remains_ms=3000)
    await gateway.say(held)
    await page.hear(LeaseUpdate, lambda news: news.holder == "gateway: operator")
    assert hub.hub.is_driven()
    await gateway.say(LeaseState(device="base"))
    await page.hear(LeaseUpdate, lambda news: not news.holder)
    assert not hub.hub.is_driven()


async def test_admission_that_is_full_says_so_and_forgets_nobody() -> None:
    admission = JoinQueue()
    admission.MOST_WAITING = 0
    with pytest.raises(HubBusy):
        async with admission.wait_turn():
            pytest.fail("it was let in")
