"""Whether a gateway takes releases from its hub, and whose: a file beside its releases."""

from __future__ import annotations

from typing import TYPE_CHECKING, Annotated

import msgspec
from msgspec import Meta

from talaia.updates.errors import UpdateError
from talaia.updates.signed_release import public_key_of

if TYPE_CHECKING:
    from pathlib import Path

__all__ = ["HubSource", "read_hub_source", "write_hub_source"]

_FILE = "from-hub.json"
_MOST_FILE = 64 * 1024


class HubSource(msgspec.Struct, frozen=True, kw_only=True, forbid_unknown_fields=True):
    """By what a release from the hub is judged and built.

    Attributes:
        publishers: public keys of whoever may sign (hexadecimal).
        system_packages: whether its environment sees the system's own packages.

    """

    publishers: Annotated[list[str], Meta(min_length=1, max_length=100)]
    system_packages: bool = False


def read_hub_source(root: Path) -> HubSource | None:
    """Read it; none: releases come from a person's hands alone.

    Raises:
        UpdateError: it is damaged.

    """
    path = root / _FILE
    try:
        with path.open("rb") as file:
            source = msgspec.json.decode(file.read(_MOST_FILE), type=HubSource)
    except FileNotFoundError:
        return None
    except (OSError, msgspec.DecodeError) as error:
        raise UpdateError(f"{path} cannot be read: {error}") from error
    for key in source.publishers:
        public_key_of(key)
    return source


def write_hub_source(root: Path, source: HubSource) -> None:
    """Write it, in the place of one that is there.

    Raises:
        UpdateError: it cannot be written.

    """
    path = root / _FILE
    try:
        fresh = root / f".{_FILE}"
        fresh.write_bytes(msgspec.json.encode(source))
        fresh.replace(path)
    except OSError as error:
        raise UpdateError(f"{path} cannot be written: {error}") from error
