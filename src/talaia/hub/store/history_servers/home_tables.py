"""The tables of where histories are, and of who writes them."""

from __future__ import annotations

from sqlalchemy import BigInteger, Column, Integer, String, Table

from talaia.hub.store.dialects.column_types import EXACT_NAME, UNICODE_TEXT
from talaia.hub.store.tables import metadata

__all__ = ["NOBODY", "OWN", "history_homes", "history_owner", "history_term"]

# The name of the hub's own database among the servers.
OWN = "own"
# In the place of a server's name: the lead of before has let go of a site, and the new one is yet
# to take it. No server has this name.
NOBODY = "-"
_SERVER = String(40)

# Beside the accounts: which server has a site's history. A site without a row has it here, too.
# While it moves, `moving_to` says where, and `move` tells this move from any other; what is left
# behind at `erase_at` is still to be erased. `hold` is what the leads of two shards say to each
# other about its last moment. After that, `led_by` names the server whose shard leads the site
# until it lets go; empty: the shard of `server` does. `turn` rises over all rows whenever one
# changes its server. The rest is for who looks.
history_homes = Table(
    "history_homes",
    metadata,
    Column("site", EXACT_NAME, primary_key=True),
    Column("server", _SERVER, nullable=False),
    Column("moving_to", _SERVER, nullable=False),
    Column("move", String(32), nullable=False),
    Column("erase_at", _SERVER, nullable=False),
    Column("done_blocks", BigInteger, nullable=False),
    Column("all_blocks", BigInteger, nullable=False),
    Column("problem", UNICODE_TEXT, nullable=False),
    Column("hold", String(40), nullable=False, server_default=""),
    Column("led_by", _SERVER, nullable=False, server_default=""),
    Column("turn", BigInteger, nullable=False, server_default="0"),
)

# Beside the accounts, one row: which hub this is, and the highest term under which one has written
# histories on other servers.
history_term = Table(
    "history_term",
    metadata,
    # Always 1.
    Column("id", Integer, primary_key=True, autoincrement=False),
    Column("hub", String(32), nullable=False),
    Column("term", BigInteger, nullable=False),
)

# On each such server, one row: whose it is, by which name that hub knows it, and under which term
# is written. Each transaction that writes there looks first, and holds the row to its end.
history_owner = Table(
    "history_owner",
    metadata,
    # Always 1.
    Column("id", Integer, primary_key=True, autoincrement=False),
    Column("hub", String(32), nullable=False),
    Column("server", _SERVER, nullable=False),
    Column("term", BigInteger, nullable=False),
)
