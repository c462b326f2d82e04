"""The history: channels, journal, blocks and rollups."""

from __future__ import annotations

from typing import Any

import sqlalchemy as sa
from alembic import op
from sqlalchemy.dialects import mysql

from talaia.hub.store.migrations import steps

revision = "0002"
down_revision = "0001"
branch_labels = None
depends_on = None

_ID = sa.BigInteger().with_variant(sa.Integer, "sqlite")
_BIG = sa.BigInteger()
_NAME = sa.String(200).with_variant(
    mysql.VARCHAR(200, charset="utf8mb4", collation="utf8mb4_bin"), "mysql", "mariadb"
)
_REASON = sa.Text().with_variant(mysql.TEXT(charset="utf8mb4"), "mysql", "mariadb")
_BYTES = sa.LargeBinary().with_variant(mysql.LONGBLOB(), "mysql", "mariadb")


def upgrade() -> None:
    _names()
    _journal()
    _blocks()
    if op.get_bind().dialect.name == "postgresql":
        # Bodies are compressed already.
        for table in ("history_hot", "history_tail", "history_body"):
            op.execute(f"ALTER TABLE {table} ALTER COLUMN body SET STORAGE EXTERNAL")


def downgrade() -> None:
    for table in (
        "rollup",
        "body",
        "block",
        "tail",
        "hot",
        "catalogue",
        "gap",
        "range",
        "boot",
        "channel",
    ):
        op.drop_table(f"history_{table}")


_Kind = sa.types.TypeEngine[Any] | type[sa.types.TypeEngine[Any]]


def _column(
    name: str,
    kind: _Kind = _BIG,
    *,
    nullable: bool = False,
) -> sa.Column[Any]:
    return sa.Column(name, kind, nullable=nullable, autoincrement=False)


def _names() -> None:
    steps.create_table(
        "history_channel",
        _column("id", _ID),
        _column("site", _NAME),
        _column("address", _NAME),
        _column("since_us"),
        _column("saved_row"),
        _column("longest_us"),
        sa.PrimaryKeyConstraint("id", name="pk_history_channel"),
        sa.UniqueConstraint("site", "address", name="uq_history_channel_site"),
    )
    steps.create_table(
        "history_boot",
        _column("id", _ID),
        _column("site", _NAME),
        _column("boot", _NAME),
        sa.PrimaryKeyConstraint("id", name="pk_history_boot"),
        sa.UniqueConstraint("site", "boot", name="uq_history_boot_site"),
    )
    steps.create_table(
        "history_catalogue",
        _column("id", _ID),
        _column("channels", _BYTES),
        sa.PrimaryKeyConstraint("id", name="pk_history_catalogue"),
    )


def _journal() -> None:
    steps.create_table(
        "history_range",
        _column("boot_id", _ID),
        _column("first_seq"),
        _column("past_seq"),
        sa.PrimaryKeyConstraint("boot_id", "first_seq", name="pk_history_range"),
    )
    steps.create_table(
        "history_gap",
        _column("boot_id", _ID),
        _column("first_seq"),
        _column("last_seq"),
        _column("from_us"),
        _column("to_us"),
        _column("reason", _REASON),
        sa.PrimaryKeyConstraint(
            "boot_id", "first_seq", "last_seq", "from_us", name="pk_history_gap"
        ),
    )
    steps.create_table(
        "history_hot",
        _column("id", _ID),
        _column("boot_id", _ID),
        _column("catalogue_id", _ID),
        _column("first_seq"),
        _column("samples", sa.Integer),
        _column("body", _BYTES),
        sa.PrimaryKeyConstraint("id", name="pk_history_hot"),
        postgresql_with={
            "autovacuum_vacuum_scale_factor": "0.0",
            "autovacuum_vacuum_threshold": "2000",
        },
    )
    steps.create_table(
        "history_tail",
        _column("channel_id", _ID),
        _column("body", _BYTES),
        sa.PrimaryKeyConstraint("channel_id", name="pk_history_tail"),
    )


def _blocks() -> None:
    steps.create_table(
        "history_block",
        _column("channel_id", _ID),
        _column("first_us"),
        _column("id", _ID),
        _column("finest_us"),
        *_summary(),
        sa.PrimaryKeyConstraint("channel_id", "first_us", "id", name="pk_history_block"),
        sqlite_with_rowid=False,
    )
    steps.create_index("ix_history_block_last_us", "history_block", ["channel_id", "last_us"])
    steps.create_table(
        "history_body",
        _column("block_id", _ID),
        _column("body", _BYTES),
        sa.PrimaryKeyConstraint("block_id", name="pk_history_body"),
    )
    steps.create_table(
        "history_rollup",
        _column("channel_id", _ID),
        _column("width_us"),
        _column("bucket_us"),
        *_summary(),
        sa.PrimaryKeyConstraint("channel_id", "width_us", "bucket_us", name="pk_history_rollup"),
        sqlite_with_rowid=False,
    )


def _summary() -> tuple[sa.Column[Any], ...]:
    return (
        _column("samples"),
        _column("numbers"),
        _column("total", sa.Double),
        _column("low", sa.Double, nullable=True),
        _column("low_us"),
        _column("high", sa.Double, nullable=True),
        _column("high_us"),
        _column("last", sa.Double, nullable=True),
        _column("last_us"),
    )
