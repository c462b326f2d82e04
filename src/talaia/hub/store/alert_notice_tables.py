"""The tables of notices of transients, of rules over these, and of what became of each.

Times are microseconds since the epoch (UTC).
"""

from __future__ import annotations

from sqlalchemy import (
    BigInteger,
    Column,
    ForeignKey,
    ForeignKeyConstraint,
    Index,
    String,
    Table,
    UniqueConstraint,
)

from talaia.hub.store.dialects.column_types import LONG_TEXT, ROW_ID
from talaia.hub.store.tables import metadata

__all__ = ["alert_notices", "alert_outcomes", "alert_rules"]

_NAME = 200
_ID = 64
_HASH = 64

alert_rules = Table(
    "alert_rules",
    metadata,
    Column("id", ROW_ID, primary_key=True),
    Column("site", String(_NAME), nullable=False),
    Column("proposal", String(_ID), nullable=False),
    # In whose name it asks; it asks for nothing more when the account goes.
    Column("user_id", ROW_ID, nullable=False),
    # JSON: `talaia.hub.observing.alert_rules.AlertRule`.
    Column("definition", LONG_TEXT, nullable=False),
    Column("changed_us", BigInteger, nullable=False),
    ForeignKeyConstraint(
        ["site", "proposal"],
        ["proposals.site", "proposals.proposal"],
        ondelete="CASCADE",
        name="fk_alert_rules_site",
    ),
    Index("ix_alert_rules_site_proposal", "site", "proposal"),
)

alert_notices = Table(
    "alert_notices",
    metadata,
    Column("id", ROW_ID, primary_key=True),
    Column("site", String(_NAME), nullable=False),
    # Who brought it; 0: the hub found it in its folder.
    Column("user_id", ROW_ID, nullable=False),
    # Hashes of its id (an IVORN) and of its event, which may be longer than an index takes.
    Column("notice_key", String(_HASH), nullable=False),
    Column("event_key", String(_HASH), nullable=False),
    Column("received_us", BigInteger, nullable=False),
    # When all rules were asked; 0: not yet.
    Column("handled_us", BigInteger, nullable=False),
    # JSON: `talaia.wire.alerts.notice.AlertNotice`.
    Column("definition", LONG_TEXT, nullable=False),
    UniqueConstraint("site", "user_id", "notice_key", name="uq_alert_notices_site"),
    Index("ix_alert_notices_site_event_key", "site", "event_key"),
)

# Requests that were made of notices: of each event one by each rule.
alert_outcomes = Table(
    "alert_outcomes",
    metadata,
    Column("rule_id", ROW_ID, primary_key=True),
    Column("event_key", String(_HASH), primary_key=True),
    Column(
        "notice_id",
        ROW_ID,
        ForeignKey("alert_notices.id", ondelete="CASCADE", name="fk_alert_outcomes_notice_id"),
        nullable=False,
        index=True,
    ),
    # No foreign key: a draft that is removed takes nothing with it.
    Column("group_id", ROW_ID, nullable=False),
)
