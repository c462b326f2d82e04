"""Alarms, what has happened to them, and who is told by which way."""

from __future__ import annotations

import sqlalchemy as sa
from alembic import op

from talaia.hub.store.migrations import steps
from talaia.hub.store.migrations.steps import BIG, HASH, ID, LONG, NAME

revision = "0017"
down_revision = "0016"
branch_labels = None
depends_on = None

_ALARM = sa.String(64)
_WORD = sa.String(16)
_SENTENCE = sa.String(2000)


def upgrade() -> None:
    steps.create_table(
        "alarm_definitions",
        sa.Column("site", NAME, nullable=False),
        sa.Column("alarm", _ALARM, nullable=False),
        sa.Column("definition", LONG, nullable=False),
        sa.Column("who", NAME, nullable=False),
        sa.Column("changed_us", BIG, nullable=False),
        sa.PrimaryKeyConstraint("site", "alarm", name="pk_alarm_definitions"),
    )
    steps.create_table(
        "alarm_states",
        sa.Column("site", NAME, nullable=False),
        sa.Column("alarm", _ALARM, nullable=False),
        sa.Column("phase", _WORD, nullable=False),
        sa.Column("episode", BIG, nullable=False),
        sa.Column("why", _SENTENCE, nullable=False),
        sa.Column("raised_us", BIG, nullable=False),
        sa.Column("cleared_us", BIG, nullable=False),
        sa.Column("acked_us", BIG, nullable=False),
        sa.Column("acked_by", NAME, nullable=False),
        sa.Column("assigned", NAME, nullable=False),
        sa.Column("shelved_until_us", BIG, nullable=False),
        sa.Column("shelved_by", NAME, nullable=False),
        sa.Column("shelved_why", _SENTENCE, nullable=False),
        sa.PrimaryKeyConstraint("site", "alarm", name="pk_alarm_states"),
    )
    steps.create_table(
        "alarm_history",
        sa.Column("id", ID, primary_key=True),
        sa.Column("site", NAME, nullable=False),
        sa.Column("alarm", _ALARM, nullable=False),
        sa.Column("episode", BIG, nullable=False),
        sa.Column("what", _WORD, nullable=False),
        sa.Column("time_us", BIG, nullable=False),
        sa.Column("who", NAME, nullable=False),
        sa.Column("message", _SENTENCE, nullable=False),
    )
    steps.create_index("ix_alarm_history_site_alarm", "alarm_history", ["site", "alarm"])
    _ways()
    _notices()


def _ways() -> None:
    steps.create_table(
        "notify_ways",
        sa.Column("id", ID, primary_key=True),
        sa.Column("name", NAME, nullable=False),
        sa.Column("kind", _WORD, nullable=False),
        sa.Column("settings", LONG, nullable=False),
        sa.Column("sealed", LONG, nullable=False),
        sa.Column("changed_us", BIG, nullable=False),
        sa.UniqueConstraint("name", name="uq_notify_ways_name"),
    )
    steps.create_table(
        "notify_rules",
        sa.Column("id", ID, primary_key=True),
        sa.Column("user_id", ID, nullable=False),
        sa.Column("site", NAME, nullable=False),
        sa.Column("way", ID, nullable=False),
        sa.Column("target", NAME, nullable=False),
        sa.Column("least", _WORD, nullable=False),
        sa.Column("over", sa.Boolean, nullable=False),
        sa.Column("quiet_from", sa.Integer, nullable=False),
        sa.Column("quiet_to", sa.Integer, nullable=False),
        sa.Column("quiet_least", _WORD, nullable=False),
        sa.Column("zone", sa.String(64), nullable=False),
        sa.Column("group_s", sa.Integer, nullable=False),
        sa.ForeignKeyConstraint(
            ["user_id"], ["users.id"], name="fk_notify_rules_user_id", ondelete="CASCADE"
        ),
        sa.ForeignKeyConstraint(
            ["way"], ["notify_ways.id"], name="fk_notify_rules_way", ondelete="CASCADE"
        ),
    )
    steps.create_index("ix_notify_rules_user_id", "notify_rules", ["user_id"])
    steps.create_index("ix_notify_rules_way", "notify_rules", ["way"])
    steps.create_table(
        "push_browsers",
        sa.Column("id", ID, primary_key=True),
        sa.Column("user_id", ID, nullable=False),
        sa.Column("endpoint_hash", HASH, nullable=False),
        sa.Column("sealed", LONG, nullable=False),
        sa.Column("agent", NAME, nullable=False),
        sa.Column("created_us", BIG, nullable=False),
        sa.UniqueConstraint("endpoint_hash", name="uq_push_browsers_endpoint_hash"),
        sa.ForeignKeyConstraint(
            ["user_id"], ["users.id"], name="fk_push_browsers_user_id", ondelete="CASCADE"
        ),
    )
    steps.create_index("ix_push_browsers_user_id", "push_browsers", ["user_id"])


def _notices() -> None:
    steps.create_table(
        "notices",
        sa.Column("id", ID, primary_key=True),
        sa.Column("happened", ID, nullable=False),
        sa.Column("rule", ID, nullable=False),
        sa.Column("user_id", ID, nullable=False),
        sa.Column("way", ID, nullable=False),
        sa.Column("site", NAME, nullable=False),
        sa.Column("alarm", _ALARM, nullable=False),
        sa.Column("device", NAME, nullable=False),
        sa.Column("episode", BIG, nullable=False),
        sa.Column("what", _WORD, nullable=False),
        sa.Column("severity", _WORD, nullable=False),
        sa.Column("title", NAME, nullable=False),
        sa.Column("text", LONG, nullable=False),
        sa.Column("time_us", BIG, nullable=False),
        sa.Column("state", _WORD, nullable=False),
        sa.Column("parcel", sa.String(32), nullable=False),
        sa.Column("tries", sa.Integer, nullable=False),
        sa.Column("due_us", BIG, nullable=False),
        sa.Column("done_us", BIG, nullable=False),
        sa.Column("problem", _SENTENCE, nullable=False),
        sa.UniqueConstraint("happened", "rule", name="uq_notices_happened"),
    )
    steps.create_index("ix_notices_state", "notices", ["state"])
    steps.create_index("ix_notices_site_alarm", "notices", ["site", "alarm"])


def downgrade() -> None:
    for table in (
        "notices",
        "push_browsers",
        "notify_rules",
        "notify_ways",
        "alarm_history",
        "alarm_states",
        "alarm_definitions",
    ):
        op.drop_table(table)
