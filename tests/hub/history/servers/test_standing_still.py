"""A server that accepts and answers nothing: other sites go on, it is said once, and it mends."""

import asyncio
import logging

import pytest
from patience import PATIENCE_S

from talaia.hub.history.errors import HistoryAway, HistoryError
from talaia.hub.store.history_servers.home_tables import OWN

from ..samples import ALL
from .frozen_way import FrozenWay
from .samples_sent import ADDRESSES, assert_whole, send

pytestmark = pytest.mark.parametrize("database_url", ["postgresql", "mariadb"], indirect=True)
# Longer than an answer takes on a busy machine.
STILL_S = 1.5


@pytest.fixture
async def way(place):
    async with FrozenWay(place.east) as way:
        place.east, place.default = way.url, "east"
        yield way


async def test_others_go_on_and_what_was_under_way_is_there_once_when_it_is_back(
    place, way, caplog
) -> None:
    caplog.set_level(logging.WARNING)
    async with place.opened(still_s=STILL_S) as (history, homes):
        await homes.add_home("near", OWN)
        await send(history, "agv", 0, 30)
        way.freeze()
        under_way = [
            asyncio.create_task(send(history, "agv", 30, 60)),
            asyncio.create_task(history.read_series("agv", ADDRESSES, *ALL, width=1000)),
        ]
        # Neither the loop nor another site waits for it.
        await send(history, "near", 0, 20)
        await assert_whole(history, "near", 20)
        async with asyncio.timeout(PATIENCE_S):
            for _ in range(2):
                await history.mend_servers()
            # Whoever waited is told, and so is whoever asks next.
            for task in under_way:
                with pytest.raises(HistoryError):
                    await task
        with pytest.raises(HistoryAway, match="'east' is away"):
            await send(history, "agv", 30, 60)
        assert "agv is on 'east', which is away" in history.trouble
        said = [line for line in caplog.messages if "it has not answered for 1.5 s" in line]
        assert len(said) == 1
        # What was on its way comes late, as behind a switch that is gone.
        way.thaw()
        async with asyncio.timeout(PATIENCE_S):
            while history.trouble:
                await history.mend_servers()
        assert sum("east is there again" in line for line in caplog.messages) == 1
        # As gateways do with what was not acknowledged.
        await send(history, "agv", 30, 60)
        await send(history, "agv", 60, 80)
        await assert_whole(history, "agv", 80)
        await assert_whole(history, "near", 20)


async def test_a_hub_ends_though_a_server_stands_still(place, way) -> None:
    async with asyncio.timeout(PATIENCE_S), place.opened(still_s=STILL_S) as (history, _):
        await send(history, "agv", 0, 30)
        way.freeze()
        waiting = asyncio.create_task(send(history, "agv", 30, 60))
        await asyncio.sleep(0)
    with pytest.raises(HistoryError):
        await waiting
    way.thaw()
    async with place.opened() as (history, _):
        await send(history, "agv", 30, 60)
        await assert_whole(history, "agv", 60)


async def test_a_server_that_lets_nobody_in_is_away_at_the_start(place, way) -> None:
    way.freeze()
    async with asyncio.timeout(PATIENCE_S), place.opened(still_s=STILL_S) as (history, homes):
        await homes.add_home("near", OWN)
        await send(history, "near", 0, 20)
        with pytest.raises(HistoryAway):
            await send(history, "agv", 0, 10)
