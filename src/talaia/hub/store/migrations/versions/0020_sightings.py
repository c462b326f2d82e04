"""What cameras have seen: one row for each sighting, with a picture of a moment of it."""

from __future__ import annotations

import sqlalchemy as sa
from alembic import op
from sqlalchemy.dialects import mysql

from talaia.hub.store.migrations import steps

revision = "0020"
down_revision = "0019"
branch_labels = None
depends_on = None

_BYTES = sa.LargeBinary().with_variant(mysql.MEDIUMBLOB(), "mysql", "mariadb")


def upgrade() -> None:
    steps.create_table(
        "sightings",
        sa.Column("id", steps.ID, primary_key=True),
        sa.Column("site", steps.NAME, nullable=False),
        sa.Column("camera", steps.NAME, nullable=False),
        sa.Column("label", steps.NAME, nullable=False),
        sa.Column("began_us", steps.BIG, nullable=False),
        sa.Column("ended_us", steps.BIG, nullable=False),
        sa.Column("many", sa.Integer, nullable=False),
        sa.Column("confidence", sa.Double, nullable=False),
        sa.Column("told_us", steps.BIG, nullable=False),
        sa.Column("boot", steps.NAME, nullable=False),
        sa.Column("noted_us", steps.BIG, nullable=False),
        sa.Column("pictured", sa.Boolean, nullable=False),
        sa.Column("picture", _BYTES, nullable=True),
        sa.UniqueConstraint("site", "camera", "label", "began_us", name="uq_sightings_site"),
    )
    steps.create_index("ix_sightings_site_began_us", "sightings", ["site", "began_us"])
    steps.create_index("ix_sightings_site_noted_us", "sightings", ["site", "noted_us"])


def downgrade() -> None:
    op.drop_table("sightings")
