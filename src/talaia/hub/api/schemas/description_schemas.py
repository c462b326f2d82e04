"""Bodies of the routes that show and change a site's description."""

from __future__ import annotations

from typing import Any, Literal

from pydantic import Field

from talaia.hub.api.schemas.common import Schema
from talaia.model.yaml_text.diff import ChangeKind  # noqa: TC001 - pydantic reads it

__all__ = [
    "ChangeAnswer",
    "CheckAnswer",
    "CheckAsk",
    "DescribeAsk",
    "DescriptionList",
    "DescriptionText",
    "DifferenceAnswer",
    "DifferenceShape",
    "EditAnswer",
    "EditAsk",
    "FindingShape",
    "RestoreAsk",
    "VersionShape",
]

# Characters; the link bounds the bytes (`wire.sealing.MAX_TEXT`).
_MOST = 4 * 1024 * 1024
_TEXT = Field(max_length=_MOST)
_DIGEST = Field(pattern="^[0-9a-f]{64}$")  # SHA-256


class FindingShape(Schema):
    """What does not fit: where, what, what to do; line and column from 1, 0 if not known.

    ``note``: worth a word, and no reason not to use it.
    """

    where: str
    problem: str
    remedy: str
    line: int
    column: int
    note: bool = False


class VersionShape(Schema):
    """A description that counted from ``time_us`` on.

    ``who`` sent it through the hub, empty when it was changed at the gateway; ``current`` is what
    counts now.
    """

    number: int
    digest: str
    time_us: int
    gateway: int
    who: str
    note: str
    current: bool


class DescriptionList(Schema):
    """A site's versions, the newest first, and whether another can be sent.

    ``accepts`` is what the gateway takes from the hub: ``no``, ``readings`` or ``all``; empty when
    it does not say. ``findings`` are of the file as it stands at the gateway and is not used.
    """

    zone: str
    online: bool
    accepts: str
    editable: bool
    digest: str
    versions: list[VersionShape]
    more: bool
    problem: str
    findings: list[FindingShape]


class DescriptionText(Schema):
    """A version's text, and what it says as JSON; ``site`` is null where it cannot be read."""

    number: int
    digest: str
    text: str
    site: dict[str, Any] | None


class DifferenceShape(Schema):
    """A part that is not the same in two versions."""

    kind: ChangeKind
    path: str
    before: str
    after: str


class DifferenceAnswer(Schema):
    """Two versions held against each other; ``lines`` begin with ``+``, ``-``, a blank or ``@@``.

    ``long``: there are more lines than are given.
    """

    before: int
    after: int
    parts: list[DifferenceShape]
    lines: list[str]
    long: bool


class CheckAsk(Schema):
    """A description's text to look at; ``against`` is a version to hold it against, 0 for none."""

    text: str = _TEXT
    against: int = Field(default=0, ge=0, le=2**53)


class CheckAnswer(Schema):
    """What does not fit in it, and what it says as JSON; null where it cannot be read.

    ``parts`` and ``lines`` are what differs from the version it was held against.
    """

    findings: list[FindingShape]
    site: dict[str, Any] | None
    parts: list[DifferenceShape]
    lines: list[str]


class EditAsk(Schema):
    """A text, and what it is to say instead; comments and order stay where they can."""

    text: str = _TEXT
    site: dict[str, Any]


class EditAnswer(Schema):
    """The text that says it; empty where that does not have the shape of a description."""

    text: str
    findings: list[FindingShape]


class DescribeAsk(Schema):
    """Go by this text; ``base`` is the SHA-256 of the text that it was made from."""

    text: str = _TEXT
    base: str = _DIGEST


class RestoreAsk(Schema):
    """Go back; ``base`` is the SHA-256 of what counts now, as the person saw it."""

    base: str = _DIGEST


class ChangeAnswer(Schema):
    """How it ended: ``applied``, ``refused``, or ``unknown`` when nobody answered in time."""

    phase: Literal["applied", "refused", "unknown"]
    message: str
    findings: list[FindingShape]
