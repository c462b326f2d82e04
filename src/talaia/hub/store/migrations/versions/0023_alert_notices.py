"""Notices of transients, rules by which they become rapid requests, and what became of each."""

from __future__ import annotations

import sqlalchemy as sa

from talaia.hub.store.migrations import steps
from talaia.hub.store.migrations.steps import BIG, HASH, ID, LONG, NAME

revision = "0023"
down_revision = "0022"
branch_labels = None
depends_on = None


def upgrade() -> None:
    steps.create_table(
        "alert_rules",
        sa.Column("id", ID, primary_key=True),
        sa.Column("site", NAME, nullable=False),
        sa.Column("proposal", sa.String(64), nullable=False),
        sa.Column("user_id", ID, nullable=False),
        sa.Column("definition", LONG, nullable=False),
        sa.Column("changed_us", BIG, nullable=False),
        sa.ForeignKeyConstraint(
            ["site", "proposal"],
            ["proposals.site", "proposals.proposal"],
            name="fk_alert_rules_site",
            ondelete="CASCADE",
        ),
    )
    steps.create_index("ix_alert_rules_site_proposal", "alert_rules", ["site", "proposal"])
    steps.create_table(
        "alert_notices",
        sa.Column("id", ID, primary_key=True),
        sa.Column("site", NAME, nullable=False),
        sa.Column("user_id", ID, nullable=False),
        sa.Column("notice_key", HASH, nullable=False),
        sa.Column("event_key", HASH, nullable=False),
        sa.Column("received_us", BIG, nullable=False),
        sa.Column("handled_us", BIG, nullable=False),
        sa.Column("definition", LONG, nullable=False),
        sa.UniqueConstraint("site", "user_id", "notice_key", name="uq_alert_notices_site"),
    )
    steps.create_index("ix_alert_notices_site_event_key", "alert_notices", ["site", "event_key"])
    steps.create_table(
        "alert_outcomes",
        sa.Column("rule_id", ID, nullable=False),
        sa.Column("event_key", HASH, nullable=False),
        sa.Column("notice_id", ID, nullable=False),
        sa.Column("group_id", ID, nullable=False),
        sa.PrimaryKeyConstraint("rule_id", "event_key", name="pk_alert_outcomes"),
        sa.ForeignKeyConstraint(
            ["notice_id"],
            ["alert_notices.id"],
            name="fk_alert_outcomes_notice_id",
            ondelete="CASCADE",
        ),
    )
    steps.create_index("ix_alert_outcomes_notice_id", "alert_outcomes", ["notice_id"])
