"""Files that a robot's description names, such as meshes, on their way from a gateway to its hub.

Asked for and told of on the link; the file itself goes where recordings go, as an `ArchiveOffer` of
the kind ``mesh``, whose id is `asset_file_id`.
"""

from __future__ import annotations

from typing import Annotated

from msgspec import Meta

from talaia.wire.gateway_messages.field_types import Digest, Sentence
from talaia.wire.message import Message

__all__ = ["ASSET_KIND", "MAX_ASSET", "AssetRequest", "AssetState", "asset_file_id"]

# Bytes of one file; a larger one is not handed over.
MAX_ASSET = 32 * 1024 * 1024
# What an `ArchiveOffer` of such a file says of its kind.
ASSET_KIND = "mesh"

_Uri = Annotated[str, Meta(min_length=1, max_length=1000)]
_Size = Annotated[int, Meta(ge=0, le=MAX_ASSET)]


class AssetRequest(Message, frozen=True, kw_only=True, tag="asset_request"):
    """Tell of a file that the robot's description names. Only to gateways whose hello takes it.

    Attributes:
        uri: ``package://…``, or ``file://…``, as the description has it.
        fetch: the hub has no file of that content: hand it over, too.

    """

    uri: _Uri
    fetch: bool = False


class AssetState(Message, frozen=True, kw_only=True, tag="asset_state"):
    """What the gateway knows of such a file now; the answer to each `AssetRequest`.

    Attributes:
        uri: as it was asked for.
        size: bytes.
        digest: SHA-256 of all of it; none where it is not handed out.
        problem: why it is not.

    """

    uri: _Uri
    size: _Size = 0
    digest: Digest | None = None
    problem: Sentence = ""


def asset_file_id(digest: str) -> str:
    """Name a file on its way by its content, so that what has come of it is gone on with."""
    return f"{digest[:32]}-{digest[32:48]}"
