"""Which sightings a person has looked at."""

from __future__ import annotations

import sqlalchemy as sa
from alembic import op

from talaia.hub.store.migrations import steps
from talaia.hub.store.migrations.steps import ID

revision = "0041"
down_revision = "0040"
branch_labels = None
depends_on = None


def upgrade() -> None:
    steps.create_table(
        "seen_sightings",
        sa.Column("user_id", ID, nullable=False),
        sa.Column("sighting_id", ID, nullable=False),
        sa.PrimaryKeyConstraint("user_id", "sighting_id", name="pk_seen_sightings"),
        sa.ForeignKeyConstraint(
            ["user_id"], ["users.id"], name="fk_seen_sightings_user_id", ondelete="CASCADE"
        ),
        sa.ForeignKeyConstraint(
            ["sighting_id"],
            ["sightings.id"],
            name="fk_seen_sightings_sighting_id",
            ondelete="CASCADE",
        ),
    )
    # Old sightings are deleted by the hundred; without it each would look through all marks.
    steps.create_index("ix_seen_sightings_sighting_id", "seen_sightings", ["sighting_id"])


def downgrade() -> None:
    op.drop_table("seen_sightings")
