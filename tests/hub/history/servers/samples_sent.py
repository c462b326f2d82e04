"""Samples as a gateway sends them, and whether they are all there."""

import asyncio

from talaia.hub.store.history_servers.home_tables import OWN

from ..samples import ALL, batch, rows_of, wanted

ADDRESSES = ["base/x", "base/word"]


def rows_between(first, past):
    """Give samples with sequence numbers from ``first`` on; each fifth is a text."""
    return [
        (1, 10**15 + number, f"w{number}") if number % 5 == 0 else (0, 10**15 + number, number / 7)
        for number in range(first, past)
    ]


async def send(history, site, first, past, boot="b"):
    """Send samples, as a gateway does."""
    await history.append_samples(
        site, boot, first, addresses=ADDRESSES, columns=batch(rows_between(first, past))
    )


async def assert_whole(history, site, past):
    """See that each sample up to ``past`` is there once, and that no more is asked for."""
    series = await history.read_series(site, ADDRESSES, *ALL, width=10_000)
    for channel, found in enumerate(series):
        assert rows_of(found) == wanted(rows_between(0, past), channel)
    assert await history.stored_below(site, "b") == past


async def move_while_sending(history, homes, servers, first):
    """Move a site to one server after the other while it sends from ``first`` on; up to where."""
    sent, ended = first, asyncio.Event()

    async def keep_sending() -> None:
        nonlocal sent
        while not ended.is_set():
            await send(history, "agv", sent, sent + 7)
            sent += 7

    sending = asyncio.create_task(keep_sending())
    for server in servers:
        await homes.ask_move("agv", server, own=OWN)
        await history.move_sites()
        assert (await homes.find_home("agv")).server == server
    ended.set()
    await sending
    return sent
