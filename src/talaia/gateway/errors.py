"""What can go wrong beside the robot.

GatewayError
├── FieldError          a message does not hold what the description says
├── TypeMissing         a message or service type that this machine does not know
├── AdapterLost         the robot's side cannot be reached
├── ChannelNumbersFull  too many channels have been described since the start
├── SpoolError          the data folder cannot be used
├── SettingsError       the gateway was started with settings that do not fit
├── AssetUnavailable    a file of a robot is not handed to the hub
├── CameraRefused       a camera leads where no camera may be (adapters.video.relay)
├── FetchFailed         a server gives no answer that can be read (adapters.http.fetching)
│   ├── ServerNotReached  nothing was sent
│   └── StatusRefused     it answers with a status that is no success
├── AlpacaRefused       a device answers with an error (adapters.alpaca.protocol)
├── CameraFault         a camera answers that it does not do it (adapters.onvif.soap)
├── UnreadableXml       it is no XML, or too much of it (adapters.onvif.xml_nodes)
├── ProgramRefused      a request is not served (adapters.socketio.asgi_requests)
├── EnrolRefused        the hub does not take the one-time code
└── LinkLost            the hub cannot be reached
    ├── HubUnreachable    it could not be asked, when enrolling
    ├── RetryLater        the hub has no place for us now
    └── KeyRefused        the hub does not know our key
"""

from __future__ import annotations

from talaia.errors import TalaiaError

__all__ = [
    "AdapterLost",
    "AssetUnavailable",
    "ChannelNumbersFull",
    "EnrolRefused",
    "FieldError",
    "GatewayError",
    "HubUnreachable",
    "KeyRefused",
    "LinkLost",
    "RetryLater",
    "SettingsError",
    "SpoolError",
    "TypeMissing",
]


class GatewayError(TalaiaError):
    """A robot, a device or the spool failed."""


class FieldError(GatewayError):
    """A message does not hold what the description says."""

    def __init__(self, path: str, problem: str) -> None:
        """Keep the field's path and what is wrong with it."""
        super().__init__(path, problem)
        self.path = path
        self.problem = problem

    def __str__(self) -> str:
        return f"field {self.path!r}: {self.problem}" if self.path else self.problem


class AssetUnavailable(GatewayError):
    """A file of a robot that is not handed to the hub; a sentence for people."""


class TypeMissing(GatewayError):
    """A message or service type that this machine does not know."""

    def __init__(self, name: str, used_by: str, why: str = "") -> None:
        """Keep the type's name, who needs it, and why it cannot be read without its package."""
        super().__init__(name, used_by, why)
        self.name = name
        self.used_by = used_by
        self.why = why

    def __str__(self) -> str:
        package = self.name.split("/", 1)[0]
        why = f" ({self.why})" if self.why else ""
        return (
            f"{self.used_by} is of type {self.name}, which this machine does not know; "
            f"install the ROS package {package} where the gateway runs{why}"
        )


class AdapterLost(GatewayError):
    """The robot's side cannot be reached."""


class ChannelNumbersFull(GatewayError):
    """Too many channels have been described since the start."""


class SpoolError(GatewayError):
    """The data folder cannot be used."""


class SettingsError(GatewayError):
    """The gateway was started with settings that do not fit."""


class EnrolRefused(GatewayError):
    """The hub does not take the one-time code."""

    def __init__(self, code: str, sentence: str) -> None:
        """Keep the hub's word for programs, and its sentence for people."""
        super().__init__(code, sentence)
        self.code = code
        self.sentence = sentence

    def __str__(self) -> str:
        return self.sentence


class LinkLost(GatewayError):
    """The hub cannot be reached, or stopped answering."""


class HubUnreachable(LinkLost):
    """The hub could not be asked: it is not there, or is not the one that was meant."""


class RetryLater(LinkLost):
    """The hub is there, and has no place for us now; ``after_s`` is when to come back, if said."""

    def __init__(self, problem: str, after_s: float = 0.0) -> None:
        """Keep what the hub said."""
        super().__init__(problem)
        self.after_s = after_s


class KeyRefused(LinkLost):
    """The hub does not know our key."""

    def __init__(self, status: int, hub: str) -> None:
        """Keep the HTTP status and who said so."""
        super().__init__(status, hub)
        self.status = status
        self.hub = hub

    def __str__(self) -> str:
        return (
            f"{self.hub} refuses this gateway's key (HTTP {self.status}); "
            "enrol the gateway again or give another --key-file"
        )
