"""What is known of each gateway, one-time codes by which one enrols, and the audit log's end."""

from __future__ import annotations

import sqlalchemy as sa
from alembic import op

from talaia.hub.store.migrations import steps
from talaia.hub.store.migrations.steps import BIG, HASH, ID, NAME

revision = "0004"
down_revision = "0003"
branch_labels = None
depends_on = None


def upgrade() -> None:
    for name in ("name", "version", "address"):
        steps.add_column("gateways", sa.Column(name, NAME, nullable=False, server_default=""))
    # 0 until its first link.
    steps.add_column("gateways", sa.Column("seen_us", BIG, nullable=False, server_default="0"))
    steps.create_table(
        "enrolment_codes",
        sa.Column("id", ID, nullable=False),
        sa.Column("site", NAME, nullable=False),
        sa.Column("name", NAME, nullable=False),
        sa.Column("code_hash", HASH, nullable=False),
        sa.Column("created_us", BIG, nullable=False),
        sa.Column("expires_us", BIG, nullable=False),
        sa.Column("used_us", BIG, nullable=False),
        sa.PrimaryKeyConstraint("id", name="pk_enrolment_codes"),
        sa.UniqueConstraint("code_hash", name="uq_enrolment_codes_code_hash"),
    )
    _audit()


def _audit() -> None:
    head = steps.create_table(
        "audit_head",
        sa.Column("id", ID, nullable=False, autoincrement=False),
        sa.Column("row_id", ID, nullable=False),
        sa.Column("hash", HASH, nullable=False),
        sa.PrimaryKeyConstraint("id", name="pk_audit_head"),
    )
    audit = sa.Table(
        "audit", sa.MetaData(), sa.Column("id", ID, primary_key=True), sa.Column("hash", HASH)
    )
    connection = op.get_bind()
    if connection.execute(sa.select(head.c.id)).first() is None:
        newest = sa.select(audit.c.id, audit.c.hash).order_by(audit.c.id.desc()).limit(1)
        last = connection.execute(newest).first()
        row_id, hashed = (last.id, last.hash) if last else (0, "")
        connection.execute(sa.insert(head).values(id=1, row_id=row_id, hash=hashed))
    for column in ("kind", "who"):
        steps.create_index(f"ix_audit_{column}", "audit", [column])
