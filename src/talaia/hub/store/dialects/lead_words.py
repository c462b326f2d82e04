"""How each server says who leads: a lock of a session, and what is known of that session."""

from __future__ import annotations

from typing import TYPE_CHECKING, NamedTuple

if TYPE_CHECKING:
    from collections.abc import Mapping

__all__ = ["MARIADB_LEAD", "POSTGRESQL_LEAD", "LeadWords"]


class LeadWords(NamedTuple):
    """Statements; each gives one number, or rows of one.

    Attributes:
        take: 1 if this session has the lock now.
        own: this session's number.
        holder: the session that has the lock; none: nobody has.
        silent: for how long a session (``:session``) has asked nothing (s).
        end: ends a session.
        others: other sessions of hubs that lead or have led, on this database.
        mark: says of this session that it is such a one.
        bounds: the driver's arguments by which a server that is gone is not waited for (s).

    """

    take: str
    own: str
    holder: str
    silent: str
    end: str
    others: str
    mark: str
    bounds: Mapping[str, int]


# A statement about the lock takes no time; after so long the way to the server is gone (s).
_BOUND_S = 5
# "tala" and "lead": the two halves of our lock's number; the other lock is of one number.
_TALA, _LEAD = 0x74616C61, 0x6C656164
POSTGRESQL_LEAD = LeadWords(
    take=f"SELECT pg_try_advisory_lock({_TALA}, {_LEAD})::int",
    own="SELECT pg_backend_pid()",
    holder=(
        "SELECT pid FROM pg_locks WHERE locktype = 'advisory' AND granted AND objsubid = 2"  # noqa: S608 - numbers of ours
        f" AND classid = {_TALA} AND objid = {_LEAD}"
        " AND database = (SELECT oid FROM pg_database WHERE datname = current_database())"
    ),
    silent=(
        "SELECT extract(epoch FROM clock_timestamp() - state_change)::float"
        " FROM pg_stat_activity WHERE pid = :session"
    ),
    end="SELECT pg_terminate_backend(:session)",
    others=(
        "SELECT pid FROM pg_stat_activity WHERE datname = current_database()"
        " AND usename = current_user AND application_name = 'talaia hub'"
        " AND pid <> pg_backend_pid()"
    ),
    mark="SET application_name = 'talaia hub'",
    bounds={"timeout": _BOUND_S},
)
# A lock's name is the whole server's, and no longer than 64 characters.
_NAME = "CONCAT('talaia lead ', MD5(DATABASE()))"
MARIADB_LEAD = LeadWords(
    take=f"SELECT GET_LOCK({_NAME}, 0)",
    own="SELECT CONNECTION_ID()",
    holder=f"SELECT IS_USED_LOCK({_NAME})",
    silent="SELECT time FROM information_schema.processlist WHERE id = :session",
    end="KILL :session",
    # Its sessions have no name there: all that this user has open on this database.
    others=(
        "SELECT id FROM information_schema.processlist WHERE db = DATABASE()"
        " AND user = SUBSTRING_INDEX(USER(), '@', 1) AND id <> CONNECTION_ID()"
    ),
    mark="DO 0",
    bounds={"read_timeout": _BOUND_S, "write_timeout": _BOUND_S},
)
