"""Histories on more than one server, and numbers that are never given twice."""

from __future__ import annotations

import sqlalchemy as sa
from alembic import op

from talaia.hub.store.migrations import steps
from talaia.hub.store.migrations.steps import BIG, ID, LONG, NAME

revision = "0045"
down_revision = "0044"
branch_labels = None
depends_on = None

_SERVER = sa.String(40)
_WORD = sa.String(32)


def upgrade() -> None:
    steps.create_table(
        "history_counter",
        sa.Column("name", sa.String(20), primary_key=True),
        sa.Column("next_number", BIG, nullable=False),
    )
    steps.create_table(
        "history_copied",
        sa.Column("site", NAME, nullable=False),
        sa.Column("source_channel", ID, autoincrement=False, nullable=False),
        sa.Column("address", NAME, nullable=False),
        sa.Column("move", _WORD, nullable=False),
        sa.Column("block_id", BIG, nullable=False),
        sa.PrimaryKeyConstraint("site", "source_channel", name="pk_history_copied"),
    )
    steps.create_table(
        "history_homes",
        sa.Column("site", NAME, primary_key=True),
        sa.Column("server", _SERVER, nullable=False),
        sa.Column("moving_to", _SERVER, nullable=False),
        sa.Column("move", _WORD, nullable=False),
        sa.Column("erase_at", _SERVER, nullable=False),
        sa.Column("done_blocks", BIG, nullable=False),
        sa.Column("all_blocks", BIG, nullable=False),
        sa.Column("problem", LONG, nullable=False),
    )
    steps.create_table(
        "history_term",
        sa.Column("id", sa.Integer(), autoincrement=False, nullable=False),
        sa.Column("hub", _WORD, nullable=False),
        sa.Column("term", BIG, nullable=False),
        sa.PrimaryKeyConstraint("id", name="pk_history_term"),
    )
    steps.create_table(
        "history_owner",
        sa.Column("id", sa.Integer(), autoincrement=False, nullable=False),
        sa.Column("hub", _WORD, nullable=False),
        sa.Column("server", _SERVER, nullable=False),
        sa.Column("term", BIG, nullable=False),
        sa.PrimaryKeyConstraint("id", name="pk_history_owner"),
    )


def downgrade() -> None:
    for table in (
        "history_owner",
        "history_term",
        "history_homes",
        "history_copied",
        "history_counter",
    ):
        op.drop_table(table)
