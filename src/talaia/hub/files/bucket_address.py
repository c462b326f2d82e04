"""Where a bucket is and with which key it is opened, as the hub is told at its start."""

from __future__ import annotations

import os
import re
from typing import TYPE_CHECKING, NamedTuple
from urllib.parse import urlsplit

from talaia.hub.errors import CannotStart
from talaia.hub.settings import is_loopback

if TYPE_CHECKING:
    from collections.abc import Mapping
    from pathlib import Path

    from talaia.hub.settings import Settings

__all__ = ["BucketAddress", "BucketKey", "read_bucket_address"]

# Names of buckets by S3's rules; older ones of other stores have an underscore.
_BUCKET = re.compile(r"[a-z0-9A-Z][a-zA-Z0-9._-]{1,61}[a-zA-Z0-9]", re.ASCII)
# Of each folder of the prefix: what every store takes, and no step upwards.
_PREFIX = re.compile(r"[A-Za-z0-9_-][A-Za-z0-9._-]*(/[A-Za-z0-9_-][A-Za-z0-9._-]*)*", re.ASCII)
# Of a file with two lines.
_MOST_KEY = 64 * 1024
# With one of these a machine in a cloud gets a key that changes by itself.
_LENT_KEYS = (
    "AWS_WEB_IDENTITY_TOKEN_FILE",
    "AWS_CONTAINER_CREDENTIALS_RELATIVE_URI",
    "AWS_CONTAINER_CREDENTIALS_FULL_URI",
)
_WRITE_KEY = (
    "write the key's id and its secret into a file, a line each, and name it with"
    " --files-key-file; or set AWS_ACCESS_KEY_ID and AWS_SECRET_ACCESS_KEY"
)


class BucketKey(NamedTuple):
    """What opens a bucket; never shown."""

    id: str
    secret: str
    token: str = ""

    def __repr__(self) -> str:
        return "BucketKey(***)"


class BucketAddress(NamedTuple):
    """A bucket of an object store that speaks S3.

    Attributes:
        bucket: its name.
        prefix: folder in it, without slashes at its ends; empty: the bucket itself.
        endpoint: address of the store; empty: AWS's own, of the region.
        region: of the store; stores of one's own take any.
        key: None: it is lent by the cloud that the hub runs in.
        ca: authorities of the store's certificate (PEM), besides the usual ones; empty: none.

    """

    bucket: str
    prefix: str
    endpoint: str
    region: str
    key: BucketKey | None
    ca: str = ""

    @property
    def url(self) -> str:
        """Write it as a person does."""
        return f"s3://{self.bucket}/{self.prefix}".rstrip("/")

    @property
    def place(self) -> str:
        """Name it for people, with the store that it is in."""
        return f"{self.url} at {self.endpoint}" if self.endpoint else self.url


def read_bucket_address(
    settings: Settings, environment: Mapping[str, str] = os.environ
) -> BucketAddress | None:
    """Read where files are kept; None: in the data folder.

    Raises:
        CannotStart: it is none, or its key cannot be read.

    """
    if not settings.files:
        return None
    bucket, prefix = _read_url(settings.files)
    endpoint = (
        settings.files_endpoint
        or environment.get("AWS_ENDPOINT_URL_S3", "")
        or environment.get("AWS_ENDPOINT_URL", "")
    ).rstrip("/")
    if endpoint:
        _check_endpoint(endpoint)
    region = settings.files_region or environment.get("AWS_REGION", "") or "us-east-1"
    key = _read_key(settings.files_key_file, environment)
    return BucketAddress(bucket, prefix, endpoint, region, key, _read_ca(settings.files_ca))


def _read_url(url: str) -> tuple[str, str]:
    expected = "write it like s3://bucket/folder; its key goes into a file, see --files-key-file"
    parts = urlsplit(url)
    # What does not fit is not shown: it may hold a secret.
    if "@" in parts.netloc or parts.query or parts.fragment:
        raise CannotStart("--files: no key and no question may stand in the address", expected)
    if parts.scheme != "s3" or not _BUCKET.fullmatch(parts.netloc):
        raise CannotStart("--files: expected the address of a bucket", expected)
    prefix = parts.path.strip("/")
    if prefix and not _PREFIX.fullmatch(prefix):
        raise CannotStart(
            f"--files: the folder {prefix!r} has other signs than letters, digits, - _ and .",
            "choose another",
        )
    return parts.netloc, prefix


def _check_endpoint(endpoint: str) -> None:
    parts = urlsplit(endpoint)
    expected = "write it like https://store.example:9000"
    if "@" in parts.netloc or parts.query or parts.fragment:
        raise CannotStart("--files-endpoint: no key may stand in the address", expected)
    if parts.scheme not in {"http", "https"} or not parts.hostname:
        raise CannotStart("--files-endpoint: expected the address of a store", expected)
    if parts.scheme == "http" and not is_loopback(parts.hostname):
        raise CannotStart(
            "--files-endpoint: recordings and pictures would go over the network in clear text",
            "write https:// instead of http://",
        )


def _read_key(file: Path | None, environment: Mapping[str, str]) -> BucketKey | None:
    if file is not None:
        return _key_of_file(file)
    key = BucketKey(
        environment.get("AWS_ACCESS_KEY_ID", ""),
        environment.get("AWS_SECRET_ACCESS_KEY", ""),
        environment.get("AWS_SESSION_TOKEN", ""),
    )
    if key.id and key.secret:
        return key
    if any(environment.get(name) for name in _LENT_KEYS):
        return None
    raise CannotStart("--files: there is no key that opens the bucket", _WRITE_KEY)


def _key_of_file(file: Path) -> BucketKey:
    try:
        with file.open(encoding="utf-8") as lines:
            words = lines.read(_MOST_KEY).split()
    except (OSError, UnicodeDecodeError) as error:
        reason = getattr(error, "strerror", None) or "it is no text"
        raise CannotStart(f"--files-key-file {file} cannot be read: {reason}", _WRITE_KEY) from None
    if len(words) not in {2, 3}:
        raise CannotStart(
            f"--files-key-file {file}: expected two lines, found {len(words)} words", _WRITE_KEY
        )
    return BucketKey(*words)


def _read_ca(file: Path | None) -> str:
    if file is None:
        return ""
    try:
        text = file.read_text(encoding="ascii")
    except (OSError, UnicodeDecodeError) as error:
        reason = getattr(error, "strerror", None) or "it is no PEM"
        raise CannotStart(
            f"--files-ca {file} cannot be read: {reason}", "name a file of certificates (PEM)"
        ) from error
    if "-----BEGIN CERTIFICATE-----" not in text:
        raise CannotStart(
            f"--files-ca {file}: no certificate is in it", "name a file of certificates (PEM)"
        )
    return text
