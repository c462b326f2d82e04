"""The closed lists of messages of each connection between gateway and hub."""

from __future__ import annotations

from talaia.wire.gateway_messages.assets import AssetRequest, AssetState
from talaia.wire.gateway_messages.commands import CommandCancel, CommandRequest, CommandState
from talaia.wire.gateway_messages.description import ChangeRequest, ChangeState, DescriptionUpdate
from talaia.wire.gateway_messages.driving import (
    ControlTick,
    DriveFrame,
    DriveState,
    LeaseForceRequest,
    LeaseRequest,
    LeaseState,
    ResetRequest,
    ResetToken,
    StopRequest,
    StopState,
)
from talaia.wire.gateway_messages.field_types import MAX_PICTURE
from talaia.wire.gateway_messages.files import (
    ArchiveOffer,
    FileOffer,
    FilePiece,
    FileProgress,
    FilmOffer,
    RecorderState,
    RecordingRequest,
)
from talaia.wire.gateway_messages.interlocks import EnclosureState, InterlockState, OverrideRequest
from talaia.wire.gateway_messages.model_overlays import ModelOverlay
from talaia.wire.gateway_messages.night import (
    NightArmRequest,
    NightDisarmRequest,
    NightPlan,
    NightState,
    ObservationAck,
    ObservationUpdate,
    RequestRevision,
    RequestSync,
)
from talaia.wire.gateway_messages.pictures import (
    DetectedBoxes,
    KeyframeRequest,
    PictureFrame,
    SightingReport,
    StreamError,
    StreamSubscription,
)
from talaia.wire.gateway_messages.releases import (
    ReleaseOffer,
    ReleasePiece,
    ReleaseRequest,
    ReleaseState,
)
from talaia.wire.gateway_messages.robot_graph import RobotGraph
from talaia.wire.gateway_messages.robot_log import RobotLogAck, RobotLogBatch
from talaia.wire.gateway_messages.samples import (
    Ack,
    NewestBatch,
    ResendRequest,
    SampleBatch,
    SampleGap,
    SignalSubscription,
)
from talaia.wire.gateway_messages.session import (
    Beat,
    BeatReply,
    Bye,
    DeviceState,
    Event,
    Hello,
    LinkHeld,
    ReconnectRequest,
    ResumeSaved,
    Welcome,
)
from talaia.wire.gateway_messages.taps import (
    TapError,
    TapMessage,
    TapSchema,
    TapSubscription,
    TopicList,
)
from talaia.wire.gateway_messages.twins import TwinFrame, TwinRequest, TwinState
from talaia.wire.message import Codec

__all__ = [
    "FILES_FROM_GATEWAY",
    "FILES_FROM_HUB",
    "LINK_FROM_GATEWAY",
    "LINK_FROM_HUB",
    "MEDIA_FROM_GATEWAY",
    "MEDIA_FROM_HUB",
    "FilesFromGateway",
    "FilesFromHub",
    "FromGateway",
    "FromHub",
    "MediaFromGateway",
    "MediaFromHub",
]

FromGateway = (
    Hello
    | ResumeSaved
    | SampleBatch
    | NewestBatch
    | SampleGap
    | LeaseState
    | ControlTick
    | DriveState
    | TwinState
    | StopState
    | ResetToken
    | CommandState
    | InterlockState
    | EnclosureState
    | RecorderState
    | DeviceState
    | DescriptionUpdate
    | ChangeState
    | SightingReport
    | NightState
    | NightPlan
    | RequestRevision
    | ObservationUpdate
    | ReleaseState
    | RobotLogBatch
    | AssetState
    | Event
    | Beat
    | BeatReply
    | Bye
)


FromHub = (
    Welcome
    | LinkHeld
    | Ack
    | ResendRequest
    | LeaseRequest
    | LeaseForceRequest
    | DriveFrame
    | TwinFrame
    | TwinRequest
    | StopRequest
    | ResetRequest
    | CommandRequest
    | ChangeRequest
    | CommandCancel
    | OverrideRequest
    | StreamSubscription
    | KeyframeRequest
    | TapSubscription
    | SignalSubscription
    | ReconnectRequest
    | RecordingRequest
    | NightArmRequest
    | NightDisarmRequest
    | RequestSync
    | ObservationAck
    | ReleaseOffer
    | RobotLogAck
    | AssetRequest
    | Beat
    | BeatReply
    | Bye
)


MediaFromGateway = (
    PictureFrame
    | StreamError
    | DetectedBoxes
    | ModelOverlay
    | TopicList
    | TapSchema
    | TapMessage
    | TapError
    | RobotGraph
    | Beat
    | BeatReply
)


MediaFromHub = Beat | BeatReply | Bye


FilesFromGateway = FileOffer | FilmOffer | ArchiveOffer | FilePiece | ReleaseRequest


FilesFromHub = FileProgress | ReleasePiece | Bye


# The hello is the largest: a description of up to 4 MiB, and its source.
LINK_FROM_GATEWAY: Codec[FromGateway] = Codec(FromGateway, 8 * 1024 * 1024)


# A change of the description is the largest; see `AskedText`.
LINK_FROM_HUB: Codec[FromHub] = Codec(FromHub, 1024 * 1024)


MEDIA_FROM_GATEWAY: Codec[MediaFromGateway] = Codec(MediaFromGateway, MAX_PICTURE)


MEDIA_FROM_HUB: Codec[MediaFromHub] = Codec(MediaFromHub, 64 * 1024)


# A piece of a file, or an offer that names a thousand topics.
FILES_FROM_GATEWAY: Codec[FilesFromGateway] = Codec(FilesFromGateway, 512 * 1024)


# A piece of a release.
FILES_FROM_HUB: Codec[FilesFromHub] = Codec(FilesFromHub, 128 * 1024)
