"""The signed file of a release: a ZIP of wheels, of a list with their hashes, and its signature."""

from __future__ import annotations

import hashlib
import re
import zipfile
import zlib
from typing import TYPE_CHECKING, Annotated, NamedTuple

import msgspec
from cryptography.exceptions import InvalidSignature
from cryptography.hazmat.primitives.asymmetric.ed25519 import (
    Ed25519PrivateKey,
    Ed25519PublicKey,
)
from msgspec import Meta

from talaia.updates.errors import UpdateError, UpdateRefused
from talaia.updates.slots import version_order

if TYPE_CHECKING:
    from collections.abc import Sequence
    from pathlib import Path

__all__ = [
    "ReleaseManifest",
    "SignedRelease",
    "open_release",
    "public_key_of",
    "read_unproven",
    "sign_release",
    "version_of_wheels",
]

_FORM = 1
_MANIFEST, _SIGNATURE = "manifest.json", "manifest.sig"
# Said before what is signed, so that no signature for another purpose is one for this.
_PURPOSE = b"talaia release 1\n"
# Bytes; a wheel of Talaia has 15 MB, all that a gateway needs some 150.
_MOST_MANIFEST, _MOST_FILE, _MOST_ALL = 1 << 20, 1 << 29, 1 << 30
_MOST_FILES = 500
# As wheels are named, and no path.
_WHEEL = re.compile(r"[A-Za-z0-9][A-Za-z0-9_.+!\-]{0,200}\.whl\Z")
# NAME-VERSION-PYTHON-ABI-PLATFORM.whl, with a build number or without.
_OWN_WHEEL = re.compile(r"talaia-([^-]+)-(?:[^-]+-){2,3}[^-]+\.whl\Z", re.IGNORECASE)


class ReleaseManifest(msgspec.Struct, frozen=True, kw_only=True, forbid_unknown_fields=True):
    """What is signed.

    Attributes:
        form: how the file is made; others are refused.
        version: of Talaia, as its wheel says it.
        site: the gateway it is for; empty for all.
        files: SHA-256 (hexadecimal) of each wheel by its name.

    """

    form: int
    version: Annotated[str, Meta(max_length=40)]
    site: Annotated[str, Meta(max_length=63)] = ""
    files: Annotated[
        dict[str, Annotated[str, Meta(pattern=r"^[0-9a-f]{64}\Z")]], Meta(min_length=1)
    ]


class SignedRelease(NamedTuple):
    """A release whose signature holds.

    Attributes:
        path: the file.
        manifest: what it says.

    """

    path: Path
    manifest: ReleaseManifest

    def unpack_wheels(self, folder: Path) -> list[Path]:
        """Write the wheels into a folder, each held against its hash.

        Raises:
            UpdateRefused: a file is missing, cut off, too large, or another one.

        """
        written: list[Path] = []
        left = _MOST_ALL
        try:
            with zipfile.ZipFile(self.path) as archive:
                for name, digest in self.manifest.files.items():
                    left -= _copy_member(archive, folder / name, digest, min(left, _MOST_FILE))
                    written.append(folder / name)
        except (OSError, zipfile.BadZipFile, KeyError, EOFError, zlib.error) as error:
            raise UpdateRefused(f"{self.path.name} is not whole: {error}") from error
        return written


def version_of_wheels(wheels: Sequence[Path]) -> str:
    """Give the version of Talaia among these wheels, by the name of its file.

    Raises:
        UpdateError: none of them is Talaia's, or several are.

    """
    found = {match[1] for wheel in wheels if (match := _OWN_WHEEL.match(wheel.name))}
    if len(found) != 1:
        said = "none of them is" if not found else f"{len(found)} of them are"
        raise UpdateError(
            f"a release has one wheel of Talaia, as talaia-1.2.3-py3-none-any.whl: {said}"
        )
    return found.pop()


def sign_release(
    wheels: Sequence[Path], target: Path, key: Ed25519PrivateKey, *, version: str, site: str = ""
) -> None:
    """Write a release of these wheels, which is not there yet.

    Raises:
        UpdateError: a wheel cannot be read, or the file is there.

    """
    version_order(version)
    try:
        files = {wheel.name: hashlib.sha256(wheel.read_bytes()).hexdigest() for wheel in wheels}
        for name in files:
            _check_name(name)
        manifest = msgspec.json.encode(
            ReleaseManifest(form=_FORM, version=version, site=site, files=files)
        )
        with zipfile.ZipFile(target, "x") as archive:
            archive.writestr(_MANIFEST, manifest)
            archive.writestr(_SIGNATURE, key.sign(_PURPOSE + manifest))
            for wheel in wheels:
                archive.write(wheel, wheel.name)
    except OSError as error:
        raise UpdateError(f"the release cannot be written: {error}") from error


def open_release(path: Path, keys: Sequence[Ed25519PublicKey], site: str) -> SignedRelease:
    """Read a release's list; one of the keys must have signed it, for this site or for all.

    Raises:
        UpdateRefused: nobody who may has signed it, or it is for another gateway.

    """
    manifest, signature = _read_list(path)
    # Before anything of it is read: what nobody has signed may be made to harm whoever parses it.
    if not any(_has_signed(key, signature, manifest) for key in keys):
        raise UpdateRefused(f"{path.name} is signed by nobody whom this gateway trusts")
    said = _decode_list(path, manifest)
    if said.site and said.site != site:
        raise UpdateRefused(f"{path.name} is for the gateway of {said.site}, not for {site}")
    if len(said.files) > _MOST_FILES:
        raise UpdateRefused(f"{path.name} has more than {_MOST_FILES} files")
    version_order(said.version)
    for name in said.files:
        _check_name(name)
    return SignedRelease(path, said)


def read_unproven(path: Path) -> ReleaseManifest:
    """Read a release's list without asking who has signed it: to show it, never to install it.

    Raises:
        UpdateRefused: it is no release.

    """
    manifest, _signature = _read_list(path)
    said = _decode_list(path, manifest)
    version_order(said.version)
    return said


def public_key_of(text: str) -> Ed25519PublicKey:
    """Read a publisher's key: 64 hexadecimal digits.

    Raises:
        UpdateError: it is none.

    """
    try:
        return Ed25519PublicKey.from_public_bytes(bytes.fromhex(text.strip()))
    except ValueError as error:
        raise UpdateError("a publisher's key is 64 hexadecimal digits") from error


def _read_list(path: Path) -> tuple[bytes, bytes]:
    """Give the list of a release, and what is said to be its signature."""
    try:
        with zipfile.ZipFile(path) as archive:
            manifest = _read_member(archive, _MANIFEST, _MOST_MANIFEST)
            return manifest, _read_member(archive, _SIGNATURE, 64)
    # The library's own words for what it does not know: encrypted, packed in another way.
    except (
        OSError,
        zipfile.BadZipFile,
        KeyError,
        EOFError,
        zlib.error,
        RuntimeError,
    ) as error:
        raise UpdateRefused(f"{path.name} is no release, or is not whole: {error}") from error


def _decode_list(path: Path, manifest: bytes) -> ReleaseManifest:
    try:
        said = msgspec.json.decode(manifest, type=ReleaseManifest)
    except msgspec.DecodeError as error:
        raise UpdateRefused(f"{path.name} is of another form: {error}") from error
    if said.form != _FORM:
        raise UpdateRefused(f"{path.name} is of form {said.form}; this program reads {_FORM}")
    return said


def _has_signed(key: Ed25519PublicKey, signature: bytes, manifest: bytes) -> bool:
    try:
        key.verify(signature, _PURPOSE + manifest)
    except InvalidSignature:
        return False
    return True


def _check_name(name: str) -> None:
    if not _WHEEL.match(name):
        raise UpdateRefused(f"{name[:80]!r} is no name of a wheel")


def _read_member(archive: zipfile.ZipFile, name: str, most: int) -> bytes:
    with archive.open(name) as file:
        content = file.read(most + 1)
    if len(content) > most:
        raise UpdateRefused(f"{name} is too large")
    return content


def _copy_member(archive: zipfile.ZipFile, target: Path, digest: str, most: int) -> int:
    """Write one file, and give its length."""
    known, size, name = hashlib.sha256(), 0, target.name
    with archive.open(name) as source, target.open("xb") as file:
        while piece := source.read(1 << 20):
            size += len(piece)
            # What it says of its own length is not what comes out of it.
            if size > most:
                raise UpdateRefused(f"{name} is too large")
            known.update(piece)
            file.write(piece)
    if known.hexdigest() != digest:
        raise UpdateRefused(f"{name} is not the file that was signed")
    return size
