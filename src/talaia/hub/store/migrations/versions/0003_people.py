"""Second factor, recovery codes, API tokens, known browsers, wrong tries that are remembered."""

from __future__ import annotations

import sqlalchemy as sa
from alembic import op

from talaia.hub.store.migrations import steps
from talaia.hub.store.migrations.steps import BIG, HASH, ID, NAME

revision = "0003"
down_revision = "0002"
branch_labels = None
depends_on = None

_MADE_BEFORE = (
    "roles",
    "permissions",
    "role_permissions",
    "users",
    "sessions",
    "setup_tokens",
    "gateways",
    "sites",
    "audit",
)


def upgrade() -> None:
    _compare_exactly()
    _number_on()
    _columns()
    _recovery()
    _tokens()
    _tries()


def _compare_exactly() -> None:
    """Tables of before may have been made with the server's default, which ignores case."""
    if op.get_bind().dialect.name != "mysql":
        return
    for table in _MADE_BEFORE:
        op.execute(f"ALTER TABLE {table} CONVERT TO CHARACTER SET utf8mb4 COLLATE utf8mb4_bin")


def _number_on() -> None:
    """The seeded rows came with their numbers, and PostgreSQL did not count them."""
    for name in ("roles", "permissions"):
        steps.seed(sa.Table(name, sa.MetaData(), sa.Column("id", ID, primary_key=True)), [])


def _columns() -> None:
    # Secrets of the second factor are sealed by a key that is not in the database. Empty: none.
    steps.add_column("users", sa.Column("factor_secret", NAME, nullable=False, server_default=""))
    # Shown to the person and not confirmed yet.
    steps.add_column("users", sa.Column("factor_pending", NAME, nullable=False, server_default=""))
    # The last step of time whose code was used; none at or before it is taken again.
    steps.add_column("users", sa.Column("factor_step", BIG, nullable=False, server_default="0"))
    steps.add_column("users", sa.Column("used_us", BIG, nullable=False, server_default="0"))
    steps.add_column("sessions", sa.Column("agent", NAME, nullable=False, server_default=""))


def _recovery() -> None:
    steps.create_table(
        "recovery_codes",
        sa.Column("code_hash", HASH, nullable=False),
        sa.Column("user_id", ID, nullable=False),
        sa.PrimaryKeyConstraint("code_hash", name="pk_recovery_codes"),
        sa.ForeignKeyConstraint(
            ["user_id"], ["users.id"], name="fk_recovery_codes_user_id", ondelete="CASCADE"
        ),
    )
    steps.create_index("ix_recovery_codes_user_id", "recovery_codes", ["user_id"])
    steps.create_table(
        "known_browsers",
        sa.Column("token_hash", HASH, nullable=False),
        sa.Column("user_id", ID, nullable=False),
        sa.Column("created_us", BIG, nullable=False),
        sa.Column("used_us", BIG, nullable=False),
        sa.PrimaryKeyConstraint("token_hash", name="pk_known_browsers"),
        sa.ForeignKeyConstraint(
            ["user_id"], ["users.id"], name="fk_known_browsers_user_id", ondelete="CASCADE"
        ),
    )
    steps.create_index("ix_known_browsers_user_id", "known_browsers", ["user_id"])


def _tokens() -> None:
    steps.create_table(
        "api_tokens",
        sa.Column("id", ID, nullable=False),
        sa.Column("user_id", ID, nullable=False),
        sa.Column("name", NAME, nullable=False),
        sa.Column("token_hash", HASH, nullable=False),
        sa.Column("created_us", BIG, nullable=False),
        sa.Column("ends_us", BIG, nullable=False),
        sa.Column("used_us", BIG, nullable=False),
        sa.PrimaryKeyConstraint("id", name="pk_api_tokens"),
        sa.UniqueConstraint("token_hash", name="uq_api_tokens_token_hash"),
        sa.ForeignKeyConstraint(
            ["user_id"], ["users.id"], name="fk_api_tokens_user_id", ondelete="CASCADE"
        ),
    )
    steps.create_index("ix_api_tokens_user_id", "api_tokens", ["user_id"])
    steps.create_table(
        "token_permissions",
        sa.Column("token_id", ID, nullable=False),
        sa.Column("permission_id", ID, nullable=False),
        sa.PrimaryKeyConstraint("token_id", "permission_id", name="pk_token_permissions"),
        sa.ForeignKeyConstraint(
            ["token_id"],
            ["api_tokens.id"],
            name="fk_token_permissions_token_id",
            ondelete="CASCADE",
        ),
        sa.ForeignKeyConstraint(
            ["permission_id"],
            ["permissions.id"],
            name="fk_token_permissions_permission_id",
            ondelete="CASCADE",
        ),
    )


def _tries() -> None:
    steps.create_table(
        "wrong_tries",
        # "user", "address" or "browser".
        sa.Column("kind", sa.String(16), nullable=False),
        sa.Column("key_hash", HASH, nullable=False),
        sa.Column("wrong", BIG, nullable=False),
        sa.Column("last_us", BIG, nullable=False),
        sa.PrimaryKeyConstraint("kind", "key_hash", name="pk_wrong_tries"),
    )
    steps.create_index("ix_wrong_tries_last_us", "wrong_tries", ["last_us"])
    turn = steps.create_table(
        "write_turn",
        sa.Column("id", ID, nullable=False),
        sa.PrimaryKeyConstraint("id", name="pk_write_turn"),
    )
    steps.seed(turn, [{"id": 1}])
