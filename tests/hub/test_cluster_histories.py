"""Several hubs whose histories lie on servers of their own: a site moves while all goes on."""

import asyncio
import signal
from contextlib import AsyncExitStack, suppress

import pytest
import websockets
from async_program import start_program
from patience import PATIENCE_S, until_answered

from talaia.wire.frames import Ack

from .databases import empty_database
from .several_hubs import sites_stored_in, two_hubs
from .test_cluster_run import ROW_US, STEP, has_roles


@pytest.fixture
def urls():
    """Give three empty databases: of the accounts, and of two servers of histories."""
    with (
        empty_database("postgresql") as accounts,
        empty_database("mariadb") as east,
        empty_database("postgresql") as west,
    ):
        yield accounts, east, west


# A hub that stands still says nothing; one on a busy machine is late (s).
GIVES_UP_S = 15.0
# `Peer.hear` tells by an assertion that the link was closed.
LOSSES = (OSError, TimeoutError, AssertionError, websockets.WebSocketException)


class Sender:
    """A gateway whose samples are their numbers; it comes again by whichever hub answers."""

    def __init__(self, hubs) -> None:  # noqa: D107
        self._hubs = hubs
        self._way = list(hubs.all)
        self.sent = self.acked = 0
        self._ending = False
        self._task = asyncio.create_task(self._run())

    async def end(self) -> int:
        """Send no more; give how many there are, which all are acknowledged."""
        self._ending = True
        await asyncio.wait_for(self._task, PATIENCE_S)
        return self.sent

    async def past(self, number: int) -> None:
        """Wait until so many are acknowledged."""

        async def is_past() -> bool:
            assert not self._task.done(), self._task.exception()
            return self.acked >= number

        await until_answered(is_past)

    async def _run(self) -> None:
        while not self._ending or self.acked < self.sent:
            # The one of before stands still, perhaps: the next one.
            self._way.append(self._way.pop(0))
            with suppress(*LOSSES):
                async with asyncio.timeout(GIVES_UP_S), AsyncExitStack() as stack:
                    gateway = await self._hubs.gateway(self._way[0])
                    # Another link of the same gateway would wait for the place of this one.
                    stack.push_async_callback(gateway.close)
                    welcome = await gateway.hello()
                    stack.pop_all()
                try:
                    self.acked = max(self.acked, welcome.acked)
                    await self._send(gateway, self.acked)
                finally:
                    await gateway.close()

    async def _send(self, gateway, first: int) -> None:
        while not self._ending or self.acked < self.sent:
            if not self._ending:
                self.sent = max(self.sent, first + STEP)
            rows = [
                ("power/voltage", ROW_US + at * 1000, float(at))
                for at in range(first, min(first + STEP, self.sent))
            ]
            await gateway.samples(*rows, first=first)
            first += len(rows)
            async with asyncio.timeout(GIVES_UP_S):
                told = await gateway.hear(Ack, lambda ack, past=first: ack.below >= past)
            self.acked = max(self.acked, told.below)


async def begin_move(folder, url: str, servers, server: str):
    """Ask for a move as an operator does, on a machine that has no hub."""
    folder.mkdir(exist_ok=True)
    words = ("history", "move", "agv", "--to", server, "--data", str(folder))
    return await start_program(
        *("-m", "talaia", *words, "--history-servers", str(servers)),
        with_errors=True,
        TALAIA_DATABASE_URL=url,
    )


async def all_values(hubs, hub, past: int) -> list[float]:
    """Ask a hub for each sample below ``past``, in windows that are shown exactly."""
    found = []
    for first in range(0, past, 5_000):
        answer = await hubs.get(
            hub,
            "/api/sites/agv/history",
            channel="power/voltage",
            from_us=ROW_US + first * 1000,
            to_us=ROW_US + (min(first + 5_000, past) - 1) * 1000,
            width=10_000,
        )
        assert answer.status_code == 200, answer.text
        found += answer.json()["series"][0]["v"]
    return found


@pytest.mark.timeout(600)
async def test_a_site_moves_though_the_hub_that_leads_is_replaced_within(tmp_path, urls) -> None:
    accounts, east, west = urls
    servers = tmp_path / "servers.yaml"
    servers.write_text(f"servers: {{east: '{east}', west: '{west}'}}\ndefault: east\n")
    servers.chmod(0o600)
    more = ("--history-servers", str(servers))
    async with two_hubs(accounts, tmp_path, *more) as (hubs, lead, other):
        sender = Sender(hubs)
        await sender.past(10 * STEP)
        moving = await begin_move(tmp_path / "operator", accounts, servers, "west")
        _, errors = await asyncio.wait_for(moving.communicate(), PATIENCE_S)
        assert moving.returncode == 0, errors.decode()
        # Whoever asks at either hub is told from the new place, from the first moment on.
        moved = sender.acked
        await sender.past(moved + 2 * STEP)
        for hub in (lead, other):
            assert await all_values(hubs, hub, moved) == [float(at) for at in range(moved)]
        assert sites_stored_in(west) == ["agv"]
        assert sites_stored_in(east) == []
        # And back; the hub that does it stands still meanwhile, until another leads.
        moving = await begin_move(tmp_path / "operator", accounts, servers, "east")
        lead.signal(signal.SIGSTOP)
        await other.until_leads()
        await sender.past(sender.acked + 4 * STEP)
        # It wakes up in the midst of what it wrote, and may write nothing more.
        lead.signal(signal.SIGCONT)
        _, errors = await asyncio.wait_for(moving.communicate(), PATIENCE_S)
        assert moving.returncode == 0, errors.decode()
        await lead.until_ready()
        await until_answered(lambda: has_roles(hubs, lead, {"east": "waits", "west": "leads"}))
        sent = await sender.end()
        for hub in (lead, other):
            assert await all_values(hubs, hub, sent) == [float(at) for at in range(sent)]
        assert sites_stored_in(east) == ["agv"]
        assert sites_stored_in(west) == []
        assert (await hubs.get(other, "/api/audit/verify")).json()["ok"]
