"""Proposals, requests and observations; the rights of the night; who is told of their requests."""

from __future__ import annotations

import sqlalchemy as sa
from alembic import op

from talaia.hub.store.migrations import steps
from talaia.hub.store.migrations.steps import BIG, ID, LONG, NAME

revision = "0022"
down_revision = "0021"
branch_labels = None
depends_on = None

_PROPOSAL = sa.String(64)
_WORD = sa.String(32)
_SENTENCE = sa.String(2000)
# Who uses the devices may ask for observations and arm the night; to approve is the admin's, who
# has every right.
_OPERATORS = ("request", "arm")


def upgrade() -> None:
    _proposals()
    _requests()
    _observations()
    steps.add_column(
        "notify_rules",
        sa.Column("own_requests", sa.Boolean, nullable=False, server_default=sa.false()),
    )
    for right in _OPERATORS:
        _give_operators(right)


def _proposals() -> None:
    steps.create_table(
        "proposals",
        sa.Column("site", NAME, nullable=False),
        sa.Column("proposal", _PROPOSAL, nullable=False),
        sa.Column("title", NAME, nullable=False),
        sa.Column("share", sa.Double, nullable=False),
        sa.Column("hours_allocated", sa.Double, nullable=False),
        sa.Column("person_hours", sa.Double, nullable=False),
        sa.Column("max_priority", sa.Double, nullable=False),
        sa.Column("urgencies", NAME, nullable=False),
        sa.Column("active", sa.Boolean, nullable=False),
        sa.Column("is_open", sa.Boolean, nullable=False),
        sa.Column("needs_approval", sa.Boolean, nullable=False),
        sa.Column("changed_us", BIG, nullable=False),
        sa.PrimaryKeyConstraint("site", "proposal", name="pk_proposals"),
    )
    steps.create_table(
        "proposal_members",
        sa.Column("site", NAME, nullable=False),
        sa.Column("proposal", _PROPOSAL, nullable=False),
        sa.Column("user_id", ID, nullable=False),
        sa.Column("role", _WORD, nullable=False),
        sa.PrimaryKeyConstraint("site", "proposal", "user_id", name="pk_proposal_members"),
        sa.ForeignKeyConstraint(
            ["user_id"], ["users.id"], name="fk_proposal_members_user_id", ondelete="CASCADE"
        ),
        _of_proposal("proposal_members", ondelete="CASCADE"),
    )
    steps.create_index("ix_proposal_members_user_id", "proposal_members", ["user_id"])


def _requests() -> None:
    steps.create_table(
        "request_groups",
        sa.Column("id", ID, primary_key=True),
        sa.Column("site", NAME, nullable=False),
        sa.Column("proposal", _PROPOSAL, nullable=False),
        sa.Column("name", NAME, nullable=False),
        sa.Column("user_id", ID, nullable=False),
        sa.Column("requester", NAME, nullable=False),
        sa.Column("operator", _WORD, nullable=False),
        sa.Column("urgency", _WORD, nullable=False),
        sa.Column("priority", sa.Double, nullable=False),
        sa.Column("created_us", BIG, nullable=False),
        sa.Column("submitted_us", BIG, nullable=False),
        sa.Column("approved_us", BIG, nullable=False),
        sa.Column("approved_by", NAME, nullable=False),
        _of_proposal("request_groups"),
    )
    steps.create_index("ix_request_groups_site_proposal", "request_groups", ["site", "proposal"])
    steps.create_table(
        "observing_requests",
        sa.Column("id", ID, primary_key=True),
        sa.Column("group_id", ID, nullable=False),
        sa.Column("site", NAME, nullable=False),
        sa.Column("proposal", _PROPOSAL, nullable=False),
        sa.Column("position", sa.Integer, nullable=False),
        sa.Column("state", _WORD, nullable=False),
        sa.Column("target_name", NAME, nullable=False),
        sa.Column("definition", LONG, nullable=False),
        sa.Column("charge_s", sa.Double, nullable=False),
        sa.Column("start_us", BIG, nullable=False),
        sa.Column("end_us", BIG, nullable=False),
        sa.Column("frames_done", LONG, nullable=False),
        sa.Column("failures", sa.Integer, nullable=False),
        sa.Column("changed_us", BIG, nullable=False),
        sa.ForeignKeyConstraint(
            ["group_id"],
            ["request_groups.id"],
            name="fk_observing_requests_group_id",
            ondelete="CASCADE",
        ),
    )
    steps.create_index("ix_observing_requests_group_id", "observing_requests", ["group_id"])
    steps.create_index("ix_observing_requests_site_state", "observing_requests", ["site", "state"])
    steps.create_table(
        "request_log",
        sa.Column("id", ID, primary_key=True),
        sa.Column("request_id", ID, nullable=False),
        sa.Column("time_us", BIG, nullable=False),
        sa.Column("who", NAME, nullable=False),
        sa.Column("from_state", _WORD, nullable=False),
        sa.Column("to_state", _WORD, nullable=False),
        sa.Column("why", _SENTENCE, nullable=False),
        sa.ForeignKeyConstraint(
            ["request_id"],
            ["observing_requests.id"],
            name="fk_request_log_request_id",
            ondelete="CASCADE",
        ),
    )
    steps.create_index("ix_request_log_request_id", "request_log", ["request_id"])


def _observations() -> None:
    steps.create_table(
        "observations",
        sa.Column("site", NAME, nullable=False),
        sa.Column("observation", NAME, nullable=False),
        sa.Column("request_id", ID, nullable=False),
        sa.Column("proposal", _PROPOSAL, nullable=False),
        sa.Column("user_id", ID, nullable=False),
        sa.Column("number", BIG, nullable=False),
        sa.Column("state", _WORD, nullable=False),
        sa.Column("cause", _WORD, nullable=False),
        sa.Column("why", _SENTENCE, nullable=False),
        sa.Column("began_us", BIG, nullable=False),
        sa.Column("changed_us", BIG, nullable=False),
        sa.Column("frames_done", LONG, nullable=False),
        sa.Column("block_s", sa.Double, nullable=False),
        sa.Column("files", LONG, nullable=False),
        sa.PrimaryKeyConstraint("site", "observation", name="pk_observations"),
    )
    steps.create_index("ix_observations_request_id", "observations", ["request_id"])
    steps.create_index("ix_observations_site_proposal", "observations", ["site", "proposal"])
    steps.create_table(
        "observing_revisions",
        sa.Column("site", NAME, nullable=False),
        sa.Column("revision", BIG, nullable=False),
        sa.PrimaryKeyConstraint("site", name="pk_observing_revisions"),
    )


def _of_proposal(table: str, ondelete: str | None = None) -> sa.ForeignKeyConstraint:
    return sa.ForeignKeyConstraint(
        ["site", "proposal"],
        ["proposals.site", "proposals.proposal"],
        name=f"fk_{table}_site",
        ondelete=ondelete,
    )


def _give_operators(right: str) -> None:
    """Let the seeded operators have a right at every site, unless they have it."""
    bind, kept = op.get_bind(), sa.MetaData()
    roles = sa.Table("roles", kept, sa.Column("id", ID), sa.Column("name", NAME))
    permissions = sa.Table(
        "permissions",
        kept,
        sa.Column("id", ID, primary_key=True),
        *(sa.Column(name, NAME) for name in ("right_name", "site", "device")),
    )
    given = sa.Table(
        "role_permissions", kept, sa.Column("role_id", ID), sa.Column("permission_id", ID)
    )
    role = bind.execute(sa.select(roles.c.id).where(roles.c.name == "operator")).scalar()
    wanted = {"right_name": right, "site": "*", "device": "*"}
    of_right = sa.select(permissions.c.id).filter_by(**wanted)
    number = bind.execute(of_right).scalar()
    if number is None:
        bind.execute(sa.insert(permissions).values(**wanted))
        number = bind.execute(of_right).scalar_one()
    pair = {"role_id": role, "permission_id": number}
    if role is not None and bind.execute(sa.select(given).filter_by(**pair)).first() is None:
        bind.execute(sa.insert(given).values(**pair))


def downgrade() -> None:
    for table in (
        "observing_revisions",
        "observations",
        "request_log",
        "observing_requests",
        "request_groups",
        "proposal_members",
        "proposals",
    ):
        op.drop_table(table)
    op.drop_column("notify_rules", "own_requests")
