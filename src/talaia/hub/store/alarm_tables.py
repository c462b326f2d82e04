"""The tables of alarms and of what people are told of them.

Times are microseconds since the epoch (UTC). Secrets are sealed by a key that is not here.
"""

from __future__ import annotations

from sqlalchemy import (
    BigInteger,
    Boolean,
    Column,
    ForeignKey,
    Index,
    Integer,
    String,
    Table,
    UniqueConstraint,
    false,
)

from talaia.hub.store.dialects.column_types import LONG_TEXT, ROW_ID
from talaia.hub.store.tables import metadata

__all__ = [
    "alarm_definitions",
    "alarm_history",
    "alarm_states",
    "notices",
    "notify_rules",
    "notify_ways",
    "push_browsers",
]

_NAME = 200
_SENTENCE = 2000

# Made in the page; those of a description are not here.
alarm_definitions = Table(
    "alarm_definitions",
    metadata,
    Column("site", String(_NAME), primary_key=True),
    Column("alarm", String(64), primary_key=True),
    # JSON, in the form of the description.
    Column("definition", LONG_TEXT, nullable=False),
    Column("who", String(_NAME), nullable=False),
    Column("changed_us", BigInteger, nullable=False),
)

alarm_states = Table(
    "alarm_states",
    metadata,
    Column("site", String(_NAME), primary_key=True),
    Column("alarm", String(64), primary_key=True),
    Column("phase", String(16), nullable=False),
    Column("episode", BigInteger, nullable=False),
    Column("why", String(_SENTENCE), nullable=False),
    Column("raised_us", BigInteger, nullable=False),
    Column("cleared_us", BigInteger, nullable=False),
    Column("acked_us", BigInteger, nullable=False),
    Column("acked_by", String(_NAME), nullable=False),
    Column("assigned", String(_NAME), nullable=False),
    Column("shelved_until_us", BigInteger, nullable=False),
    Column("shelved_by", String(_NAME), nullable=False),
    Column("shelved_why", String(_SENTENCE), nullable=False),
)

alarm_history = Table(
    "alarm_history",
    metadata,
    Column("id", ROW_ID, primary_key=True),
    Column("site", String(_NAME), nullable=False),
    Column("alarm", String(64), nullable=False),
    Column("episode", BigInteger, nullable=False),
    Column("what", String(16), nullable=False),
    Column("time_us", BigInteger, nullable=False),
    Column("who", String(_NAME), nullable=False),
    Column("message", String(_SENTENCE), nullable=False),
    Index("ix_alarm_history_site_alarm", "site", "alarm"),
)

notify_ways = Table(
    "notify_ways",
    metadata,
    Column("id", ROW_ID, primary_key=True),
    Column("name", String(_NAME), nullable=False, unique=True),
    Column("kind", String(16), nullable=False),
    # JSON: what may be read again.
    Column("settings", LONG_TEXT, nullable=False),
    # JSON, sealed: what is never given back. Empty: there is none.
    Column("sealed", LONG_TEXT, nullable=False),
    Column("changed_us", BigInteger, nullable=False),
)

notify_rules = Table(
    "notify_rules",
    metadata,
    Column("id", ROW_ID, primary_key=True),
    Column(
        "user_id", ROW_ID, ForeignKey("users.id", ondelete="CASCADE"), nullable=False, index=True
    ),
    Column("site", String(_NAME), nullable=False),
    Column(
        "way", ROW_ID, ForeignKey("notify_ways.id", ondelete="CASCADE"), nullable=False, index=True
    ),
    Column("target", String(_NAME), nullable=False),
    Column("least", String(16), nullable=False),
    Column("over", Boolean, nullable=False),
    Column("quiet_from", Integer, nullable=False),
    Column("quiet_to", Integer, nullable=False),
    Column("quiet_least", String(16), nullable=False),
    Column("zone", String(64), nullable=False),
    Column("group_s", Integer, nullable=False),
    # Told also when a request of theirs is done, or has failed.
    Column("own_requests", Boolean, nullable=False, server_default=false()),
    # Told also how a night that runs by itself has ended, and when it needs somebody.
    Column("nights", Boolean, nullable=False, server_default=false()),
)

push_browsers = Table(
    "push_browsers",
    metadata,
    Column("id", ROW_ID, primary_key=True),
    Column(
        "user_id", ROW_ID, ForeignKey("users.id", ondelete="CASCADE"), nullable=False, index=True
    ),
    # SHA-256 of the endpoint's address; the address itself lets anyone send, so it is sealed.
    Column("endpoint_hash", String(64), nullable=False, unique=True),
    Column("sealed", LONG_TEXT, nullable=False),
    Column("agent", String(_NAME), nullable=False),
    Column("created_us", BigInteger, nullable=False),
)

# What is to be told, one row for each thing that happened and each rule that wants it.
notices = Table(
    "notices",
    metadata,
    Column("id", ROW_ID, primary_key=True),
    Column("happened", ROW_ID, nullable=False),
    # No foreign keys: what was told stays written when a rule, a way or a person goes.
    Column("rule", ROW_ID, nullable=False),
    Column("user_id", ROW_ID, nullable=False),
    Column("way", ROW_ID, nullable=False),
    Column("site", String(_NAME), nullable=False),
    Column("alarm", String(64), nullable=False),
    Column("device", String(_NAME), nullable=False),
    Column("episode", BigInteger, nullable=False),
    Column("what", String(16), nullable=False),
    Column("severity", String(16), nullable=False),
    # What the message says of it.
    Column("title", String(_NAME), nullable=False),
    Column("text", LONG_TEXT, nullable=False),
    Column("time_us", BigInteger, nullable=False),
    Column("state", String(16), nullable=False, index=True),
    # Names the message that it is or was part of; empty until one is made.
    Column("parcel", String(32), nullable=False),
    Column("tries", Integer, nullable=False),
    Column("due_us", BigInteger, nullable=False),
    Column("done_us", BigInteger, nullable=False),
    Column("problem", String(_SENTENCE), nullable=False),
    UniqueConstraint("happened", "rule", name="uq_notices_happened"),
    Index("ix_notices_site_alarm", "site", "alarm"),
)
