"""Who writes on a server of histories: the hub whose term is there, and nobody else.

Each transaction that writes reads the term first, and holds its row to the end. A hub that takes
over writes a higher one; it gets its number from the accounts' database, which only the hub that
leads can write. So a hub that stood still, and does not know that another leads by now, can write
nothing from then on, however its connections stand.
"""

from __future__ import annotations

from typing import TYPE_CHECKING

from sqlalchemy import event, func, insert, inspect, select, update

from talaia.hub.history.errors import HistoryAway
from talaia.hub.store.database_url import say_at_connect
from talaia.hub.store.dialects.choice import dialect_of
from talaia.hub.store.history_servers.home_tables import history_owner, history_term
from talaia.hub.store.tables import metadata

if TYPE_CHECKING:
    from sqlalchemy import Connection, Engine

__all__ = ["WriteTerm"]

_ROW = 1


class WriteTerm:
    """The term under which this hub writes on one server.

    Attributes:
        term: 0 until it was claimed.
        lost: another hub has claimed a higher one; this hub writes nothing there any more.

    """

    def __init__(self, hub: str, server: str) -> None:
        """Write as ``hub`` on what it calls ``server``."""
        self._hub, self._server = hub, server
        self.term = 0
        self.lost = False

    def guard_engine(self, engine: Engine) -> None:
        """Let no transaction of an engine begin but under this term."""
        event.listen(engine, "begin", self._check_term)
        event.listen(engine, "connect", say_at_connect(dialect_of(engine).idle_bound))

    def read_term(self, engine: Engine) -> int:
        """Give the term that stands there; 0 on a server that nobody has claimed.

        Raises:
            HistoryAway: it is another hub's, or this hub knows it by another name.

        """
        with engine.begin() as connection:
            found = connection.execute(select(history_owner)).one_or_none()
            if found is None:
                self._check_unused(connection)
                return 0
        if found.hub != self._hub:
            raise HistoryAway(
                f"the database of {self._server!r} has histories of another hub",
                "name an empty one",
            )
        if found.server != self._server:
            raise HistoryAway(
                f"the database of {self._server!r} has been {found.server!r} until now",
                "give it that name again",
            )
        return int(found.term)

    def claim_term(self, engine: Engine, term: int) -> None:
        """Write under ``term`` from here on.

        Raises:
            HistoryAway: another hub has claimed as much.

        """
        with engine.begin() as connection:
            found = connection.execute(
                select(history_owner.c.term).with_for_update()
            ).scalar_one_or_none()
            if found is None:
                row = {"id": _ROW, "hub": self._hub, "server": self._server, "term": term}
                connection.execute(insert(history_owner), row)
            elif found >= term:
                raise HistoryAway(f"another hub has taken {self._server!r} over")
            else:
                connection.execute(update(history_owner).values(term=term))
        self.term = term

    def _check_unused(self, connection: Connection) -> None:
        # A wrong URL must not mix two hubs' histories.
        for name in ("history_channel", "users", history_term.name):
            table = metadata.tables[name]
            if inspect(connection).has_table(name) and connection.scalar(
                select(func.count()).select_from(table)
            ):
                raise HistoryAway(
                    f"the database of {self._server!r} is in use already", "name an empty one"
                )

    def _check_term(self, connection: Connection) -> None:
        found = connection.execute(select(history_owner.c.term).with_for_update()).scalar()
        if found == self.term and not self.lost:
            return
        # Ended here: whoever gets an exception from a beginning ends nothing, and the row's lock
        # would stay.
        connection.connection.rollback()
        self.lost = True
        raise HistoryAway(
            f"another hub writes the histories on {self._server!r} now",
            "end one of the two hubs, and start the other one anew",
        )
