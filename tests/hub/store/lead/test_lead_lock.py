"""The lock by which one of several hubs leads: one has it, and nobody else writes."""

import threading

import pytest
import sqlalchemy as sa
from patience import PATIENCE_S

from talaia.hub.errors import CannotStart, StoreDown
from talaia.hub.history.engine import open_engine
from talaia.hub.store.database import Database
from talaia.hub.store.lead.lead_claim import claim_lead
from talaia.hub.store.lead.lead_lock import LeadLock

from ...databases import empty_database, make_tables


@pytest.fixture(params=["postgresql", "mariadb"])
def url(request):
    # Not a copy: whoever made it on MariaDB is still in it, and would be ended by a take-over.
    with empty_database(request.param) as url:
        make_tables(url)
        yield url


class Held:
    """A lock that is tried for, and what was said of it."""

    def __init__(self, url) -> None:
        """Prepare to try, on the database at ``url``."""
        self.taken, self.lost = threading.Event(), threading.Event()
        self.lock = LeadLock(url, taken=self.taken.set, lost=self.lost.set)

    def __enter__(self):
        self.lock.start_looking()
        return self

    def __exit__(self, *_exc) -> None:
        self.lock.stop_looking()


def test_one_has_it_and_the_next_gets_it_when_it_is_given_back(url) -> None:
    with Held(url) as first:
        assert first.taken.wait(PATIENCE_S)
        with Held(url) as second:
            assert second.lock.tried.wait(PATIENCE_S)
            assert not second.taken.is_set()
            first.lock.stop_looking()
            assert second.taken.wait(PATIENCE_S)
            assert not first.lock.held


def test_whoever_has_it_alone_may_open_connections_to_the_history(url) -> None:
    with Held(url) as holder:
        assert holder.taken.wait(PATIENCE_S)
        with Held(url) as other:
            writing = open_engine(url, writes=True, on_connect=holder.lock.check_connection)
            refused = open_engine(url, writes=True, on_connect=other.lock.check_connection)
            with writing.connect() as connection:
                assert connection.scalar(sa.text("SELECT 1")) == 1
            with pytest.raises(sa.exc.OperationalError, match="does not lead any more"):
                refused.connect()
            writing.dispose()
            refused.dispose()


async def test_whoever_has_it_not_may_not_open_connections_to_accounts(url) -> None:
    with Held(url) as holder:
        assert holder.taken.wait(PATIENCE_S)
        with Held(url) as other:
            database = Database(url, on_connect=other.lock.check_connection)
            with pytest.raises(StoreDown, match="does not lead any more"):
                async with database.read():
                    pass
            await database.close()


async def test_each_lead_has_a_higher_number_and_the_key_of_those_before(url) -> None:
    database = Database(url)
    assert await claim_lead(database, name="east", seal_hash="a" * 64) == 1
    assert await claim_lead(database, name="west", seal_hash="a" * 64) == 2
    with pytest.raises(CannotStart, match=r"another seal\.key"):
        await claim_lead(database, name="stranger", seal_hash="b" * 64)
    await database.close()


def test_a_file_is_no_database_of_several_hubs(tmp_path) -> None:
    with pytest.raises(CannotStart, match="a database that several hubs can use"):
        LeadLock(f"sqlite:///{tmp_path}/talaia.db", taken=print, lost=print)
