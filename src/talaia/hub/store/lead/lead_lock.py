"""Which of several hubs on one database leads: the one whose session has the database's own lock.

Where sites are divided, each shard has a lock, and a hub may have several.

The lock and what it protects are in one place, so no split of a network gives two leads: a hub
that the database does not hear cannot write to it, and one that it hears either has the lock or
has not. Whoever takes it over first ends the sessions of the one before, and each connection of a
hub that leads begins by looking whether it still does; so nothing of a former lead is written
after the change, however long that hub stood still.
"""

from __future__ import annotations

import contextlib
import logging
import threading
import time
from typing import TYPE_CHECKING, Any

from sqlalchemy import create_engine, text
from sqlalchemy.exc import OperationalError, SQLAlchemyError

from talaia.hub.errors import CannotStart
from talaia.hub.store.database_url import parse_database_url, say_at_connect
from talaia.hub.store.dialects.lead_words import MAIN_SHARD
from talaia.hub.store.lead.hub_plan import PlanCheck

if TYPE_CHECKING:
    from collections.abc import Callable, Collection

    from sqlalchemy import Connection
    from sqlalchemy.engine.interfaces import DBAPIConnection

    from talaia.hub.store.database_url import OnConnect
    from talaia.hub.store.dialects.lead_words import LeadWords

__all__ = ["LeadLock", "mark_apart"]

_LOG = logging.getLogger(__name__)
# Between two looks of a hub that waits (s).
LOOK_S = 0.25
# One that leads only shows that it lives, and loses nothing by asking less often (s).
_LEADING_LOOK_S = 0.5
# A hub that waits asks how long the lead has been silent at each so many of its looks.
_SILENCE_LOOKS = 2
# A lead that has asked nothing for so long stands still, or is cut off from the database (s).
SILENT_S = 3.0
# Sessions that were ended are waited for so long (s).
_ENDING_S = 3.0
_FAILURES = (SQLAlchemyError, OSError)


def mark_apart(url: str) -> OnConnect:
    """Give a listener for ``connect`` by which connections are no lead's: none ends with one.

    Raises:
        StoreError: the URL cannot be read.

    """
    words = parse_database_url(url).dialect.lead
    return say_at_connect(words.divide(MAIN_SHARD).apart if words else "")


class LeadLock:
    """Tries for the lock, and holds it, in a thread of its own: a busy event loop loses nothing.

    Attributes:
        answered_ms: how long the database took to answer last; 0 while it does not.
        tried: set once the lock was tried for, whatever came of it.

    """

    def __init__(
        self,
        url: str,
        *,
        taken: Callable[[], None],
        lost: Callable[[], None],
        look_s: float = LOOK_S,
        shard: str = MAIN_SHARD,
        shards: Collection[str] = (),
        may_take: Callable[[], bool] | None = None,
        any_plan: bool = False,
    ) -> None:
        """Call ``taken`` when this hub has the lock, and ``lost`` when another one has had it.

        Both are called in the thread, each once at most.

        Args:
            url: of the accounts' database.
            taken: see above.
            lost: see above.
            look_s: between two looks.
            shard: whose lock it is.
            shards: into which sites are divided, besides the main one; none: they are not.
            may_take: asked in the thread at each look of a hub that has not led yet: while it says
                no, nothing is tried; none: it always may.
            any_plan: it is taken however hubs divide the sites, by a command that takes all.

        Raises:
            CannotStart: the database is no server.
            StoreError: the URL cannot be read, or its driver is missing.

        """
        reach = parse_database_url(url, blocking=True)
        words = reach.dialect.lead
        if words is None:
            raise CannotStart(
                "--cluster needs a database that several hubs can use",
                "set TALAIA_DATABASE_URL to one of PostgreSQL or MariaDB",
            )
        self._words: LeadWords = words.divide(shard) if shards else words
        self._shard, self._plan = shard, PlanCheck(words, shard=shard, shards=shards)
        self._may_take, self._any_plan = may_take, any_plan
        try:
            self._engine = create_engine(
                reach.url,
                connect_args={**reach.arguments, **words.bounds},
                isolation_level="AUTOCOMMIT",
                pool_size=1,
                max_overflow=0,
            )
        except ImportError as error:
            raise reach.missing_driver(error) from error
        self._taken, self._lost, self._look_s = taken, lost, look_s
        self.answered_ms = 0.0
        # The session that has the lock; none: this hub has not.
        self._session: int | None = None
        self._led = False
        # The lead's number that this hub claimed; 0 before it has.
        self._epoch = 0
        self._connection: Connection | None = None
        self._stopping = threading.Event()
        # Set once it was tried, whatever came of it.
        self.tried = threading.Event()
        # Another hub had it when this one looked first: it is a take-over.
        self._waited = False
        self._waiting_looks = 0
        # It may not take it yet, as ``may_take`` says; and the sites are divided as here, as far as
        # was seen.
        self._holds_back = self._fitted = False
        self._thread = threading.Thread(target=self._run, name="lead-lock", daemon=True)

    @property
    def held(self) -> bool:
        """Whether this hub has the lock, as far as it knows."""
        return self._session is not None

    def start_looking(self) -> None:
        """Begin to try."""
        self._thread.start()

    def stop_looking(self) -> None:
        """Give the lock back and end; blocks for a moment."""
        self._stopping.set()
        if self._thread.is_alive():
            self._thread.join(timeout=5.0)

    def remember_epoch(self, epoch: int) -> None:
        """Remember the number under which this hub leads: it tells whether another did since."""
        self._epoch = epoch

    def check_connection(self, connection: DBAPIConnection, _record: object) -> None:
        """Let a new connection write only if this hub leads; a listener for ``connect``.

        Raises:
            OperationalError: it does not.

        """
        session = self._session
        cursor = connection.cursor()
        try:
            cursor.execute(self._words.mark)
            cursor.execute(self._words.holder)
            found = cursor.fetchone()
        finally:
            cursor.close()
        connection.commit()
        if session is None or not found or found[0] != session:
            said = "this hub does not lead any more"
            raise OperationalError(self._words.holder, None, ConnectionError(said))

    def _run(self) -> None:
        while True:
            began = time.monotonic()
            try:
                self._try_lock()
            except _FAILURES as error:
                self._fail(error)
            else:
                self.answered_ms = round((time.monotonic() - began) * 1000, 2)
            self.tried.set()
            seldom = self.held or self._holds_back
            pause_s = max(self._look_s, _LEADING_LOOK_S) if seldom else self._look_s
            if self._stopping.wait(pause_s):
                break
        with contextlib.suppress(*_FAILURES):
            self._close()
        self._engine.dispose()

    def _try_lock(self) -> None:
        if self._connection is None:
            self._connection = self._engine.connect()
            if self._words.apart:
                self._ask(self._words.apart)
        if self._session is not None:
            # The server sees by it that this hub lives.
            self._ask(self._words.own)
            return
        if not self._led and not self._may_begin():
            # Another may have it meanwhile, and be gone again.
            self._waited = True
            return
        if not self._ask(self._words.take):
            self._watch_holder()
            return
        # Looked at once more: now nobody else can write down another.
        if not self._led and not self._fits_plan():
            self._ask(self._words.give_back)
            self._waited = True
            return
        session = int(self._ask(self._words.own) or 0)
        if self._waited:
            self._end_others()
        if not self._led:
            self._session, self._led = session, True
            self._taken()
        # Of a hub that is alone no epoch is known: while the lock was gone, none other had it.
        elif not self._epoch or self._ask_epoch() == self._epoch:
            # Nobody has led meanwhile: what is in memory still fits the database.
            self._session = session
            _LOG.warning("this hub leads on: the database is there again")
        else:
            self._give_up()

    def _may_begin(self) -> bool:
        self._holds_back = self._may_take is not None and not self._may_take()
        if self._holds_back:
            # How long the database takes is told all the same.
            self._ask(self._words.own)
            return False
        # Once it did, it is looked at again with the lock: at each look it would cost as much.
        return not self._plan.is_divided or self._fitted or self._fits_plan()

    def _fits_plan(self) -> bool:
        self._fitted = self._any_plan or self._plan.fits(self._ask)
        return self._fitted

    def _watch_holder(self) -> None:
        self._waited = True
        if self._led:
            self._give_up()
            return
        self._waiting_looks += 1
        if self._waiting_looks % _SILENCE_LOOKS:
            return
        holder = self._ask(self._words.holder)
        silent = None if holder is None else self._ask(self._words.silent, int(holder))
        if silent is not None and float(silent) > SILENT_S:
            _LOG.warning("the hub that leads has been silent for %.1f s; it is replaced", silent)
            self._ask(self._words.end, int(holder))

    def _end_others(self) -> None:
        """End what the lead of before has open, and wait until it is over."""
        until = time.monotonic() + _ENDING_S
        while time.monotonic() < until:
            found = self._connection.execute(text(self._words.others)) if self._connection else ()
            others = [int(row[0]) for row in found]
            if not others:
                return
            for session in others:
                # It may have gone by itself meanwhile.
                with contextlib.suppress(SQLAlchemyError):
                    self._ask(self._words.end, session)
            self._stopping.wait(0.02)

    def _ask_epoch(self) -> int:
        words = "SELECT epoch FROM hub_lead WHERE shard = :shard"
        return int(self._ask(words, shard=self._shard) or 0)

    def _ask(self, words: str, session: int | None = None, **more: str) -> Any:  # noqa: ANN401 - a driver's
        if self._connection is None:
            return None
        asked = more if session is None else {"session": session}
        result = self._connection.execute(text(words), asked)
        return result.scalar() if result.returns_rows else None

    def _give_up(self) -> None:
        self._session = None
        self._stopping.set()
        _LOG.error("another hub leads now")
        self._lost()

    def _fail(self, error: Exception) -> None:
        if self.answered_ms:
            reason = getattr(error, "orig", None) or error
            _LOG.warning("the database does not say who leads: %s; trying again", reason)
        self.answered_ms = 0.0
        # The lock was the session's: whether another hub has it now is found out by asking.
        self._session = None
        with contextlib.suppress(*_FAILURES):
            self._close()

    def _close(self) -> None:
        connection, self._connection = self._connection, None
        self._session = None
        if connection is not None:
            # Closed for good, and not put back: with the session goes the lock.
            connection.invalidate()
            connection.close()
