"""Many who ask at once share a query, and none is answered by one that began before they asked."""

import asyncio

import pytest

from talaia.hub.store.sites.shared_lookup import SharedLookup


class Keys:
    """What is there, and what was asked; each query waits for its turn to end."""

    def __init__(self) -> None:  # noqa: D107
        self.there = {"a": 1, "b": 2}
        self.asked = []
        self.turns = asyncio.Semaphore(0)
        self.fails = False

    async def fetch(self, keys):
        self.asked.append(sorted(keys))
        found = {key: self.there[key] for key in keys if key in self.there}
        await self.turns.acquire()
        if self.fails:
            raise ConnectionError("away")
        return found


async def ask(lookup, *keys) -> list[asyncio.Task]:
    tasks = [asyncio.create_task(lookup.look_up(key)) for key in keys]
    # Once for the tasks, once for the one that asks.
    for _ in range(2):
        await asyncio.sleep(0)
    return tasks


async def test_all_that_come_within_a_query_share_the_next_one() -> None:
    keys = Keys()
    lookup = SharedLookup(keys.fetch)
    first = await ask(lookup, "a")
    # Revoked while the first query is under way.
    del keys.there["a"]
    more = await ask(lookup, "a", "b", "b", "c")
    keys.turns.release()
    keys.turns.release()
    assert await asyncio.gather(*first) == [1]
    assert await asyncio.gather(*more) == [None, 2, 2, None]
    assert keys.asked == [["a"], ["a", "b", "c"]]


async def test_a_query_that_fails_fails_for_those_of_it_alone() -> None:
    keys = Keys()
    lookup = SharedLookup(keys.fetch)
    keys.fails = True
    failed = await ask(lookup, "a", "b")
    # One of them does not wait for it.
    failed.pop().cancel()
    keys.turns.release()
    with pytest.raises(ConnectionError):
        await failed[0]
    keys.fails = False
    keys.turns.release()
    assert await lookup.look_up("b") == 2
