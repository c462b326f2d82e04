"""Accounts, roles, sessions, gateways, sites and the audit log."""

from __future__ import annotations

import sqlalchemy as sa

from talaia.hub.store.migrations import steps
from talaia.hub.store.migrations.steps import HASH as _HASH, ID as _ID, LONG as _LONG, NAME as _NAME

revision = "0001"
down_revision = None
branch_labels = None
depends_on = None


def upgrade() -> None:
    roles, permissions, role_permissions = _rights()
    _people()
    _sites()
    _seed(roles, permissions, role_permissions)


def _rights() -> tuple[sa.Table, sa.Table, sa.Table]:
    roles = steps.create_table(
        "roles",
        sa.Column("id", _ID, nullable=False),
        sa.Column("name", _NAME, nullable=False),
        sa.Column("seeded", sa.Boolean, nullable=False),
        sa.PrimaryKeyConstraint("id", name="pk_roles"),
        sa.UniqueConstraint("name", name="uq_roles_name"),
    )
    permissions = steps.create_table(
        "permissions",
        sa.Column("id", _ID, nullable=False),
        sa.Column("right_name", sa.String(16), nullable=False),
        sa.Column("site", _NAME, nullable=False),
        sa.Column("device", _NAME, nullable=False),
        sa.PrimaryKeyConstraint("id", name="pk_permissions"),
        sa.UniqueConstraint("right_name", "site", "device", name="uq_permissions_right_name"),
    )
    role_permissions = steps.create_table(
        "role_permissions",
        sa.Column("role_id", _ID, nullable=False),
        sa.Column("permission_id", _ID, nullable=False),
        sa.PrimaryKeyConstraint("role_id", "permission_id", name="pk_role_permissions"),
        sa.ForeignKeyConstraint(
            ["role_id"], ["roles.id"], name="fk_role_permissions_role_id", ondelete="CASCADE"
        ),
        sa.ForeignKeyConstraint(
            ["permission_id"],
            ["permissions.id"],
            name="fk_role_permissions_permission_id",
            ondelete="CASCADE",
        ),
    )
    return roles, permissions, role_permissions


def _people() -> None:
    steps.create_table(
        "users",
        sa.Column("id", _ID, nullable=False),
        sa.Column("name", _NAME, nullable=False),
        sa.Column("name_key", _NAME, nullable=False),
        sa.Column("password_hash", sa.String(100), nullable=False),
        sa.Column("role_id", _ID, nullable=False),
        sa.Column("disabled", sa.Boolean, nullable=False),
        sa.Column("created_us", sa.BigInteger, nullable=False),
        sa.PrimaryKeyConstraint("id", name="pk_users"),
        sa.UniqueConstraint("name_key", name="uq_users_name_key"),
        sa.ForeignKeyConstraint(["role_id"], ["roles.id"], name="fk_users_role_id"),
    )
    steps.create_table(
        "sessions",
        sa.Column("token_hash", _HASH, nullable=False),
        sa.Column("user_id", _ID, nullable=False),
        sa.Column("created_us", sa.BigInteger, nullable=False),
        sa.Column("used_us", sa.BigInteger, nullable=False),
        sa.Column("address", _NAME, nullable=False),
        sa.PrimaryKeyConstraint("token_hash", name="pk_sessions"),
        sa.ForeignKeyConstraint(
            ["user_id"], ["users.id"], name="fk_sessions_user_id", ondelete="CASCADE"
        ),
    )
    steps.create_index("ix_sessions_user_id", "sessions", ["user_id"])
    steps.create_table(
        "setup_tokens",
        sa.Column("token_hash", _HASH, nullable=False),
        sa.Column("expires_us", sa.BigInteger, nullable=False),
        sa.PrimaryKeyConstraint("token_hash", name="pk_setup_tokens"),
    )


def _sites() -> None:
    steps.create_table(
        "gateways",
        sa.Column("id", _ID, nullable=False),
        sa.Column("site", _NAME, nullable=False),
        sa.Column("key_hash", _HASH, nullable=False),
        sa.Column("created_us", sa.BigInteger, nullable=False),
        sa.Column("revoked_us", sa.BigInteger, nullable=False),
        sa.PrimaryKeyConstraint("id", name="pk_gateways"),
        sa.UniqueConstraint("key_hash", name="uq_gateways_key_hash"),
    )
    steps.create_index("ix_gateways_site", "gateways", ["site"])
    steps.create_table(
        "sites",
        sa.Column("site", _NAME, nullable=False),
        sa.Column("description", _LONG, nullable=False),
        sa.Column("catalogue", _NAME, nullable=False),
        sa.Column("version", _NAME, nullable=False),
        sa.Column("first_seen_us", sa.BigInteger, nullable=False),
        sa.Column("last_seen_us", sa.BigInteger, nullable=False),
        sa.PrimaryKeyConstraint("site", name="pk_sites"),
    )
    steps.create_table(
        "audit",
        sa.Column("id", _ID, nullable=False),
        sa.Column("time_us", sa.BigInteger, nullable=False),
        sa.Column("kind", _NAME, nullable=False),
        sa.Column("who", _NAME, nullable=False),
        sa.Column("address", _NAME, nullable=False),
        sa.Column("site", _NAME, nullable=False),
        sa.Column("device", _NAME, nullable=False),
        sa.Column("message", sa.String(2000), nullable=False),
        sa.Column("good", sa.Boolean, nullable=False),
        sa.Column("hash", _HASH, nullable=False),
        sa.PrimaryKeyConstraint("id", name="pk_audit"),
    )
    steps.create_index("ix_audit_time_us", "audit", ["time_us"])
    steps.create_index("ix_audit_site", "audit", ["site"])


def _seed(roles: sa.Table, permissions: sa.Table, role_permissions: sa.Table) -> None:
    """A guest holds no right: it sees what the description marks as public."""
    steps.seed(
        roles,
        [
            {"id": 1, "name": "guest", "seeded": True},
            {"id": 2, "name": "operator", "seeded": True},
            {"id": 3, "name": "admin", "seeded": True},
        ],
    )
    steps.seed(
        permissions,
        [
            {"id": 1, "right_name": "view", "site": "*", "device": "*"},
            {"id": 2, "right_name": "use", "site": "*", "device": "*"},
            {"id": 3, "right_name": "admin", "site": "*", "device": "*"},
        ],
    )
    steps.seed(
        role_permissions,
        [
            {"role_id": 2, "permission_id": 1},
            {"role_id": 2, "permission_id": 2},
            {"role_id": 3, "permission_id": 1},
            {"role_id": 3, "permission_id": 2},
            {"role_id": 3, "permission_id": 3},
        ],
    )
