"""Of a sensor that is no longer described it is still known what it was."""

from __future__ import annotations

import sqlalchemy as sa
from alembic import op
from sqlalchemy.dialects import mysql

from talaia.hub.store.migrations import steps

revision = "0014"
down_revision = "0010"
branch_labels = None
depends_on = None

_TEXT = sa.Text().with_variant(mysql.TEXT(charset="utf8mb4"), "mysql", "mariadb")


def upgrade() -> None:
    steps.add_column("history_sensor", sa.Column("type", sa.String(20), nullable=True))
    steps.add_column("history_sensor", sa.Column("states", _TEXT, nullable=True))
    steps.add_column("history_sensor", sa.Column("decimals", sa.Integer, nullable=True))


def downgrade() -> None:
    for column in ("type", "states", "decimals"):
        op.drop_column("history_sensor", column)
