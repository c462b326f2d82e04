"""Without its database the hub lets nobody do anything, and passes STOP on."""

import dataclasses

import pytest
import sqlalchemy as sa
import websockets

from talaia.clock import SECOND, HandClock
from talaia.hub.store.audit import AuditFilter
from talaia.wire import browser as page_wire
from talaia.wire.frames import CommandRequest, LeaseOp, LeaseRequest, LeaseState, StopRequest

from .conftest import MemoryHistory, RunningHub
from .databases import server_of

PASSWORD = "a password for tests"  # noqa: S105


class Away:
    """The database, gone: as when its server is killed, every connection to it fails."""

    def __init__(self, hub) -> None:  # noqa: D107
        self._database = hub.hub.core.database
        database = self._database
        self._known = database._engine, database._writer, database._single

    def __enter__(self) -> None:
        class Refusing:
            def begin(self):
                raise ConnectionRefusedError(111, "the server is gone")

            connect = begin

        gone = Refusing()
        database = self._database
        database._engine = database._writer = database._single = gone

    def __exit__(self, *_exc: object) -> None:
        database = self._database
        database._engine, database._writer, database._single = self._known


def hand_moved(hub) -> HandClock:
    """Let the hub's knowledge of who may do what grow old by hand."""
    clock = HandClock()
    hub.hub.people.seats._clock, hub.hub.people.seats._checked_ns = clock, clock.monotonic_ns()
    return clock


async def test_every_route_that_needs_someone_is_refused(hub) -> None:
    client = await hub.client("admin")
    with Away(hub):
        for method, path, body in (
            ("GET", "/api/me", None),
            ("GET", "/api/sites", None),
            ("GET", "/api/people", None),
            ("POST", "/api/login", {"name": "admin", "password": PASSWORD}),
            ("POST", "/api/setup", {"token": "x", "name": "x", "password": PASSWORD}),
            ("POST", "/api/roles", {"name": "x", "permissions": []}),
        ):
            answer = await client.request(method, path, json=body)
            assert (answer.status_code, answer.json()["code"]) == (503, "store"), path
            assert "111" not in answer.text
        assert (await client.get("/api/health")).status_code == 200
    assert (await client.get("/api/me")).status_code == 200


async def test_sockets_are_refused_before_the_upgrade(hub) -> None:
    cookie = {"Cookie": await hub.cookie("operator"), "Origin": hub.origin}
    key = {"Authorization": f"Bearer {hub.keys['agv']}"}
    with Away(hub):
        for path, headers in (("/ws", cookie), ("/gateway/link", key)):
            with pytest.raises(websockets.InvalidStatus) as refused:
                await hub.dial(path, headers)
            assert refused.value.response.status_code == 503


async def test_commands_are_refused_and_stop_is_passed_on(hub, gateway) -> None:
    page = await hub.page("operator")
    await page.say(page_wire.PageLease(site="agv", device="base", op=LeaseOp.TAKE))
    session = (await gateway.hear(LeaseRequest)).session
    await gateway.say(
        LeaseState(device="base", session=session, who="operator", epoch=1, remains_ms=3000)
    )
    await page.hear(page_wire.LeaseUpdate, lambda news: news.yours)
    clock = hand_moved(hub)
    with Away(hub):
        clock.advance(3 * SECOND)
        driving = page_wire.PageDrive(
            site="agv", device="base", epoch=1, seq=1, tick=1, linear=0.1, angular=0.0
        )
        command = page_wire.PageCommand(site="agv", device="base", command="beep", id="c1")
        for message in (
            driving,
            command,
            page_wire.PageLease(site="agv", device="base", op=LeaseOp.RENEW),
            page_wire.PageReset(site="agv", device="base", epoch=1),
            page_wire.Subscribe(sub=1, site="agv", channels=["power/voltage"]),
        ):
            await page.say(message)
            assert (await page.hear(page_wire.RequestError)).code == "store"
        await page.say(page_wire.PageStop(site="agv", device="base", id="s1"))
        assert (await gateway.hear(StopRequest)).id == "s1"
        await page.say(page_wire.PageLease(site="agv", device="base", op=LeaseOp.FREE))
        await gateway.hear(LeaseRequest, lambda asked: asked.op is LeaseOp.FREE)
        assert not [each for each in gateway.heard if isinstance(each, CommandRequest)]
    await hub.hub.people.seats.check()
    await page.say(page_wire.PageLease(site="agv", device="base", op=LeaseOp.TAKE))
    await gateway.hear(LeaseRequest, lambda asked: asked.op is LeaseOp.TAKE)


async def test_what_was_noted_meanwhile_is_written_down_later(hub, gateway) -> None:
    page = await hub.page("operator")
    with Away(hub):
        await page.say(page_wire.PageStop(site="agv", device="base", id="s1"))
        await gateway.hear(StopRequest)
    await hub.hub.audit.log.wait_written()
    found, _ = await hub.hub.audit.log.find_records(AuditFilter(site="agv"), 50)
    kinds = [row.entry.kind for row in found]
    assert "stop pressed" in kinds
    assert (await hub.hub.audit.log.verify_chain()).broken == 0


# PostgreSQL alone can shut one database and leave the others open.
@pytest.mark.parametrize("database_url", ["postgresql"], indirect=True)
async def test_server_that_goes_and_comes_back_needs_no_restart_of_the_hub(
    settings, database_url
) -> None:
    name = sa.make_url(database_url).database
    server = sa.create_engine(server_of("postgresql")[0], isolation_level="AUTOCOMMIT")

    def let_in(*, allowed: bool) -> None:
        with server.connect() as connection:
            connection.exec_driver_sql(f"ALTER DATABASE {name} ALLOW_CONNECTIONS {allowed}")
            if not allowed:
                connection.execute(
                    sa.text(
                        "SELECT pg_terminate_backend(pid) FROM pg_stat_activity"
                        " WHERE datname = :name"
                    ),
                    {"name": name},
                )

    settings = dataclasses.replace(settings, database_url=database_url)
    async with RunningHub(settings, MemoryHistory()) as hub:
        await hub.populate()
        client = await hub.client("operator")
        page = await hub.page("operator")
        let_in(allowed=False)
        assert (await client.get("/api/me")).status_code == 503
        clock = hand_moved(hub)
        clock.advance(3 * SECOND)
        assert not hub.hub.people.seats.sure
        let_in(allowed=True)
        assert (await client.get("/api/me")).status_code == 200
        await hub.hub.people.seats.check()
        assert hub.hub.people.seats.sure
        await page.say(page_wire.PagePing(n=1, at_ms=0.0))
        await page.hear(page_wire.PagePong)
    server.dispose()
