"""The site description as values: what one robot system has, and what may be asked of it.

All shapes of the description stand here in one place, immutable and without behaviour beyond
look-up. `load` makes them from YAML; `check` says what does not fit together.

An address is ``<device>/<name>``, for example ``base/speed``. A signal that holds more than one
number (a position) has one *channel* for each: ``base/pose.x``. Channels are what the wire and
the history carry: a channel is a number or a text.
"""

from __future__ import annotations

import msgspec

from talaia.model.ai_services import AiServices  # noqa: TC001 - msgspec reads it
from talaia.model.alarms.alarm import Alarm  # noqa: TC001 - msgspec reads it
from talaia.model.alarms.anomaly import SignalGroup, Watch  # noqa: TC001 - msgspec reads them
from talaia.model.base import Shape
from talaia.model.boards.board import Board  # noqa: TC001 - msgspec reads it
from talaia.model.closed_lists import (
    ArgumentType,
    CommandKind,
    CommandRight,
    DeviceKind,
    DriveMessage,
    KeyMode,
    LinkLoss,
    PositionFrame,
    SignalType,
    Visibility,
)
from talaia.model.connection import (
    Connection,
    Ros1Connection,
    Ros2Connection,
    Ros2Settings,
    Source,
    topic_of,
)
from talaia.model.detection import Blur, Detect, LaneView, ObjectModel, SkyLens  # noqa: TC001 - msgspec reads them
from talaia.model.driving.drive import Drive, DrivenJoint, Keys, Stop
from talaia.model.interlocks.enclosure import Enclosure, Place, Pointing  # noqa: TC001 - msgspec reads them
from talaia.model.interlocks.interlock import Interlock, LinkLossPolicy  # noqa: TC001 - msgspec reads them
from talaia.model.interlocks.outlet import Outlet  # noqa: TC001 - msgspec reads it
from talaia.model.maps.site_map import SiteMap  # noqa: TC001 - msgspec reads it
from talaia.model.night_section import NightSection  # noqa: TC001 - msgspec reads it
from talaia.model.picture_models.picture_model import PictureModel  # noqa: TC001 - msgspec reads it
from talaia.model.recording import Recording  # noqa: TC001 - msgspec reads it
from talaia.model.roles import CommandRole, SignalRole, StateMeaning
from talaia.model.topics import TopicRule, blurred_topics
from talaia.model.twins.twin import Twin  # noqa: TC001 - msgspec reads it

__all__ = [
    "NEVER_STALE_S",
    "Argument",
    "ArgumentType",
    "Channel",
    "Command",
    "CommandKind",
    "CommandRight",
    "CommandRole",
    "Device",
    "DeviceKind",
    "Drive",
    "DriveMessage",
    "DrivenJoint",
    "KeyMode",
    "Keys",
    "LinkLoss",
    "PositionFrame",
    "Ros2Settings",
    "Signal",
    "SignalRole",
    "SignalType",
    "Site",
    "Source",
    "StateMeaning",
    "Stop",
    "Stream",
    "Visibility",
    "parts_of",
]

NEVER_STALE_S = 1e9  # Some thirty years: a number that JSON has, unlike infinity.


class Signal(Shape, frozen=True, kw_only=True):
    """Something that can be read.

    Attributes:
        unit: a symbol of `model.units.unit`; numbers only.
        minimum: lowest value that makes sense, in ``unit``; the chart's lower end. Interlocks and
            enclosures take what is below it for an error code: unknown.
        maximum: highest value that makes sense, in ``unit``; what is above it is unknown, too.
        decimals: digits after the point on screen; -1 takes the unit's own.
        max_rate: at most so many samples a second are kept; 0 sets no limit (Hz).
        deadband: a change up to this is not news, in ``unit``.
        max_age: older than this the value is stale (s); 0 for one that holds until another comes,
            as a latched topic's: it never is.
        frozen_after: a number that is the same to the last bit for so long (s) is unknown to
            interlocks, for a sensor that lives is never that still; 0 for one that may be.
        keep: history older than this is dropped (days); 0 keeps it for good.
        role: what it is, by which pages and tiles find it: ``dome.shutter``, ``weather.wind``;
            ``auto`` takes what Talaia proposes, ``none`` has no role.
        states: for a state: what each whole number means, in order.
        meanings: what each of the states means to pages, in order: what its role knows
            (``dome.shutter``: ``closed``, ``open``, …), or else ``normal``, ``warning``, ``error``
            or ``unknown``; left out, English words are understood.
        frame: for a position: metres or degrees.
        yaw_from: for a local position: ``quaternion`` path of the orientation, or empty.
        primary: shown on the first page.
        anomalies: detectors that watch it at the hub; numbers only. See `Watch`.
        was: the address that it had before (``base/speed``), or its name where the device is the
            same: its history goes on under the new one.

    """

    name: str
    source: Source
    type: SignalType = SignalType.NUMBER
    role: SignalRole = SignalRole.AUTO
    unit: str = ""
    minimum: float | None = None
    maximum: float | None = None
    decimals: int = -1
    scale: float = 1.0
    max_rate: float = 0.0
    deadband: float = 0.0
    max_age: float = 5.0
    frozen_after: float = 0.0
    keep: float = 0.0
    states: tuple[str, ...] = ()
    meanings: tuple[StateMeaning, ...] = ()
    frame: PositionFrame = PositionFrame.LOCAL
    yaw_from: str = ""
    primary: bool = True
    visibility: Visibility = Visibility.VIEW
    anomalies: tuple[Watch, ...] = ()
    was: str = ""

    @property
    def stale_after(self) -> float:
        """How old a value may be (s); `NEVER_STALE_S` for one that never is too old."""
        return self.max_age or NEVER_STALE_S


class Stream(Shape, frozen=True, kw_only=True):
    """A camera.

    Attributes:
        max_rate: pictures a second at the most (Hz).
        quality: JPEG quality, 1 to 95.
        kbits: H.264 takes at most this (kbit/s); 0 goes by the size: 1 500 for 640×480 at 30 Hz.
        width: pictures wider than this are made smaller (px); 0 leaves them.
        detect: what is to be seen on its pictures; see `Detect`.
        sky: it looks at all of the sky: a signal of its device may tell the clouds; see `SkyLens`.
        lane: it sees the lane before the vehicle, of which signals of its device tell; see
            `LaneView`.
        models: models of one's own that look at its pictures and tell no boxes, by their names in
            `Site.object_models`; see `PictureModel`.
        blur: faces are made unrecognizable before a picture leaves the gateway; see `Blur`.

    """

    name: str
    source: Source
    max_rate: float = 30.0
    quality: int = 70
    kbits: int = 0
    width: int = 0
    detect: Detect | None = None
    sky: SkyLens | None = None
    lane: LaneView | None = None
    models: dict[str, PictureModel] = {}
    blur: Blur | None = None
    visibility: Visibility = Visibility.VIEW


class Argument(Shape, frozen=True, kw_only=True):
    """One typed argument of a command.

    Attributes:
        field: what it fills: a path into the ROS request, the name of a parameter, an INDI
            element, a parameter of an Alpaca method, ``preset`` of an ONVIF camera, a placeholder
            ``{field}`` of a command line, or a key of an extension.
        max_length: of a text, or of a list as text, in letters.

    """

    type: ArgumentType
    field: str
    name: str = ""
    unit: str = ""
    minimum: float | None = None
    maximum: float | None = None
    max_length: int = 200
    default: float | int | bool | str | None = None


class Command(Shape, frozen=True, kw_only=True):
    """Something a device can be asked to do once.

    Attributes:
        target: the ROS service, topic or action; the node whose parameters are set; the INDI
            property; the Alpaca method (``dome/0/openshutter``); what an ONVIF camera is asked
            (``GotoPreset``); the arguments of a command as one line, without a shell, where
            ``{field}`` stands for an argument; or what an extension is to do, in its own words.
        type: ROS: ``package/srv/Name``, ``package/msg/Name`` or ``package/action/Name``.
        role: what it does, by which pages find it: ``dome.open``, ``telescope.goto``; ``auto``
            takes what Talaia proposes, ``none`` has no role.
        progress: for an action: the path of a number in its feedback, or empty.
        progress_end: the value of ``progress`` that means done; 0 for one that counts down.
        fixed: request fields with values that the asker does not choose, by path.
        arguments: by argument name.
        ttl: not accepted within this time, it is refused (s).
        timeout: accepted but without an answer for this long, its state is unknown (s). The
            feedback of an action counts as an answer.
        confirm: ask the person once more before it is sent.
        right: who may ask for it: ``use`` or ``admin`` on the device. The hub holds it; what the
            gateway does by itself asks for no right.

    """

    name: str
    target: str
    type: str = ""
    kind: CommandKind = CommandKind.SERVICE
    role: CommandRole = CommandRole.AUTO
    description: str = ""
    progress: str = ""
    progress_end: float = 1.0
    fixed: dict[str, float | int | bool | str] = {}
    arguments: dict[str, Argument] = {}
    # A command that waited for long may no longer be what the person wants.
    ttl: float = 5.0
    timeout: float = 10.0
    confirm: bool = False
    right: CommandRight = CommandRight.USE


class Device(Shape, frozen=True, kw_only=True):
    """A part of a site that people think of as one thing.

    Attributes:
        connection: by which connection it is reached; may be left out where there is only one.
        indi: the name of the device at the INDI server.
        setup: INDI: what is written after each connect of its driver, a property to its elements:
            ``WEATHER_UPDATE: {PERIOD: 5}``; what it has before it is connected, such as its port,
            is written before that, too. A driver that is started anew comes with its own
            defaults. Nothing that moves anything.
        link_loss: what is done with it when the hub is out of reach, beside `Drive.link_loss`.
        frames: of a camera that is reached by ROS: the topic of its whole FITS files, of type
            ``std_msgs/msg/UInt8MultiArray``; each goes into the archive. An INDI camera's come
            by themselves.
        pointing: where it may not point, see `Pointing`.
        outlets: of a power device: what each outlet feeds, by its name; see `Outlet`.
        twin: it is simulated, beside the device that is named there; see `Twin`.

    """

    name: str
    kind: DeviceKind = DeviceKind.OTHER
    connection: str = ""
    indi: str = ""
    setup: dict[str, dict[str, bool | float | str]] = {}
    signals: dict[str, Signal] = {}
    streams: dict[str, Stream] = {}
    frames: Source | None = None
    commands: dict[str, Command] = {}
    drive: Drive | None = None
    link_loss: LinkLossPolicy | None = None
    pointing: Pointing | None = None
    outlets: dict[str, Outlet] = {}
    twin: Twin | None = None
    visibility: Visibility = Visibility.VIEW


class Channel(msgspec.Struct, frozen=True):
    """One column of the wire and of the history: a number or a text of a signal."""

    # ``<device>/<signal>``, with ``.<part>`` behind it where there are several.
    address: str
    device: str
    signal: str
    # Empty where the signal is one number or one text.
    part: str
    text: bool


class Site(Shape, frozen=True, kw_only=True):
    """One robot system behind one gateway.

    Attributes:
        talaia: version of the description's format; 1.
        site: short name, for addresses and files.
        name: what people call it.
        zone: the site's time zone, by its IANA name.
        place: where it is on Earth.
        ros2: short for a connection named ``ros2`` of kind ``ros2``.
        connections: the robot protocols, by name; see `talaia.model.connection`.
        interlocks: by name; see `Interlock`.
        recording: raw topics and cameras that are recorded; nothing is where it is left out.
        enclosures: by name; see `Enclosure`.
        night: how it observes by itself; it does not where it is left out. See `NightSection`.
        services: what the hub works out from the site's data; see `AiServices`.
        alarms: by name; see `Alarm`.
        anomaly_groups: signals that are judged together, by name; see `SignalGroup`.
        object_models: models of one's own that look at pictures, by name; see `ObjectModel`.
        topics: who may have which raw topics of the robot; the first rule that fits counts.
            Without one: admins, and those with the right ``tap``. See `TopicRule`.
        boards: grids of tiles that the hub's pages offer, by name; see `Board`.
        shown_units: in which unit pages show values of another, ``°C: °F``, to who chose none.
        map: its local frame on Earth, zones and plans of floors; see `SiteMap`.
        group: under which it stands among many sites; ``tags``: words to find it there.

    """

    talaia: int
    site: str
    name: str
    zone: str = "UTC"
    ros2: Ros2Settings | None = None
    connections: dict[str, Connection] = {}
    devices: dict[str, Device] = {}
    interlocks: dict[str, Interlock] = {}
    recording: Recording | None = None
    place: Place | None = None
    enclosures: dict[str, Enclosure] = {}
    night: NightSection | None = None
    services: AiServices | None = None
    alarms: dict[str, Alarm] = {}
    anomaly_groups: dict[str, SignalGroup] = {}
    object_models: dict[str, ObjectModel] = {}
    topics: tuple[TopicRule, ...] = ()
    boards: dict[str, Board] = {}
    shown_units: dict[str, str] = {}
    map: SiteMap | None = None
    group: str = ""
    tags: tuple[str, ...] = ()

    def links(self) -> dict[str, Connection]:
        """Give every connection by name, ``ros2: {}`` among them."""
        if self.ros2 is None:
            return self.connections
        short = Ros2Connection(**msgspec.structs.asdict(self.ros2))
        # A connection of the same name wins; `check` says that it stands there twice.
        return {"ros2": short, **self.connections}

    def connection_of(self, device: str) -> str:
        """Name the connection of a device; empty when it has none or it is not clear which."""
        links, named = self.links(), self.devices[device].connection
        if named:
            # One that is not there is never replaced by another: it would be read wrongly.
            return named if named in links else ""
        return next(iter(links)) if len(links) == 1 else ""

    def channels(self) -> tuple[Channel, ...]:
        """List every channel, in the order of the description. The order is the wire's index."""
        return tuple(
            Channel(
                f"{device_id}/{signal_id}" + (f".{part}" if part else ""),
                device_id,
                signal_id,
                part,
                signal.type is SignalType.TEXT,
            )
            for device_id, device in self.devices.items()
            for signal_id, signal in device.signals.items()
            for part in parts_of(signal)
        )

    def recorded_topics(self) -> tuple[str, ...]:
        """Name the topics that are recorded, in the order of the description."""
        if self.recording is None:
            return ()
        links = self.links()
        # Only what a node of our own hears can be recorded, nothing behind a rosbridge.
        read = (
            topic_of(signal.source)
            for name, device in self.devices.items()
            if isinstance(links.get(self.connection_of(name)), Ros2Connection | Ros1Connection)
            for signal in device.signals.values()
        )
        hidden = {"", *blurred_topics(self)}  # Of these cameras there are films alone.
        return tuple(x for x in dict.fromkeys(self.recording.topics or read) if x not in hidden)

    def filmed_cameras(self) -> tuple[str, ...]:
        """Name the cameras (``device/stream``) that are filmed with each recording."""
        if self.recording is None:
            return ()
        recorded = (
            f"{name}/{key}"
            for name, device in self.devices.items()
            for key, stream in device.streams.items()
            if topic_of(stream.source) in self.recording.topics
        )
        return tuple(dict.fromkeys((*self.recording.cameras, *recorded)))

    def signal(self, address: str) -> Signal | None:
        """Find a signal by ``device/signal``."""
        device, _, name = address.partition("/")
        described = self.devices.get(device)
        return None if described is None else described.signals.get(name)

    def safety_signals(self) -> frozenset[str]:
        """Name the signals that safety or the night goes by: their newest readings stay at hand."""
        # What says that a robot stands still after STOP.
        drives = [device.drive for device in self.devices.values() if device.drive is not None]
        confirming = {address for drive in drives for address in drive.stop.confirmed_by}
        watched = {a for one in self.interlocks.values() for c in one.when for a in c.signals()}
        for name, device in self.devices.items():
            if device.twin is not None:
                watched |= {f"{name}/{signal}" for signal in ("pose", "mode", "pose_error")}
        for enclosure in self.enclosures.values():
            sensors = (*enclosure.closed, *enclosure.moving, *enclosure.opening)
            watched |= {sensor.signal for sensor in sensors}
            # Segments and the flap, too: the roof is closed only when they are.
            watched |= {s.signal for part in enclosure.parts().values() for s in part.closed}
            watched |= {enclosure.parked.signal} if enclosure.parked is not None else set()
            if (follow := enclosure.follow) is not None:
                watched |= {follow.target, follow.azimuth, follow.when.signal}
                watched |= {sensor.signal for sensor in (follow.moving, follow.open) if sensor}
        watched |= self.night.readings(self.devices) if self.night is not None else set()
        return frozenset(confirming | watched)


def parts_of(signal: Signal) -> tuple[str, ...]:
    """Name the numbers a signal holds; a single one has the empty name.

    A local position has ``x``, ``y`` (m, REP-103: east/forward and north/left) and ``yaw``
    (rad, counter-clockwise); a WGS 84 position has ``lat``, ``lon`` (°) and ``alt`` (m).
    """
    if signal.type is not SignalType.POSITION:
        return ("",)
    return ("lat", "lon", "alt") if signal.frame is PositionFrame.WGS84 else ("x", "y", "yaw")
