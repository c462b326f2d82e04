"""A site changes its shard while hubs run: the words of both leads, and who leads it meanwhile."""

from __future__ import annotations

import sqlalchemy as sa
from alembic import op

from talaia.hub.store.migrations import steps

revision = "0047"
down_revision = "0046"
branch_labels = None
depends_on = None

_NEW = (
    ("hold", sa.String(40), ""),
    ("led_by", sa.String(40), ""),
    ("turn", sa.BigInteger(), "0"),
)


def upgrade() -> None:
    for name, kind, default in _NEW:
        column = sa.Column(name, kind, nullable=False, server_default=default)
        steps.add_column("history_homes", column)


def downgrade() -> None:
    for name, _, _ in _NEW:
        op.drop_column("history_homes", name)
