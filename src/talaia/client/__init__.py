"""The public interface for scripts and notebooks: a hub's sites, values, history and robots.

A script imports from here and from nowhere else of ``talaia``. What stands here stays as it is
within one `CLIENT_API_VERSION`: it may get more, and nothing goes or means something else. How to
use it is in ``docs/how-to/python-client.md``.
"""

from __future__ import annotations

from talaia.client.async_client import AsyncClient
from talaia.client.drive_session import DriveSession
from talaia.client.errors import (
    BadSettings,
    ClientError,
    CommandNotDone,
    ConfirmationNeeded,
    DrivingRefused,
    HistoryCut,
    HubNotReached,
    HubUntrusted,
    NotFound,
    NotPermitted,
    NotSignedIn,
    ProtocolShut,
    RequestRefused,
    TooManyRequests,
)
from talaia.client.hub_location import HubLocation, find_hub, read_token_file
from talaia.client.sync_client import Client, DriveControl
from talaia.client.times import Moment, parse_moment
from talaia.client.values import (
    ArgumentInfo,
    CommandInfo,
    CommandProgress,
    CommandResult,
    DeviceInfo,
    DriveInfo,
    DriveReport,
    Reading,
    RecordedFile,
    RecorderInfo,
    RecordingOverview,
    SignalInfo,
    SiteInfo,
    SiteOverview,
)

__all__ = [
    "CLIENT_API_VERSION",
    "ArgumentInfo",
    "AsyncClient",
    "BadSettings",
    "Client",
    "ClientError",
    "CommandInfo",
    "CommandNotDone",
    "CommandProgress",
    "CommandResult",
    "ConfirmationNeeded",
    "DeviceInfo",
    "DriveControl",
    "DriveInfo",
    "DriveReport",
    "DriveSession",
    "DrivingRefused",
    "HistoryCut",
    "HubLocation",
    "HubNotReached",
    "HubUntrusted",
    "Moment",
    "NotFound",
    "NotPermitted",
    "NotSignedIn",
    "ProtocolShut",
    "Reading",
    "RecordedFile",
    "RecorderInfo",
    "RecordingOverview",
    "RequestRefused",
    "SignalInfo",
    "SiteInfo",
    "SiteOverview",
    "TooManyRequests",
    "find_hub",
    "parse_moment",
    "read_token_file",
]

CLIENT_API_VERSION = 1
