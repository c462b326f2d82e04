"""The table of files that are to be removed from a store that is elsewhere.

Times are microseconds since the epoch (UTC).
"""

from __future__ import annotations

from sqlalchemy import BigInteger, Column, String, Table

from talaia.hub.store.tables import metadata

__all__ = ["MOST_KEY", "file_removals"]

# What a store of files takes at the most is 1024; ours are a site, a night and a name.
MOST_KEY = 400

file_removals = Table(
    "file_removals",
    metadata,
    Column("file_key", String(MOST_KEY), primary_key=True),
    Column("since_us", BigInteger, nullable=False),
)
