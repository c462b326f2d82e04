"""Every table but the history's; `metadata` holds them all.

Times are microseconds since the epoch (UTC). Secrets are kept as hashes only.

Long, because the tables of one database are read together.
"""

from __future__ import annotations

from sqlalchemy import (
    BigInteger,
    Boolean,
    Column,
    Double,
    ForeignKey,
    Index,
    Integer,
    MetaData,
    String,
    Table,
    Text,
    UniqueConstraint,
)

from talaia.hub.store.dialects.column_types import (
    LONG_BYTES,
    LONG_TEXT,
    PICTURE_BYTES,
    ROW_ID,
)

__all__ = [
    "api_tokens",
    "audit",
    "audit_head",
    "client_drivers",
    "client_protocols",
    "descriptions",
    "displays",
    "enrolment_codes",
    "frames",
    "gateways",
    "identities",
    "known_browsers",
    "learned",
    "metadata",
    "passkeys",
    "permissions",
    "recordings",
    "recovery_codes",
    "role_permissions",
    "roles",
    "seen_sightings",
    "sessions",
    "setup_tokens",
    "sightings",
    "sites",
    "token_permissions",
    "users",
    "write_turn",
    "wrong_tries",
]

metadata = MetaData(
    naming_convention={
        "ix": "ix_%(table_name)s_%(column_0_name)s",
        "uq": "uq_%(table_name)s_%(column_0_name)s",
        "fk": "fk_%(table_name)s_%(column_0_name)s",
        "pk": "pk_%(table_name)s",
    }
)

_NAME = 200
_HASH = 64

roles = Table(
    "roles",
    metadata,
    Column("id", ROW_ID, primary_key=True),
    Column("name", String(_NAME), nullable=False, unique=True),
    Column("seeded", Boolean, nullable=False),
    # Whoever has the role signs in with a second factor, or sets one up before anything else.
    Column("factor_required", Boolean, nullable=False, default=False),
)

permissions = Table(
    "permissions",
    metadata,
    Column("id", ROW_ID, primary_key=True),
    Column("right_name", String(16), nullable=False),
    # "*" stands for every site, or every device.
    Column("site", String(_NAME), nullable=False),
    Column("device", String(_NAME), nullable=False),
    UniqueConstraint("right_name", "site", "device"),
)

role_permissions = Table(
    "role_permissions",
    metadata,
    Column("role_id", ROW_ID, ForeignKey("roles.id", ondelete="CASCADE"), primary_key=True),
    Column(
        "permission_id", ROW_ID, ForeignKey("permissions.id", ondelete="CASCADE"), primary_key=True
    ),
)

users = Table(
    "users",
    metadata,
    Column("id", ROW_ID, primary_key=True),
    Column("name", String(_NAME), nullable=False),
    # The name as it is compared: normalised and without case.
    Column("name_key", String(_NAME), nullable=False, unique=True),
    Column("password_hash", String(100), nullable=False),
    Column("role_id", ROW_ID, ForeignKey("roles.id"), nullable=False),
    Column("disabled", Boolean, nullable=False),
    Column("created_us", BigInteger, nullable=False),
    # The second factor's secret, sealed by a key that is not in the database; empty: none.
    Column("factor_secret", String(_NAME), nullable=False),
    # One that was shown to the person and is not confirmed yet.
    Column("factor_pending", String(_NAME), nullable=False),
    # The last step of time whose code was used; none at or before it is taken again.
    Column("factor_step", BigInteger, nullable=False),
    Column("used_us", BigInteger, nullable=False),
    # Wrong codes one after the other; until when codes of time are not looked at; and when that
    # was, until the person has seen it (0: no news).
    Column("code_wrong", BigInteger, nullable=False, default=0),
    Column("code_locked_us", BigInteger, nullable=False, default=0),
    Column("code_alert_us", BigInteger, nullable=False, default=0),
    # A JSON object: in which unit values of another one are shown.
    Column("shown_units", String(2000), nullable=False, default="{}"),
)

# A client protocol that was ever opened; one without a row is shut.
client_protocols = Table(
    "client_protocols",
    metadata,
    Column("protocol", String(32), primary_key=True),
    Column("is_open", Boolean, nullable=False),
    # Of pages that are let in, as a JSON list.
    Column("origins", LONG_TEXT, nullable=False),
    Column("changed_by", String(_NAME), nullable=False),
    Column("changed_us", BigInteger, nullable=False),
)

# Accounts that may drive a device by clients of other tools.
client_drivers = Table(
    "client_drivers",
    metadata,
    Column("user_id", ROW_ID, ForeignKey("users.id", ondelete="CASCADE"), primary_key=True),
    Column("site", String(_NAME), primary_key=True),
    Column("device", String(_NAME), primary_key=True),
    Column("given_by", String(_NAME), nullable=False),
    Column("given_us", BigInteger, nullable=False),
)

sessions = Table(
    "sessions",
    metadata,
    Column("token_hash", String(_HASH), primary_key=True),
    Column(
        "user_id", ROW_ID, ForeignKey("users.id", ondelete="CASCADE"), nullable=False, index=True
    ),
    Column("created_us", BigInteger, nullable=False),
    Column("used_us", BigInteger, nullable=False),
    Column("address", String(_NAME), nullable=False),
    Column("agent", String(_NAME), nullable=False),
    # Begun by the provider of sign-ins, whose matter a second factor is then.
    Column("provider", Boolean, nullable=False, default=False),
)

recovery_codes = Table(
    "recovery_codes",
    metadata,
    Column("code_hash", String(_HASH), primary_key=True),
    Column(
        "user_id", ROW_ID, ForeignKey("users.id", ondelete="CASCADE"), nullable=False, index=True
    ),
)

# Keys that a person's own devices hold (WebAuthn); here are only their public halves.
passkeys = Table(
    "passkeys",
    metadata,
    Column("id", ROW_ID, primary_key=True),
    Column(
        "user_id", ROW_ID, ForeignKey("users.id", ondelete="CASCADE"), nullable=False, index=True
    ),
    Column("name", String(_NAME), nullable=False),
    # Of the credential's id, which may be too long for an index.
    Column("id_hash", String(_HASH), nullable=False, unique=True),
    Column("credential_id", LONG_TEXT, nullable=False),
    Column("public_key", LONG_TEXT, nullable=False),
    # The name of the hub for which it was made; at another it is of no use.
    Column("host", String(_NAME), nullable=False),
    Column("sign_count", BigInteger, nullable=False),
    Column("created_us", BigInteger, nullable=False),
    Column("used_us", BigInteger, nullable=False),
)

# Accounts at a provider (OpenID Connect), by the hash of issuer and subject.
identities = Table(
    "identities",
    metadata,
    Column("key_hash", String(_HASH), primary_key=True),
    Column(
        "user_id", ROW_ID, ForeignKey("users.id", ondelete="CASCADE"), nullable=False, index=True
    ),
    Column("created_us", BigInteger, nullable=False),
)

# Browsers from which a person has signed in before: a flood of wrong tries of others does not
# hold these back.
known_browsers = Table(
    "known_browsers",
    metadata,
    Column("token_hash", String(_HASH), primary_key=True),
    Column(
        "user_id", ROW_ID, ForeignKey("users.id", ondelete="CASCADE"), nullable=False, index=True
    ),
    Column("created_us", BigInteger, nullable=False),
    Column("used_us", BigInteger, nullable=False),
)

api_tokens = Table(
    "api_tokens",
    metadata,
    Column("id", ROW_ID, primary_key=True),
    Column(
        "user_id", ROW_ID, ForeignKey("users.id", ondelete="CASCADE"), nullable=False, index=True
    ),
    Column("name", String(_NAME), nullable=False),
    Column("token_hash", String(_HASH), nullable=False, unique=True),
    Column("created_us", BigInteger, nullable=False),
    Column("ends_us", BigInteger, nullable=False),
    # 0 until its first use.
    Column("used_us", BigInteger, nullable=False),
)

token_permissions = Table(
    "token_permissions",
    metadata,
    Column("token_id", ROW_ID, ForeignKey("api_tokens.id", ondelete="CASCADE"), primary_key=True),
    Column(
        "permission_id", ROW_ID, ForeignKey("permissions.id", ondelete="CASCADE"), primary_key=True
    ),
)

# Screens that show some sites; of their tokens the hash.
displays = Table(
    "displays",
    metadata,
    Column("id", ROW_ID, primary_key=True),
    Column("name", String(_NAME), nullable=False),
    Column("token_hash", String(_HASH), nullable=False, unique=True),
    # JSON: a list of their short names.
    Column("sites", LONG_TEXT, nullable=False),
    Column("created_us", BigInteger, nullable=False),
    # 0 until it was first opened.
    Column("used_us", BigInteger, nullable=False),
)

# Wrong sign-ins by person, address and browser, each as its hash, so that a restart forgets none.
wrong_tries = Table(
    "wrong_tries",
    metadata,
    Column("kind", String(16), primary_key=True),
    Column("key_hash", String(_HASH), primary_key=True),
    Column("wrong", BigInteger, nullable=False),
    Column("last_us", BigInteger, nullable=False, index=True),
)

# One row: whoever changes something holds it, where the engine has no lock of another kind.
write_turn = Table("write_turn", metadata, Column("id", ROW_ID, primary_key=True))

setup_tokens = Table(
    "setup_tokens",
    metadata,
    Column("token_hash", String(_HASH), primary_key=True),
    Column("expires_us", BigInteger, nullable=False),
)

gateways = Table(
    "gateways",
    metadata,
    Column("id", ROW_ID, primary_key=True),
    Column("site", String(_NAME), nullable=False, index=True),
    Column("key_hash", String(_HASH), nullable=False, unique=True),
    Column("created_us", BigInteger, nullable=False),
    # 0 while the key is good.
    Column("revoked_us", BigInteger, nullable=False),
    Column("name", String(_NAME), nullable=False),
    # Of its last link: version and address; 0 until there was one.
    Column("version", String(_NAME), nullable=False),
    Column("address", String(_NAME), nullable=False),
    Column("seen_us", BigInteger, nullable=False),
)

# A used code stays for a while, so that whoever tries it again is told why it is refused.
enrolment_codes = Table(
    "enrolment_codes",
    metadata,
    Column("id", ROW_ID, primary_key=True),
    Column("site", String(_NAME), nullable=False),
    Column("name", String(_NAME), nullable=False),
    Column("code_hash", String(_HASH), nullable=False, unique=True),
    Column("created_us", BigInteger, nullable=False),
    Column("expires_us", BigInteger, nullable=False),
    # 0 while it can be used.
    Column("used_us", BigInteger, nullable=False),
)

sites = Table(
    "sites",
    metadata,
    Column("site", String(_NAME), primary_key=True),
    Column("description", LONG_TEXT, nullable=False),
    Column("catalogue", String(_NAME), nullable=False),
    Column("version", String(_NAME), nullable=False),
    Column("first_seen_us", BigInteger, nullable=False),
    Column("last_seen_us", BigInteger, nullable=False),
)

# Every version of every site's description; see `store.descriptions`.
descriptions = Table(
    "descriptions",
    metadata,
    Column("id", ROW_ID, primary_key=True),
    Column("site", String(_NAME), nullable=False),
    Column("number", BigInteger, nullable=False),
    Column("digest", String(_HASH), nullable=False),
    Column("text", LONG_TEXT, nullable=False),
    Column("time_us", BigInteger, nullable=False),
    Column("gateway", BigInteger, nullable=False),
    Column("who", String(_NAME), nullable=False),
    Column("note", String(_NAME), nullable=False),
    UniqueConstraint("site", "number"),
)

# The files are in the data folder. ``topics`` is a JSON list.
recordings = Table(
    "recordings",
    metadata,
    Column("site", String(_NAME), primary_key=True),
    Column("id", String(64), primary_key=True),
    Column("state", String(16), nullable=False),
    Column("why", String(2000), nullable=False),
    Column("who", String(2000), nullable=False),
    Column("note", String(2000), nullable=False),
    Column("begin_us", BigInteger, nullable=False, index=True),
    Column("end_us", BigInteger, nullable=False),
    Column("size", BigInteger, nullable=False),
    Column("have", BigInteger, nullable=False),
    Column("messages", BigInteger, nullable=False),
    Column("digest", String(_HASH), nullable=False),
    Column("topics", LONG_TEXT, nullable=False),
    Column("stream", String(200), nullable=False, server_default=""),
)

audit = Table(
    "audit",
    metadata,
    Column("id", ROW_ID, primary_key=True),
    Column("time_us", BigInteger, nullable=False, index=True),
    Column("kind", String(_NAME), nullable=False, index=True),
    Column("who", String(_NAME), nullable=False, index=True),
    Column("address", String(_NAME), nullable=False),
    Column("site", String(_NAME), nullable=False, index=True),
    Column("device", String(_NAME), nullable=False),
    Column("message", String(2000), nullable=False),
    Column("good", Boolean, nullable=False),
    # Whose word it is: the hub's or the gateway's; empty in older rows.
    Column("source", String(16), nullable=False, server_default=""),
    # Over this row and the hash of the one before; a changed or missing row breaks the chain.
    Column("hash", String(_HASH), nullable=False),
)

# The end of the audit log, one row: rows that are cut off at the end show, too, and whoever
# appends waits here for the one before.
audit_head = Table(
    "audit_head",
    metadata,
    Column("id", ROW_ID, primary_key=True, autoincrement=False),
    Column("row_id", ROW_ID, nullable=False),
    Column("hash", String(_HASH), nullable=False),
)

# The archive: one row for each picture that is kept.
frames = Table(
    "frames",
    metadata,
    Column("id", ROW_ID, primary_key=True),
    Column("site", String(_NAME), nullable=False),
    Column("device", String(_NAME), nullable=False),
    # Local date at which its night began.
    Column("night", String(10), nullable=False),
    Column("name", String(_NAME), nullable=False),
    Column("time_us", BigInteger, nullable=False),
    Column("target", String(_NAME), nullable=False),
    # As it is searched: without case.
    Column("target_key", String(2 * _NAME), nullable=False),
    Column("filter", String(_NAME), nullable=False),
    Column("kind", String(_NAME), nullable=False),
    Column("exposure_s", Double, nullable=True),
    Column("ra_deg", Double, nullable=True),
    Column("dec_deg", Double, nullable=True),
    Column("width", Integer, nullable=False),
    Column("height", Integer, nullable=False),
    Column("bytes", BigInteger, nullable=False),
    Column("digest", String(_HASH), nullable=False),
    # What the verification found, a line each.
    Column("problems", Text, nullable=False),
    # `archive.store.MeasureState` and `HookState`: two queues that outlive the hub.
    Column("measured", Integer, nullable=False, server_default="2"),
    Column("hook", Integer, nullable=False, server_default="0"),
    Column("stars", Integer, nullable=True),
    Column("fwhm", Double, nullable=True),
    Column("background", Double, nullable=True),
    Column("zero_point", Double, nullable=True),
    # JSON of `imaging.tangent_plane.TanWcs`; empty where it was not solved.
    Column("wcs", String(400), nullable=False, server_default=""),
    # Why it was not solved, or not measured.
    Column("measure_note", String(400), nullable=False, server_default=""),
    UniqueConstraint("site", "digest", name="uq_frames_site"),
    Index("ix_frames_site_time_us", "site", "time_us"),
    Index("ix_frames_site_night", "site", "night"),
    Index("ix_frames_measured", "measured", "id"),
    Index("ix_frames_hook", "hook", "id"),
)

# What each anomaly detector has learned, so that a restart forgets nothing.
learned = Table(
    "learned",
    metadata,
    Column("site", String(_NAME), primary_key=True),
    Column("address", String(_NAME), primary_key=True),
    Column("detector", String(20), primary_key=True),
    Column("state", LONG_BYTES, nullable=False),
    Column("saved_us", BigInteger, nullable=False),
)

# What cameras have seen; see `store.sightings`.
sightings = Table(
    "sightings",
    metadata,
    Column("id", ROW_ID, primary_key=True),
    Column("site", String(_NAME), nullable=False),
    Column("camera", String(_NAME), nullable=False),
    Column("label", String(_NAME), nullable=False),
    Column("began_us", BigInteger, nullable=False),
    # 0 while it is in sight.
    Column("ended_us", BigInteger, nullable=False),
    Column("many", Integer, nullable=False),
    Column("confidence", Double, nullable=False),
    # When the hub was told of it last, by its own clock; and the run that told it.
    Column("told_us", BigInteger, nullable=False),
    Column("boot", String(_NAME), nullable=False),
    # The time of its line in the logbook; 0 before there is one.
    Column("noted_us", BigInteger, nullable=False),
    Column("pictured", Boolean, nullable=False),
    # Its path, and what it did at zones and lines: JSON, or empty.
    Column("story", String(8000), nullable=False, server_default=""),
    # JPEG. Last, so that a list need not read past it.
    Column("picture", PICTURE_BYTES),
    UniqueConstraint("site", "camera", "label", "began_us", name="uq_sightings_site"),
    Index("ix_sightings_site_began_us", "site", "began_us"),
    Index("ix_sightings_site_noted_us", "site", "noted_us"),
)
# Which sightings a person has looked at.
seen_sightings = Table(
    "seen_sightings",
    metadata,
    Column("user_id", ROW_ID, ForeignKey("users.id", ondelete="CASCADE"), primary_key=True),
    Column("sighting_id", ROW_ID, ForeignKey("sightings.id", ondelete="CASCADE"), primary_key=True),
    Index("ix_seen_sightings_sighting_id", "sighting_id"),
)
