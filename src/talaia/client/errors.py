"""What a script cannot do at a hub, each with what to do about it.

ClientError
├── BadSettings         the address, the token or a file is not as it must be
├── HubNotReached       no answer; what only reads may be tried again
├── HubUntrusted        it shows another certificate than the one that is known
├── RequestRefused      the hub said no, with its own words
│   ├── NotSignedIn     the token is not known, has ended or was revoked
│   ├── NotPermitted    the right is missing
│   ├── ProtocolShut    an admin has to open it
│   ├── NotFound        there is no such thing, or it is not for this account
│   └── TooManyRequests ask again later
├── ConfirmationNeeded  a command that wants to be confirmed was not
├── CommandNotDone       a command has not succeeded; only raised where that was asked for
├── DrivingRefused      this account or script may not drive now, or no longer
└── HistoryCut          the answer ended before its end
"""

from __future__ import annotations

from typing import TYPE_CHECKING

from talaia.errors import TalaiaError

if TYPE_CHECKING:
    from talaia.client.values import CommandResult

__all__ = [
    "BadSettings",
    "ClientError",
    "CommandNotDone",
    "ConfirmationNeeded",
    "DrivingRefused",
    "HistoryCut",
    "HubNotReached",
    "HubUntrusted",
    "NotFound",
    "NotPermitted",
    "NotSignedIn",
    "ProtocolShut",
    "RequestRefused",
    "TooManyRequests",
]


class ClientError(TalaiaError):
    """Base of what `talaia.client` raises on purpose."""


class BadSettings(ClientError):
    """The address, the token, or a file that holds them, is not as it must be."""


class HubNotReached(ClientError):
    """The hub does not answer, or the connection was lost."""


class HubUntrusted(ClientError):
    """What answers does not prove to be the hub; nothing was sent to it."""


class HistoryCut(ClientError):
    """An answer ended before its end; what was read of it is not all."""


class DrivingRefused(ClientError):
    """The device is not driven by this script, or no longer; it stops."""


class ConfirmationNeeded(ClientError):
    """A command that people are asked to confirm; nothing was sent."""

    def __init__(self, command: str, name: str) -> None:
        """Keep its address, and what people call it."""
        super().__init__(command, name)
        self.command, self.name = command, name

    def __str__(self) -> str:
        return (
            f"{self.command} ({self.name}) wants to be confirmed; "
            "if it is meant, call it with confirm=True"
        )


class CommandNotDone(ClientError):
    """A command has not succeeded."""

    def __init__(self, result: CommandResult) -> None:
        """Keep what has become of it."""
        super().__init__(result)
        self.result = result

    def __str__(self) -> str:
        said = f": {self.result.message}" if self.result.message else ""
        return f"{self.result.command} {self.result.phase}{said}"


class RequestRefused(ClientError):
    """The hub said no.

    Attributes:
        code: a word for programs, which never changes.
        message: the hub's own sentence.
        remedy: what to do; empty where the sentence says it.

    """

    def __init__(self, code: str, message: str, remedy: str = "") -> None:
        """Keep what the hub said."""
        super().__init__(code, message, remedy)
        self.code, self.message, self.remedy = code, message, remedy

    def __str__(self) -> str:
        return f"{self.message}; {self.remedy}" if self.remedy else self.message


class NotSignedIn(RequestRefused):
    """The token is not known, has ended, or was revoked."""


class NotPermitted(RequestRefused):
    """The token, or its person, does not have the right."""


class ProtocolShut(RequestRefused):
    """An admin has to open what was asked for."""


class NotFound(RequestRefused):
    """There is no such thing, or not for this account; the hub does not tell the two apart."""


class TooManyRequests(RequestRefused):
    """Too much was asked lately.

    Attributes:
        retry_s: when to ask again (s).

    """

    def __init__(self, code: str, message: str, retry_s: float) -> None:
        """Keep when to ask again."""
        super().__init__(code, message, f"ask again in {retry_s:g} s")
        # All of it, so that the error can be pickled and copied.
        self.args = (code, message, retry_s)
        self.retry_s = retry_s
