"""The archive of pictures: one row for each FITS file, found by night, target, filter, place."""

from __future__ import annotations

import sqlalchemy as sa
from alembic import op

from talaia.hub.store.migrations import steps

revision = "0015"
down_revision = "0011"
branch_labels = None
depends_on = None


def upgrade() -> None:
    steps.create_table(
        "frames",
        sa.Column("id", steps.ID, primary_key=True),
        sa.Column("site", steps.NAME, nullable=False),
        sa.Column("device", steps.NAME, nullable=False),
        sa.Column("night", sa.String(10), nullable=False),
        sa.Column("name", steps.NAME, nullable=False),
        sa.Column("time_us", steps.BIG, nullable=False),
        sa.Column("target", steps.NAME, nullable=False),
        sa.Column("target_key", sa.String(400), nullable=False),
        sa.Column("filter", steps.NAME, nullable=False),
        sa.Column("kind", steps.NAME, nullable=False),
        sa.Column("exposure_s", sa.Double, nullable=True),
        sa.Column("ra_deg", sa.Double, nullable=True),
        sa.Column("dec_deg", sa.Double, nullable=True),
        sa.Column("width", sa.Integer, nullable=False),
        sa.Column("height", sa.Integer, nullable=False),
        sa.Column("bytes", steps.BIG, nullable=False),
        sa.Column("digest", steps.HASH, nullable=False),
        sa.Column("problems", sa.Text, nullable=False),
        sa.UniqueConstraint("site", "digest", name="uq_frames_site"),
    )
    steps.create_index("ix_frames_site_time_us", "frames", ["site", "time_us"])
    steps.create_index("ix_frames_site_night", "frames", ["site", "night"])


def downgrade() -> None:
    op.drop_table("frames")
