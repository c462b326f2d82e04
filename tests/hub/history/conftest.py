"""A history to test with, on each database that is there (see `tests.hub.databases`)."""

from contextlib import asynccontextmanager

import pytest

from talaia.clock import SystemClock
from talaia.hub.history.limits import HistoryLimits
from talaia.hub.history.store import HistoryStore
from talaia.hub.store.database_url import parse_database_url

# So small that a few hundred samples go through all that a year of them goes through.
SMALL = HistoryLimits(
    block=32, largest=32, recent=16, journal=200, delete=2, raw=200, texts=300,
    linger_s=0.0, show_s=0.0,
)  # fmt: skip


@asynccontextmanager
async def opened(url, limits=SMALL):
    store = HistoryStore(url, SystemClock(), limits)
    await store.create_tables()
    await store.open()
    try:
        yield store
    finally:
        await store.close()


@pytest.fixture
def url(database_url):
    """Give the URL of an empty database with a driver for threads, on each kind that is there."""
    return parse_database_url(database_url, blocking=True).url.render_as_string(hide_password=False)
