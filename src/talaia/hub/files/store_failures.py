"""What an object store's refusals mean, in words. Pure.

What a store answers is never shown: some write keys and signed addresses into it.
"""

from __future__ import annotations

import re
from typing import NamedTuple

__all__ = ["StoreFailure", "describe_failure"]

_CODE = re.compile(r"<Code>([A-Za-z0-9]{1,64})</Code>")
_STATUS = re.compile(r"\bstatus(?: code)?: (\d{3})\b")
_KEY_CODES = frozenset(
    {
        "AccessDenied",
        "AllAccessDisabled",
        "ExpiredToken",
        "InvalidAccessKeyId",
        "InvalidToken",
        "SignatureDoesNotMatch",
    }
)
_FULL_CODES = frozenset(
    {
        "EntityTooLarge",
        "InsufficientCapacity",
        "InsufficientStorage",
        "QuotaExceeded",
        "StorageFull",
        "TooManyBuckets",
        "XMinioAdminBucketQuotaExceeded",
        "XMinioStorageFull",
    }
)
_BUSY_CODES = frozenset({"RequestLimitExceeded", "ServiceUnavailable", "SlowDown"})
_CERTIFICATE = ("InvalidCertificate", "UnknownIssuer", "InvalidMessage", "certificate")


class StoreFailure(NamedTuple):
    """Why a store did not do what was asked.

    Attributes:
        why: in words, after "the store of files".
        remedy: what a person can do.
        full: it has no room, so that reading may go on.

    """

    why: str
    remedy: str
    full: bool = False


def describe_failure(said: str) -> StoreFailure:
    """Say what a store's answer, or the lack of one, means."""
    code = match.group(1) if (match := _CODE.search(said)) else ""
    status = match.group(1) if (match := _STATUS.search(said)) else ""
    # Before it stands what was asked, whose words may be anything.
    inner = said.partition("inner:")[2] or said
    if code in _FULL_CODES or status == "507" or "quota" in code.lower():
        return StoreFailure(f"has no room ({code or status})", "make room there", full=True)
    if code == "NoSuchBucket":
        return StoreFailure("has no such bucket", "make the bucket, or name another")
    if code in {"RequestTimeTooSkewed", "RequestExpired"}:
        return StoreFailure("says that this machine's clock is wrong", "set the clock")
    if code in _KEY_CODES or status in {"401", "403"}:
        return StoreFailure(
            f"refuses the key ({code or status})",
            "the key must be right, and let the hub list, read, write and delete there",
        )
    if code in _BUSY_CODES or status in {"429", "503"}:
        return StoreFailure(f"is busy ({code or status})", "look what it has to do")
    if any(word in inner for word in _CERTIFICATE):
        return StoreFailure(
            "shows a certificate that is not trusted, or none",
            "name its authority with --files-ca",
        )
    if "dns error" in inner:
        return StoreFailure("has a name that is not known", "look at its address")
    if "kind: Connect" in inner or "ConnectionRefused" in inner:
        return StoreFailure("cannot be reached", "look whether it runs, and at its address")
    if "kind: Timeout" in inner or "TimedOut" in inner:
        return StoreFailure("does not answer in time", "look whether it runs and is reached")
    if code or status:
        return StoreFailure(f"answers with {code or status}", "its own log says more")
    return StoreFailure("does not answer", "look whether it runs and is reached")
