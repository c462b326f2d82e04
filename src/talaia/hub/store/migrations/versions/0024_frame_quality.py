"""How good each picture is, where it was solved, and whether the owner's hook has had it."""

from __future__ import annotations

import sqlalchemy as sa
from alembic import op

from talaia.hub.store.migrations import steps

revision = "0024"
down_revision = "0023"
branch_labels = None
depends_on = None

_COLUMNS = ("measured", "hook", "stars", "fwhm", "background", "zero_point", "wcs", "measure_note")


def upgrade() -> None:
    # What was kept before is neither measured nor handed over: the archive of years would be.
    for name, default in (("measured", "2"), ("hook", "0")):
        steps.add_column(
            "frames", sa.Column(name, sa.Integer, nullable=False, server_default=default)
        )
    steps.add_column("frames", sa.Column("stars", sa.Integer, nullable=True))
    for name in ("fwhm", "background", "zero_point"):
        steps.add_column("frames", sa.Column(name, sa.Double, nullable=True))
    steps.add_column("frames", sa.Column("wcs", sa.String(400), nullable=False, server_default=""))
    steps.add_column(
        "frames", sa.Column("measure_note", sa.String(400), nullable=False, server_default="")
    )
    steps.create_index("ix_frames_measured", "frames", ["measured", "id"])
    steps.create_index("ix_frames_hook", "frames", ["hook", "id"])


def downgrade() -> None:
    for index in ("ix_frames_measured", "ix_frames_hook"):
        op.drop_index(index, "frames")
    for name in _COLUMNS:
        op.drop_column("frames", name)
