"""Every message between hub and browser.

Three kinds of sockets: ``/ws`` for all but pictures and raw topics, one
``/ws/media?site=…&stream=…`` for each camera that a page shows, and one
``/ws/topic?site=…&topic=…`` for each raw topic. MessagePack by default; ``?form=json`` gives the
JSON form. The session cookie (or a token) says who it is; rights are checked on every message, both
ways.

The messages stand in `browser_messages`, by subject; this is the one place to import them from.
"""

from __future__ import annotations

from talaia.wire.browser_messages.alarm_updates import (
    AlarmUpdate,
    AnomalyShare,
    AnomalyUpdate,
    SightingUpdate,
)
from talaia.wire.browser_messages.camera import (
    BoxesRequest,
    CameraPicture,
    CameraPictureBoxes,
    PictureShown,
    ViewerAttention,
)
from talaia.wire.browser_messages.codecs import (
    FROM_BROWSER,
    MEDIA_FROM_BROWSER,
    MEDIA_TO_BROWSER,
    TO_BROWSER,
    TOPIC_FROM_BROWSER,
    TOPIC_TO_BROWSER,
    FromBrowser,
    MediaFromBrowser,
    MediaToBrowser,
    ToBrowser,
    TopicFromBrowser,
    TopicToBrowser,
)
from talaia.wire.browser_messages.night_updates import (
    NightPlanUpdate,
    NightUpdate,
    ObservingRequestUpdate,
)
from talaia.wire.browser_messages.requests import (
    PageCommand,
    PageCommandCancel,
    PageDrive,
    PageLease,
    PageLeaseForce,
    PageOverride,
    PagePing,
    PageReset,
    PageStop,
    PageTwin,
    PageTwinDrive,
    Subscribe,
    Unsubscribe,
)
from talaia.wire.browser_messages.topics import (
    MAX_RAW,
    MAX_TREE,
    TopicBytes,
    TopicMessage,
    TopicShown,
    TopicUpdate,
)
from talaia.wire.browser_messages.updates import (
    CommandUpdate,
    DeviceUpdate,
    DriveUpdate,
    EventUpdate,
    Greeting,
    HeldStopUpdate,
    InterlockUpdate,
    LeaseUpdate,
    PagePong,
    RequestError,
    ResetTokenUpdate,
    SessionEnded,
    SessionUpdate,
    SiteUpdate,
    StopUpdate,
    Subscribed,
    TickUpdate,
    TwinUpdate,
    Values,
)

__all__ = [
    "FROM_BROWSER",
    "MAX_RAW",
    "MAX_TREE",
    "MEDIA_FROM_BROWSER",
    "MEDIA_TO_BROWSER",
    "TOPIC_FROM_BROWSER",
    "TOPIC_TO_BROWSER",
    "TO_BROWSER",
    "AlarmUpdate",
    "AnomalyShare",
    "AnomalyUpdate",
    "BoxesRequest",
    "CameraPicture",
    "CameraPictureBoxes",
    "CommandUpdate",
    "DeviceUpdate",
    "DriveUpdate",
    "EventUpdate",
    "FromBrowser",
    "Greeting",
    "HeldStopUpdate",
    "InterlockUpdate",
    "LeaseUpdate",
    "MediaFromBrowser",
    "MediaToBrowser",
    "NightPlanUpdate",
    "NightUpdate",
    "ObservingRequestUpdate",
    "PageCommand",
    "PageCommandCancel",
    "PageDrive",
    "PageLease",
    "PageLeaseForce",
    "PageOverride",
    "PagePing",
    "PagePong",
    "PageReset",
    "PageStop",
    "PageTwin",
    "PageTwinDrive",
    "PictureShown",
    "RequestError",
    "ResetTokenUpdate",
    "SessionEnded",
    "SessionUpdate",
    "SightingUpdate",
    "SiteUpdate",
    "StopUpdate",
    "Subscribe",
    "Subscribed",
    "TickUpdate",
    "ToBrowser",
    "TopicBytes",
    "TopicFromBrowser",
    "TopicMessage",
    "TopicShown",
    "TopicToBrowser",
    "TopicUpdate",
    "TwinUpdate",
    "Unsubscribe",
    "Values",
    "ViewerAttention",
]
