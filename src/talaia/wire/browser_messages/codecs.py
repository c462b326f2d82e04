"""The closed lists of messages of each socket between hub and browser."""

from __future__ import annotations

from talaia.wire.browser_messages.alarm_updates import AlarmUpdate, AnomalyUpdate, SightingUpdate
from talaia.wire.browser_messages.camera import (
    BoxesRequest,
    CameraPicture,
    CameraPictureBoxes,
    CameraPictureOverlay,
    PictureShown,
    ViewerAttention,
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
from talaia.wire.gateway_messages.field_types import MAX_PICTURE
from talaia.wire.message import Codec

__all__ = [
    "FROM_BROWSER",
    "MEDIA_FROM_BROWSER",
    "MEDIA_TO_BROWSER",
    "TOPIC_FROM_BROWSER",
    "TOPIC_TO_BROWSER",
    "TO_BROWSER",
    "FromBrowser",
    "MediaFromBrowser",
    "MediaToBrowser",
    "ToBrowser",
    "TopicFromBrowser",
    "TopicToBrowser",
]

FromBrowser = (
    Subscribe
    | Unsubscribe
    | PageLease
    | PageLeaseForce
    | PageDrive
    | PageTwin
    | PageTwinDrive
    | PageStop
    | PageReset
    | PageCommand
    | PageCommandCancel
    | PageOverride
    | PagePing
)


ToBrowser = (
    Greeting
    | SiteUpdate
    | Subscribed
    | Values
    | LeaseUpdate
    | TickUpdate
    | DriveUpdate
    | TwinUpdate
    | StopUpdate
    | HeldStopUpdate
    | ResetTokenUpdate
    | CommandUpdate
    | InterlockUpdate
    | DeviceUpdate
    | AlarmUpdate
    | SightingUpdate
    | AnomalyUpdate
    | EventUpdate
    | NightUpdate
    | NightPlanUpdate
    | ObservingRequestUpdate
    | PagePong
    | RequestError
    | SessionUpdate
    | SessionEnded
)


# Errors and the end of a session come on each socket: the page may have only this one open. A ping
# is answered by the clock that pictures are stamped by: of several hubs another one may answer it
# on the page's other socket.
MediaToBrowser = (
    CameraPicture
    | CameraPictureBoxes
    | CameraPictureOverlay
    | PagePong
    | RequestError
    | SessionEnded
)


MediaFromBrowser = PictureShown | ViewerAttention | BoxesRequest | PagePing


TopicToBrowser = TopicUpdate | TopicMessage | TopicBytes | RequestError | SessionEnded


TopicFromBrowser = TopicShown


# The largest is a subscription to thousands of channels.
FROM_BROWSER: Codec[FromBrowser] = Codec(FromBrowser, 1024 * 1024)


TO_BROWSER: Codec[ToBrowser] = Codec(ToBrowser)


MEDIA_TO_BROWSER: Codec[MediaToBrowser] = Codec(MediaToBrowser, MAX_PICTURE)


# Numbers and flags only, in the JSON form too.
MEDIA_FROM_BROWSER: Codec[MediaFromBrowser] = Codec(MediaFromBrowser, 4096)


# A tree takes up to six bytes a character, beside a few fields.
TOPIC_TO_BROWSER: Codec[TopicToBrowser] = Codec(TopicToBrowser, 8 * MAX_TREE)


TOPIC_FROM_BROWSER: Codec[TopicFromBrowser] = Codec(TopicFromBrowser, 4096)
