"""What a thing did that a camera has seen: its path, zones, lines and speed."""

from __future__ import annotations

import sqlalchemy as sa
from alembic import op

from talaia.hub.store.migrations import steps

revision = "0037"
down_revision = "0036"
branch_labels = None
depends_on = None


def upgrade() -> None:
    # A JSON object, or empty.
    steps.add_column(
        "sightings", sa.Column("story", sa.String(8000), nullable=False, server_default="")
    )


def downgrade() -> None:
    op.drop_column("sightings", "story")
