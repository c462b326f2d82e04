"""Numbers of channels, boots, lists and blocks: once one was given, no other gets it."""

import sqlalchemy as sa

from talaia.hub.store import history_tables as tables

from ..conftest import SMALL, opened
from ..samples import ALL, batch, rows_of, wanted

ROWS = [(0, 10**15 + at, at / 8) for at in range(120)]


async def store_site(store, site):
    await store.append_samples(site, "b", 0, addresses=["base/x"], columns=batch(ROWS))
    await store.transfer.seal_all(site)


def highest_numbers(url):
    engine = sa.create_engine(url)
    columns = (tables.channel.c.id, tables.boot.c.id, tables.catalogue.c.id, tables.body.c.block_id)
    with engine.begin() as connection:
        found = [connection.scalar(sa.select(sa.func.max(column))) for column in columns]
    engine.dispose()
    return found


async def test_numbers_of_an_erased_site_are_not_given_again(url) -> None:
    async with opened(url) as store:
        for site in ("first", "second", "third"):
            await store_site(store, site)
        before = highest_numbers(url)
        # One in the middle, and the one that has the highest.
        await store.transfer.erase_site("second")
        await store.transfer.erase_site("third")
        assert not store.transfer.has_site("third")
    async with opened(url) as store:
        await store_site(store, "fourth")
        (found,) = await store.read_series("first", ["base/x"], *ALL, width=1000)
        assert rows_of(found) == wanted(ROWS, 0)
        assert await store.stored_below("third", "b") == 0
    assert all(new > old for new, old in zip(highest_numbers(url), before, strict=True))


async def test_blocks_that_retention_drops_leave_their_numbers_unused(url) -> None:
    async with opened(url, SMALL._replace(bytes=1)) as store:
        await store_site(store, "first")
        before = highest_numbers(url)
        assert await store.apply_retention()
    async with opened(url) as store:
        await store_site(store, "second")
    assert highest_numbers(url)[-1] > before[-1]


async def test_a_list_that_comes_again_after_a_renaming_means_other_channels(url) -> None:
    # The very same object, as a link hands it over with each batch.
    addresses = ("base/x",)
    async with opened(url) as store:
        await store.append_samples("agv", "b", 0, addresses=addresses, columns=batch([(0, 1, 1.0)]))
        await store.rename_channels("agv", {"base/x": "base/y"})
        await store.append_samples("agv", "b", 1, addresses=addresses, columns=batch([(0, 2, 2.0)]))
        found = await store.last_readings("agv", ["base/x", "base/y"])
    assert {address: value for address, (_, value, _) in found.items()} == {
        "base/x": 2.0,
        "base/y": 1.0,
    }
