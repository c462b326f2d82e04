"""A hub that is killed within a move: what it acknowledged is there once, and it goes on."""

import asyncio
import os
import signal
import subprocess
import sys

import pytest

from talaia.hub.store.history_servers.home_tables import OWN

from .samples_sent import assert_whole, send

MOVER = """
import asyncio, sys
from hub.history.servers.conftest import Place
from hub.history.servers.samples_sent import send
from talaia.hub.store.history_servers.home_tables import OWN

async def keep_sending(history, first):
    while True:
        await send(history, "agv", first, first + 25)
        first += 25
        print(first, flush=True)

async def main(accounts, east, first):
    place = Place(accounts, east)
    async with place.opened() as (history, homes):
        sending = asyncio.create_task(keep_sending(history, first))
        while True:
            home = await homes.find_home("agv")
            if home is None or not home.moving_to:
                to = OWN if home is not None and home.server == "east" else "east"
                await homes.ask_move("agv", to, own=OWN)
            await history.move_sites()

asyncio.run(main(sys.argv[1], sys.argv[2], int(sys.argv[3])))
"""


def kill_after(lines, place, first):
    """Kill the program after so many lines; give all that it said."""
    environment = {**os.environ, "PYTHONPATH": os.pathsep.join(sys.path)}
    words = [sys.executable, "-c", MOVER, place.accounts, place.east, str(first)]
    with subprocess.Popen(words, stdout=subprocess.PIPE, text=True, env=environment) as mover:
        said = [int(mover.stdout.readline()) for _ in range(lines)]
        os.kill(mover.pid, signal.SIGKILL)
        return said + [int(line) for line in mover.stdout if line.endswith("\n")]


@pytest.mark.timeout(180)
async def test_kill_minus_nine_within_moves_loses_nothing_that_was_acknowledged(place) -> None:
    below = 0
    async with place.opened() as (history, _):
        await send(history, "other", 0, 40)
    for lines in (3, 17, 40):
        said = await asyncio.to_thread(kill_after, lines, place, below)
        async with place.opened() as (history, homes):
            below = await history.stored_below("agv", "b")
            # What was under way may be there too, all of it or nothing.
            assert below - said[-1] in (0, 25)
            await assert_whole(history, "agv", below)
            await history.move_sites()
            home = await homes.find_home("agv")
            # On a slow machine it is killed before its first move is asked for.
            assert home is None or (home.moving_to, home.erase_at) == ("", "")
            await assert_whole(history, "agv", below)
            await assert_whole(history, "other", 40)
            left = OWN if home is not None and home.server == "east" else "east"
            assert not history.places.store_named(left).transfer.has_site("agv")
