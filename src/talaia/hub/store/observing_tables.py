"""The tables of proposals, requests and observations.

Times are microseconds since the epoch (UTC); exposures and charges are seconds.
"""

from __future__ import annotations

from sqlalchemy import (
    BigInteger,
    Boolean,
    Column,
    Double,
    ForeignKey,
    ForeignKeyConstraint,
    Index,
    Integer,
    String,
    Table,
)

from talaia.hub.store.dialects.column_types import LONG_TEXT, ROW_ID
from talaia.hub.store.tables import metadata

__all__ = [
    "observations",
    "observing_requests",
    "observing_revisions",
    "proposal_members",
    "proposals",
    "request_groups",
    "request_log",
]

_NAME = 200
_ID = 64
_WORD = 32
_SENTENCE = 2000

proposals = Table(
    "proposals",
    metadata,
    Column("site", String(_NAME), primary_key=True),
    Column("proposal", String(_ID), primary_key=True),
    Column("title", String(_NAME), nullable=False),
    Column("share", Double, nullable=False),
    Column("hours_allocated", Double, nullable=False),
    # Of each member; 0: as much as there is.
    Column("person_hours", Double, nullable=False),
    Column("max_priority", Double, nullable=False),
    # Those beside NORMAL that may be asked for, with commas between.
    Column("urgencies", String(_NAME), nullable=False),
    Column("active", Boolean, nullable=False),
    # Whoever may view the site sees its requests.
    Column("is_open", Boolean, nullable=False),
    # What is handed in waits until somebody approves it.
    Column("needs_approval", Boolean, nullable=False),
    Column("changed_us", BigInteger, nullable=False),
)

proposal_members = Table(
    "proposal_members",
    metadata,
    Column("site", String(_NAME), primary_key=True),
    Column("proposal", String(_ID), primary_key=True),
    Column(
        "user_id", ROW_ID, ForeignKey("users.id", ondelete="CASCADE"), primary_key=True, index=True
    ),
    Column("role", String(_WORD), nullable=False),
    ForeignKeyConstraint(
        ["site", "proposal"],
        ["proposals.site", "proposals.proposal"],
        ondelete="CASCADE",
        name="fk_proposal_members_site",
    ),
)

request_groups = Table(
    "request_groups",
    metadata,
    Column("id", ROW_ID, primary_key=True),
    Column("site", String(_NAME), nullable=False),
    Column("proposal", String(_ID), nullable=False),
    Column("name", String(_NAME), nullable=False),
    # No foreign key: what was asked stays when the account goes.
    Column("user_id", ROW_ID, nullable=False),
    Column("requester", String(_NAME), nullable=False),
    Column("operator", String(_WORD), nullable=False),
    Column("urgency", String(_WORD), nullable=False),
    Column("priority", Double, nullable=False),
    Column("created_us", BigInteger, nullable=False),
    # 0: a draft that nobody has handed in.
    Column("submitted_us", BigInteger, nullable=False),
    # 0: nobody has; it did not need it, or waits for it.
    Column("approved_us", BigInteger, nullable=False),
    Column("approved_by", String(_NAME), nullable=False),
    ForeignKeyConstraint(
        ["site", "proposal"],
        ["proposals.site", "proposals.proposal"],
        name="fk_request_groups_site",
    ),
    Index("ix_request_groups_site_proposal", "site", "proposal"),
)

observing_requests = Table(
    "observing_requests",
    metadata,
    Column("id", ROW_ID, primary_key=True),
    Column(
        "group_id",
        ROW_ID,
        ForeignKey("request_groups.id", ondelete="CASCADE"),
        nullable=False,
        index=True,
    ),
    # Of its group, so that lists need not join.
    Column("site", String(_NAME), nullable=False),
    Column("proposal", String(_ID), nullable=False),
    # Its place in the group.
    Column("position", Integer, nullable=False),
    Column("state", String(_WORD), nullable=False),
    Column("target_name", String(_NAME), nullable=False),
    # JSON: `talaia.model.observing.requests.Request`, of which id and state are not meant.
    Column("definition", LONG_TEXT, nullable=False),
    Column("charge_s", Double, nullable=False),
    # Of the first window, and of the last.
    Column("start_us", BigInteger, nullable=False),
    Column("end_us", BigInteger, nullable=False),
    # JSON: of each configuration.
    Column("frames_done", LONG_TEXT, nullable=False),
    Column("failures", Integer, nullable=False),
    Column("changed_us", BigInteger, nullable=False),
    Index("ix_observing_requests_site_state", "site", "state"),
)

request_log = Table(
    "request_log",
    metadata,
    Column("id", ROW_ID, primary_key=True),
    Column(
        "request_id",
        ROW_ID,
        ForeignKey("observing_requests.id", ondelete="CASCADE"),
        nullable=False,
        index=True,
    ),
    Column("time_us", BigInteger, nullable=False),
    # An account, or empty: the hub by itself, or the gateway.
    Column("who", String(_NAME), nullable=False),
    # Empty: it was made.
    Column("from_state", String(_WORD), nullable=False),
    Column("to_state", String(_WORD), nullable=False),
    Column("why", String(_SENTENCE), nullable=False),
)

observations = Table(
    "observations",
    metadata,
    Column("site", String(_NAME), primary_key=True),
    # As its gateway calls it.
    Column("observation", String(_NAME), primary_key=True),
    # No foreign key: a gateway may report on what a restored database does not know.
    Column("request_id", ROW_ID, nullable=False, index=True),
    Column("proposal", String(_ID), nullable=False),
    Column("user_id", ROW_ID, nullable=False),
    # Of the newest report that is in this row; one that is not newer changes nothing.
    Column("number", BigInteger, nullable=False),
    Column("state", String(_WORD), nullable=False),
    Column("cause", String(_WORD), nullable=False),
    Column("why", String(_SENTENCE), nullable=False),
    Column("began_us", BigInteger, nullable=False),
    Column("changed_us", BigInteger, nullable=False),
    Column("frames_done", LONG_TEXT, nullable=False),
    Column("block_s", Double, nullable=False),
    # JSON: names of FITS files.
    Column("files", LONG_TEXT, nullable=False),
    Index("ix_observations_site_proposal", "site", "proposal"),
)

# Rises with each change that a gateway is to know.
observing_revisions = Table(
    "observing_revisions",
    metadata,
    Column("site", String(_NAME), primary_key=True),
    Column("revision", BigInteger, nullable=False),
)
