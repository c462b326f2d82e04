"""The file that holds a gateway's key, readable by its owner only.

``talaia gateway enrol`` writes JSON: the key, and with it the hub's address and how it is known.
A file of one line with nothing but a key is read as well.
"""

from __future__ import annotations

import contextlib
import json
import os
from dataclasses import asdict, dataclass, field
from typing import TYPE_CHECKING

from talaia.gateway.errors import SettingsError

if TYPE_CHECKING:
    from pathlib import Path

__all__ = ["KeyFile", "KeyPlace", "read_key_file"]

# Bytes; a key file is a few hundred, and whatever else was named is not read whole.
_LONGEST = 64 * 1024


@dataclass(frozen=True, slots=True, kw_only=True)
class KeyFile:
    """What a key file holds; all but the key may be empty.

    Attributes:
        site: the site the key is for.
        gateway: the gateway's number at the hub.
        hub: ``wss://host:port``.
        fingerprint: SHA-256 (hexadecimal) of the hub's public key; empty: by an authority.
        ca: file of certificate authorities; empty takes the system's.

    """

    key: str = field(repr=False)
    site: str = ""
    gateway: str = ""
    hub: str = ""
    # By an authority, or by the fingerprint; never by both.
    fingerprint: str = ""
    ca: str = ""


def read_key_file(path: Path) -> KeyFile:
    """Read a key file of either form.

    Raises:
        SettingsError: it cannot be read, or holds no key.

    """
    try:
        with path.open(encoding="utf-8") as file:
            text = file.read(_LONGEST).strip()
    except (OSError, UnicodeDecodeError) as error:
        raise SettingsError(f"--key-file {path}: {error}") from error
    # No key begins with a brace, so this tells the two forms apart.
    found = _of_json(path, text) if text.startswith("{") else KeyFile(key=text)
    # Printable ASCII only: it goes into an HTTP header.
    if not found.key or any(ord(letter) <= 32 or ord(letter) > 126 for letter in found.key):
        raise SettingsError(
            f"--key-file {path}: expected the key on one line, or what talaia gateway enrol writes"
        )
    return found


def _of_json(path: Path, text: str) -> KeyFile:
    try:
        said = json.loads(text)
    except ValueError as error:
        raise SettingsError(f"--key-file {path}: {error}; enrol the gateway again") from error
    # Other names may be a newer version's; they are left alone.
    known = {name: said[name] for name in KeyFile.__slots__ if name in said}
    if "key" not in known or not all(isinstance(value, str) for value in known.values()):
        raise SettingsError(f"--key-file {path}: it holds no key; enrol the gateway again")
    return KeyFile(**known)


class KeyPlace:
    """Where a key file will be; made before the code is used, so that no key is lost."""

    def __init__(self, path: Path) -> None:
        """See that a file can be made there.

        Raises:
            SettingsError: the folder cannot be written, or there is another kind of file.

        """
        self._path = path
        # In the same folder, so that it can be moved into place; with our number, so that two who
        # enrol at once do not share it.
        self._fresh = path.with_name(f".{path.name}.{os.getpid()}")
        # An existing file is looked at, so that a mistyped path does not cost somebody's document.
        if path.exists():
            try:
                read_key_file(path)
            except SettingsError as error:
                raise SettingsError(
                    f"--key-file {path} is there and holds no gateway's key; choose another"
                ) from error
        try:
            # Made now and not when there is a key: a folder that cannot be written is told before.
            self._file = os.open(self._fresh, os.O_WRONLY | os.O_CREAT | os.O_EXCL, 0o600)
        except OSError as error:
            raise SettingsError(
                f"--key-file {path} cannot be written: {error.strerror}; choose another place"
            ) from error

    def save_key(self, content: KeyFile) -> None:
        """Put the file in its place, whole and on disk.

        Raises:
            SettingsError: the disk refuses.

        """
        said = {name: value for name, value in asdict(content).items() if value}
        try:
            # Whatever the umask left of the mode.
            os.fchmod(self._file, 0o600)
            os.write(self._file, json.dumps(said, indent=2).encode() + b"\n")
            # On disk before it takes the other's place: a key that is lost cannot be asked for
            # again.
            os.fsync(self._file)
            self._fresh.replace(self._path)
        except OSError as error:
            raise SettingsError(
                f"--key-file {self._path} cannot be written: {error.strerror}; "
                "the code is used up: make a new one on the page"
            ) from error

    def close(self) -> None:
        """Leave nothing half made behind."""
        os.close(self._file)
        with contextlib.suppress(OSError):
            # Moved into place already, as a rule.
            self._fresh.unlink()
