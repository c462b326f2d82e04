"""How each server says who leads: a lock of a session, and what is known of that session.

Where sites are divided, each shard has a lock of its own; words of the main one stay as they are,
so that a hub of before, and one that does not divide, keeps out and is kept out.
"""

from __future__ import annotations

import hashlib
from typing import TYPE_CHECKING, NamedTuple

if TYPE_CHECKING:
    from collections.abc import Callable, Mapping

__all__ = ["MAIN_SHARD", "MARIADB_LEAD", "POSTGRESQL_LEAD", "LeadWords"]

# The shard that has the accounts; a hub that does not divide is its lead.
MAIN_SHARD = "main"


class LeadWords(NamedTuple):
    """Statements of one shard's lead; each gives one number, or rows of one.

    Attributes:
        take: 1 if this session has the lock now.
        give_back: lets another session have it.
        own: this session's number.
        holder: the session that has the lock; none: nobody has.
        silent: for how long a session (``:session``) has asked nothing (s).
        end: ends a session.
        others: other sessions of hubs that lead this shard or have led it, on this database.
        mark: says of this session that it is such a one.
        apart: says of a session that only looks who leads that it is none of the main shard's;
            empty: nobody would take it for one.
        bounds: the driver's arguments by which a server that is gone is not waited for (s).
        divide: gives the words of a shard, by its name, where sites are divided.

    """

    take: str
    give_back: str
    own: str
    holder: str
    silent: str
    end: str
    others: str
    mark: str
    apart: str
    bounds: Mapping[str, int]
    divide: Callable[[str], LeadWords]


# A statement about the lock takes no time; after so long the way to the server is gone (s).
_BOUND_S = 5
# "tala" and "lead": the two halves of our lock's number; the other lock is of one number.
_TALA, _LEAD = 0x74616C61, 0x6C656164


def _postgresql_words(shard: str) -> LeadWords:
    is_main = shard == MAIN_SHARD
    number = _LEAD if is_main else _number_of(shard)
    lock = f"{_TALA}, {number}"
    name = "talaia hub" if is_main else f"talaia hub {_hash_of(shard)}"
    return LeadWords(
        take=f"SELECT pg_try_advisory_lock({lock})::int",
        give_back=f"SELECT pg_advisory_unlock({lock})::int",
        own="SELECT pg_backend_pid()",
        holder=(
            "SELECT pid FROM pg_locks WHERE locktype = 'advisory' AND granted AND objsubid = 2"  # noqa: S608 - numbers of ours
            f" AND classid = {_TALA} AND objid = {number}"
            " AND database = (SELECT oid FROM pg_database WHERE datname = current_database())"
        ),
        silent=(
            "SELECT extract(epoch FROM clock_timestamp() - state_change)::float"
            " FROM pg_stat_activity WHERE pid = :session"
        ),
        end="SELECT pg_terminate_backend(:session)",
        others=(
            "SELECT pid FROM pg_stat_activity WHERE datname = current_database()"  # noqa: S608 - a name of ours
            f" AND usename = current_user AND application_name = '{name}'"
            " AND pid <> pg_backend_pid()"
        ),
        mark=f"SET application_name = '{name}'",
        apart="",
        bounds={"timeout": _BOUND_S},
        divide=_postgresql_words,
    )


# Sessions have no name there. Where sites are divided, each has locks that say what it is: a lock's
# name is the whole server's, no longer than 64 characters, and ends with the session's number.
_APART = "CONCAT('talaia apart ', MD5(DATABASE()), ' ', {session})"
_OF_SHARD = "CONCAT('talaia ', MD5(CONCAT(DATABASE(), ' {shard}')), ' ', {session})"


def _mariadb_words(shard: str, *, divided: bool = True) -> LeadWords:
    is_main = shard == MAIN_SHARD
    of_name = "DATABASE()" if is_main else f"CONCAT(DATABASE(), ' {_hash_of(shard)}')"
    name = f"CONCAT('talaia lead ', MD5({of_name}))"
    mine, theirs = "CONNECTION_ID()", "id"
    apart = _APART.format(session=mine)
    marked = {"shard": _hash_of(shard)}
    mark = "DO 0"
    # All that this user has open on this database: nothing says more of the main shard's sessions,
    # for a hub of before it was divided may be the one that stands still.
    ended = f" AND IS_USED_LOCK({_APART.format(session=theirs)}) IS NULL" if divided else ""
    if not is_main:
        mark = f"DO GET_LOCK({apart}, 0), GET_LOCK({_OF_SHARD.format(session=mine, **marked)}, 0)"
        ended = f" AND IS_USED_LOCK({_OF_SHARD.format(session=theirs, **marked)}) = id"
    return LeadWords(
        take=f"SELECT GET_LOCK({name}, 0)",
        give_back=f"SELECT RELEASE_LOCK({name})",
        own="SELECT CONNECTION_ID()",
        holder=f"SELECT IS_USED_LOCK({name})",
        silent="SELECT time FROM information_schema.processlist WHERE id = :session",
        end="KILL :session",
        others=(
            "SELECT id FROM information_schema.processlist WHERE db = DATABASE()"  # noqa: S608 - words of ours
            f" AND user = SUBSTRING_INDEX(USER(), '@', 1) AND id <> CONNECTION_ID(){ended}"
        ),
        mark=mark,
        apart=f"DO GET_LOCK({apart}, 0)" if divided else "",
        bounds={"read_timeout": _BOUND_S, "write_timeout": _BOUND_S},
        divide=_mariadb_words,
    )


def _hash_of(shard: str) -> str:
    """Give what stands for a shard in words: whatever it is called, it ends no text."""
    return hashlib.sha256(shard.encode()).hexdigest()[:16]


def _number_of(shard: str) -> int:
    """Give a lock's second number: positive, so that it is listed as it is taken."""
    return int.from_bytes(hashlib.sha256(shard.encode()).digest()[:4]) & 0x7FFFFFFF


# Of sites that are not divided.
POSTGRESQL_LEAD = _postgresql_words(MAIN_SHARD)
MARIADB_LEAD = _mariadb_words(MAIN_SHARD, divided=False)
