"""JSON bodies of accounts, people, roles and tokens; the browser's types are made from these.

Times ending in ``_us`` are microseconds since the epoch (UTC); 0 says never. Ids are texts.

Long, because all that is said about one's own account and others' is read together.
"""

from __future__ import annotations

from typing import Annotated, Any

from pydantic import Field, StringConstraints

from talaia.hub.api.schemas.common import PermissionShape, Schema
from talaia.hub.auth.permissions import Right  # noqa: TC001 - pydantic reads it
from talaia.model.closed_lists import DeviceKind  # noqa: TC001 - pydantic reads it
from talaia.model.units.unit_text import LONGEST_UNIT

__all__ = [
    "CodeOnly",
    "Confirmation",
    "DeviceList",
    "DeviceSummary",
    "DisplayAsk",
    "DisplayList",
    "DisplayOpenAsk",
    "DisplayShape",
    "FactorNeed",
    "FactorOffer",
    "NewDisplay",
    "NewToken",
    "OidcAnswer",
    "OidcConnection",
    "OidcDone",
    "OidcProvider",
    "OidcReturn",
    "OidcStart",
    "PasskeyAdded",
    "PasskeyAsk",
    "PasskeyList",
    "PasskeyName",
    "PasskeyOptions",
    "PasskeyOptionsAsk",
    "PasskeyShape",
    "PasskeySignIn",
    "PasswordChange",
    "PasswordOnly",
    "PersonAsk",
    "PersonChange",
    "PersonList",
    "PersonShape",
    "RecoveryCodes",
    "RemoveFactor",
    "RoleAsk",
    "RoleList",
    "RoleShape",
    "SessionList",
    "SessionShape",
    "TokenAsk",
    "TokenList",
    "TokenShape",
    "UnitChoice",
    "UnitChoiceAsk",
    "UnitChoiceList",
]

# Of one person; more units than any site has.
_MOST = 40
_Unit = Annotated[str, StringConstraints(min_length=1, max_length=LONGEST_UNIT)]

# A name as people choose one for a person, a role or a token; the rules are in auth.passwords.
_NAME = Field(min_length=1, max_length=200)
_PASSWORD = Field(max_length=4096)
_CODE = Field(min_length=1, max_length=64)  # of an authenticator, or for recovery, with its hyphens
_MOST_PERMISSIONS = 500  # of one role or token
_MOST_SITES = 200  # of one display


class PasswordChange(Schema):
    """Take another password."""

    old: str = _PASSWORD
    new: str = _PASSWORD


class PasswordOnly(Schema):
    """Prove that it is you who asks."""

    password: str = _PASSWORD


class CodeOnly(Schema):
    """A code from the authenticator."""

    code: str = _CODE


class Confirmation(Schema):
    """Prove anew that it is you.

    ``password``, and ``code`` of the second factor where you have one; or ``credential``, the
    answer of a passkey: in place of the code, and of the password too where its device has
    verified you (by a PIN, a finger, a face).
    """

    password: str = Field("", max_length=4096)
    code: str = Field("", max_length=64)
    credential: dict[str, Any] | None = None


class RemoveFactor(Schema):
    """Prove both, to sign in without the second factor from now on."""

    password: str = _PASSWORD
    code: str = _CODE


class FactorOffer(Schema):
    """A secret for an authenticator: as text, as a link, and as an SVG picture of the link."""

    secret: str
    uri: str
    qr: str


class RecoveryCodes(Schema):
    """Each opens once in place of a code. They are shown this once."""

    recovery: list[str]


class PasskeyShape(Schema):
    """One of your passkeys; ``host`` is the name of the hub for which it was made."""

    id: str
    name: str
    host: str
    created_us: int
    used_us: int  # UTC; 0: never


class PasskeyList(Schema):
    """Your passkeys, the oldest first; ``codes``: you have an authenticator with codes besides.

    ``possible``: one can be made here; browsers make none for an IP address.
    """

    passkeys: list[PasskeyShape]
    codes: bool
    possible: bool


class PasskeyOptions(Schema):
    """What the browser's ``navigator.credentials`` takes (WebAuthn, level 3, as JSON)."""

    options: dict[str, Any]


class PasskeyOptionsAsk(Schema):
    """Begin to sign in by passkey: with name and password as a second factor, without alone."""

    name: str = Field("", max_length=200)
    password: str = Field("", max_length=4096)


class PasskeySignIn(Schema):
    """The answer of a passkey (WebAuthn's ``PublicKeyCredential`` as JSON)."""

    credential: dict[str, Any]


class PasskeyAsk(Schema):
    """Keep a passkey that the browser has made, under a name of yours."""

    name: str = _NAME
    credential: dict[str, Any]


class PasskeyName(Schema):
    """Call a passkey of yours otherwise."""

    name: str = _NAME


class PasskeyAdded(Schema):
    """It is kept. Where it is your first second factor, recovery codes; shown this once."""

    id: str
    recovery: list[str]


class OidcProvider(Schema):
    """The provider by which people can sign in; ``label`` is its name, empty: there is none."""

    label: str


class OidcConnection(Schema):
    """Whether the provider signs you in."""

    connected: bool


class OidcReturn(Schema):
    """The page to come back to."""

    returns: str = Field("/", max_length=2000, pattern=r"^/([^/\\].*)?$")


class OidcStart(Schema):
    """Where the browser goes to sign in at the provider."""

    url: str


class OidcAnswer(Schema):
    """What the provider sent the browser back with; ``iss`` where it names itself."""

    state: str = Field(min_length=1, max_length=500)
    code: str = Field("", max_length=4000)
    iss: str = Field("", max_length=500)
    error: str = Field("", max_length=500)


class OidcDone(Schema):
    """What was done, ``sign_in``, ``confirm`` or ``connect``, and the page that was asked for."""

    purpose: str
    returns: str


class SessionShape(Schema):
    """Where you are signed in; ``agent`` is what the browser calls itself."""

    id: str
    created_us: int
    used_us: int
    address: str
    agent: str
    this: bool


class SessionList(Schema):
    """Your sessions, the last used first."""

    sessions: list[SessionShape]


class TokenShape(Schema):
    """A token for a script; what it says was shown once and is not kept."""

    id: str
    name: str
    permissions: list[PermissionShape]
    created_us: int
    ends_us: int  # UTC
    used_us: int  # UTC; 0: never


class TokenList(Schema):
    """Your tokens that have not ended, the newest first."""

    tokens: list[TokenShape]


class TokenAsk(Schema):
    """Make a token with some of your rights (view and use), until an end date."""

    name: str = _NAME
    ends_us: int = Field(ge=0, le=2**53)
    permissions: list[PermissionShape] = Field(max_length=_MOST_PERMISSIONS)


class NewToken(Schema):
    """The token, shown this once. Send it as ``Authorization: Bearer …``."""

    id: str
    token: str


class DisplayShape(Schema):
    """A screen that shows some sites and does nothing else."""

    id: str
    name: str
    sites: list[str]
    created_us: int
    used_us: int  # UTC; 0: never


class DisplayList(Schema):
    """All displays, the newest first."""

    displays: list[DisplayShape]


class DisplayAsk(Schema):
    """Make a display that shows these sites."""

    name: str = _NAME
    sites: list[str] = Field(min_length=1, max_length=_MOST_SITES)


class NewDisplay(Schema):
    """The token, shown this once. Its screen opens ``/display#`` and the token behind it."""

    id: str
    token: str


class DisplayOpenAsk(Schema):
    """Come in as a display."""

    token: str = Field(min_length=1, max_length=200)


class PersonShape(Schema):
    """A person; ``sessions`` counts where they are signed in now.

    ``provider``: the provider of sign-ins signs them in.
    """

    id: str
    name: str
    role: str
    disabled: bool
    factor: bool
    created_us: int
    used_us: int
    sessions: int
    provider: bool


class PersonList(Schema):
    """Everyone, by name."""

    people: list[PersonShape]


class PersonAsk(Schema):
    """Add a person."""

    name: str = _NAME
    password: str = _PASSWORD
    role: str = _NAME


class PersonChange(Schema):
    """Change what is given; the person's sessions end."""

    role: str | None = Field(default=None, min_length=1, max_length=200)
    disabled: bool | None = None
    password: str | None = Field(default=None, max_length=4096)


class RoleShape(Schema):
    """A role; ``people`` counts those who have it.

    ``factor_required``: they need a second factor, and set one up before anything else.
    """

    id: str
    name: str
    seeded: bool
    people: int
    factor_required: bool
    permissions: list[PermissionShape]


class RoleList(Schema):
    """Every role, the seeded ones first."""

    roles: list[RoleShape]


class FactorNeed(Schema):
    """Whether a role requires a second factor."""

    required: bool


class RoleAsk(Schema):
    """A role's name and all its permissions."""

    name: str = _NAME
    permissions: list[PermissionShape] = Field(max_length=_MOST_PERMISSIONS)


class DeviceSummary(Schema):
    """A device that is open to you.

    ``signals`` counts what you may see of it, ``stale`` those of them that are older than their
    limit or have never come; ``public``: something of it is visible to guests.
    """

    site: str
    site_name: str
    device: str
    name: str
    kind: DeviceKind
    online: bool
    rights: list[Right]
    public: bool
    signals: int
    stale: int


class DeviceList(Schema):
    """All devices that are open to you, by site."""

    devices: list[DeviceSummary]


class UnitChoice(Schema):
    """A unit of values that you may see, and in which others they can be shown.

    ``name`` is in English words; ``sites`` have values in it. ``shown`` is your choice, or empty.
    """

    unit: str
    name: str
    sites: list[str]
    shown: str
    choices: list[str]


class UnitChoiceList(Schema):
    """Your choices; units that can be shown in no other are left out."""

    units: list[UnitChoice]


class UnitChoiceAsk(Schema):
    """What to show in what: stored unit to shown unit. What is not named is as the site has it."""

    shown: dict[_Unit, _Unit] = Field(max_length=_MOST)
