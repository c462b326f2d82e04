"""Films of cameras stand in the list of recordings; ``stream`` names the camera."""

from __future__ import annotations

import sqlalchemy as sa
from alembic import op

from talaia.hub.store.migrations import steps

revision = "0019"
down_revision = "0018"
branch_labels = None
depends_on = None


def upgrade() -> None:
    column = sa.Column("stream", sa.String(200), nullable=False, server_default="")
    steps.add_column("recordings", column)


def downgrade() -> None:
    op.drop_column("recordings", "stream")
