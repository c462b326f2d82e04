"""A file of settings that an option of the hub names: read once, when the hub starts."""

from __future__ import annotations

from typing import TYPE_CHECKING, TypeVar

import msgspec
import yaml

from talaia.hub.errors import CannotStart

if TYPE_CHECKING:
    from pathlib import Path

__all__ = ["read_settings_file"]

SettingsT = TypeVar("SettingsT", bound=msgspec.Struct)


def read_settings_file(
    path: Path, kind: type[SettingsT], *, option: str, about: str, guide: str, most: int
) -> SettingsT:
    """Read a file of YAML as ``kind``; whether what it asks for is safe is the caller's to judge.

    Args:
        path: of the file.
        kind: what it says.
        option: by which it was named, such as ``--mqtt``.
        about: what such a file says, for people.
        guide: of the documentation that tells how it is written; see `talaia docs`.
        most: how long it may be (bytes).

    Raises:
        CannotStart: it cannot be read, or does not say that.

    """
    try:
        with path.open("rb") as file:
            text = file.read(most + 1)
    except OSError as error:
        raise CannotStart(
            f"{option} {path} cannot be read: {error.strerror or error}",
            f"name a file that says {about}; see: talaia docs {guide}",
        ) from error
    if len(text) > most:
        raise CannotStart(f"{option} {path} is over {most} bytes", "name the right file")
    try:
        return msgspec.convert(yaml.safe_load(text), kind)
    except (yaml.YAMLError, msgspec.ValidationError, RecursionError, ValueError) as error:
        raise CannotStart(f"{option} {path}: {error}", f"see: talaia docs {guide}") from error
