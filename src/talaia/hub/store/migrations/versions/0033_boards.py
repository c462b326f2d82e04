"""Boards that people arrange, and every version of each."""

from __future__ import annotations

import sqlalchemy as sa
from alembic import op

from talaia.hub.store.migrations import steps
from talaia.hub.store.migrations.steps import BIG, ID, LONG, NAME

revision = "0033"
down_revision = "0030"
branch_labels = None
depends_on = None


def upgrade() -> None:
    steps.create_table(
        "boards",
        sa.Column("id", ID, primary_key=True),
        sa.Column("board_key", sa.String(32), nullable=False),
        sa.Column("owner_id", ID, nullable=False),
        sa.Column("share", sa.String(16), nullable=False),
        sa.Column("role", NAME, nullable=False),
        sa.Column("name", NAME, nullable=False),
        sa.Column("site", NAME, nullable=False),
        sa.Column("kind", sa.String(32), nullable=False),
        sa.Column("number", sa.Integer, nullable=False),
        sa.Column("tiles", sa.Integer, nullable=False),
        sa.Column("changed_us", BIG, nullable=False),
        sa.ForeignKeyConstraint(
            ["owner_id"], ["users.id"], name="fk_boards_owner_id", ondelete="CASCADE"
        ),
        sa.UniqueConstraint("board_key", name="uq_boards_board_key"),
    )
    steps.create_index("ix_boards_owner_id", "boards", ["owner_id"])
    steps.create_table(
        "board_versions",
        sa.Column("board_id", ID, nullable=False),
        sa.Column("number", sa.Integer, nullable=False),
        sa.Column("time_us", BIG, nullable=False),
        sa.Column("who", NAME, nullable=False),
        sa.Column("note", NAME, nullable=False),
        sa.Column("text", LONG, nullable=False),
        sa.PrimaryKeyConstraint("board_id", "number", name="pk_board_versions"),
        sa.ForeignKeyConstraint(
            ["board_id"], ["boards.id"], name="fk_board_versions_board_id", ondelete="CASCADE"
        ),
    )


def downgrade() -> None:
    op.drop_table("board_versions")
    op.drop_table("boards")
