"""Every message between gateway and hub.

The gateway dials out twice: the *link* (``/gateway/link``) for all but pictures, and *media*
(``/gateway/media``) for pictures and, behind them, raw topics, so that neither ever stands before
a driving frame; and a third time (``/gateway/files``) while it has recordings to hand over. It
proves its key on each, by a challenge (`wire.gateway_proof`): ``Authorization: Talaia site=…`` is
answered by 401 with a number in ``WWW-Authenticate``, and dialled again with the answer to it. The
answer to an upgrade has the number for the next connection (``Authentication-Info``). Gateways of
before 0150 say ``Authorization: Bearer <gateway key>``, and so does one whose hub asks nothing.

The messages stand in `gateway_messages`, by subject; this is the one place to import them from.

Times ending in ``_us`` are microseconds; ``time_us`` is wall time (UTC since the epoch),
``mono_us`` is the sender's own monotonic clock, which only its sender can compare.
"""

from __future__ import annotations

from talaia.wire.gateway_messages.codecs import (
    FILES_FROM_GATEWAY,
    FILES_FROM_HUB,
    LINK_FROM_GATEWAY,
    LINK_FROM_HUB,
    MEDIA_FROM_GATEWAY,
    MEDIA_FROM_HUB,
    FilesFromGateway,
    FilesFromHub,
    FromGateway,
    FromHub,
    MediaFromGateway,
    MediaFromHub,
)
from talaia.wire.gateway_messages.commands import (
    CommandCancel,
    CommandPhase,
    CommandRequest,
    CommandState,
)
from talaia.wire.gateway_messages.description import (
    ChangePhase,
    ChangeRequest,
    ChangeState,
    DescriptionProblem,
    DescriptionUpdate,
)
from talaia.wire.gateway_messages.driving import (
    ControlTick,
    DriveFrame,
    DriveState,
    LeaseForceRequest,
    LeaseOp,
    LeaseRequest,
    LeaseState,
    ResetRequest,
    ResetToken,
    StopRequest,
    StopState,
)
from talaia.wire.gateway_messages.field_types import MAX_PICTURE, PIECE, Scalar
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
from talaia.wire.gateway_messages.night import (
    NightArmRequest,
    NightDisarmRequest,
    NightPhase,
    NightPlan,
    NightState,
    ObservationAck,
    ObservationUpdate,
    RequestRevision,
    RequestSync,
)
from talaia.wire.gateway_messages.pictures import (
    DetectedBoxes,
    DetectedObject,
    KeyframeRequest,
    PictureForm,
    PictureFrame,
    SightingReport,
    StreamError,
    StreamSubscription,
    camera_address,
    unblurred_address,
)
from talaia.wire.gateway_messages.robot_graph import (
    MAX_GRAPH_NAMES,
    MAX_GRAPH_NODES,
    RobotGraph,
    RobotNode,
)
from talaia.wire.gateway_messages.samples import (
    Ack,
    NewestBatch,
    ResendRequest,
    SampleBatch,
    SampleGap,
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
    MAX_TAPPED,
    MAX_TOPICS,
    TapError,
    TapMessage,
    TapSchema,
    TapSubscription,
    TopicEntry,
    TopicList,
)

__all__ = [
    "FILES_FROM_GATEWAY",
    "FILES_FROM_HUB",
    "LINK_FROM_GATEWAY",
    "LINK_FROM_HUB",
    "MAX_GRAPH_NAMES",
    "MAX_GRAPH_NODES",
    "MAX_PICTURE",
    "MAX_TAPPED",
    "MAX_TOPICS",
    "MEDIA_FROM_GATEWAY",
    "MEDIA_FROM_HUB",
    "PIECE",
    "Ack",
    "ArchiveOffer",
    "Beat",
    "BeatReply",
    "Bye",
    "ChangePhase",
    "ChangeRequest",
    "ChangeState",
    "CommandCancel",
    "CommandPhase",
    "CommandRequest",
    "CommandState",
    "ControlTick",
    "DescriptionProblem",
    "DescriptionUpdate",
    "DetectedBoxes",
    "DetectedObject",
    "DeviceState",
    "DriveFrame",
    "DriveState",
    "EnclosureState",
    "Event",
    "FileOffer",
    "FilePiece",
    "FileProgress",
    "FilesFromGateway",
    "FilesFromHub",
    "FilmOffer",
    "FromGateway",
    "FromHub",
    "Hello",
    "InterlockState",
    "KeyframeRequest",
    "LeaseForceRequest",
    "LeaseOp",
    "LeaseRequest",
    "LeaseState",
    "LinkHeld",
    "MediaFromGateway",
    "MediaFromHub",
    "NewestBatch",
    "NightArmRequest",
    "NightDisarmRequest",
    "NightPhase",
    "NightPlan",
    "NightState",
    "ObservationAck",
    "ObservationUpdate",
    "OverrideRequest",
    "PictureForm",
    "PictureFrame",
    "ReconnectRequest",
    "RecorderState",
    "RecordingRequest",
    "RequestRevision",
    "RequestSync",
    "ResendRequest",
    "ResetRequest",
    "ResetToken",
    "ResumeSaved",
    "RobotGraph",
    "RobotNode",
    "SampleBatch",
    "SampleGap",
    "Scalar",
    "SightingReport",
    "StopRequest",
    "StopState",
    "StreamError",
    "StreamSubscription",
    "TapError",
    "TapMessage",
    "TapSchema",
    "TapSubscription",
    "TopicEntry",
    "TopicList",
    "Welcome",
    "camera_address",
    "unblurred_address",
]
