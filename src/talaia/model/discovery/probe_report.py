"""What is out there, as `talaia probe` writes it down and `talaia init` reads it.

Values only: who looked (ROS 2, ROS 1, rosbridge, INDI, Alpaca, ONVIF, MQTT, HTTP) fills them, and
`propose_description` makes a description of them.
The JSON form is the contract between a probe on the robot and a configurator on a laptop.
Long, because that form is one thing, and is read in one place.
"""

from __future__ import annotations

import msgspec

from talaia.errors import TalaiaError
from talaia.model.site import Device  # noqa: TC001 - msgspec reads it

__all__ = [
    "ActionFound",
    "DeviceFound",
    "ElementFound",
    "FieldFound",
    "Found",
    "JointFound",
    "NodeFound",
    "NotAProbe",
    "ParameterFound",
    "PoseFound",
    "PropertyFound",
    "ServiceFound",
    "TopicFound",
    "found_from",
]

# Of the JSON form; raised when another version's reader would take it wrongly.
FORMAT = 1


class NotAProbe(TalaiaError):
    """What was read is not what a probe writes."""


class FieldFound(msgspec.Struct, frozen=True, omit_defaults=True):
    """One number, truth or text inside a message.

    Attributes:
        path: as in `Source.field`: ``pose.position.x``, ``position[0]``.
        type: ``number``, ``integer``, ``boolean`` or ``text``; of a list ``numbers``,
            ``integers``, ``booleans``, ``texts`` or ``bytes``.
        unit: a symbol of `model.units.unit` after ``scale``; empty where nothing tells it.
        scale: what the robot's number is multiplied by to be in ``unit``.
        words: for a whole number that counts states: what 0, 1, 2 … mean.
        name: what the robot calls it (a joint's name); empty where the path says enough.
        empty: every value seen was NaN, so there is probably no such sensor.

    """

    path: str
    type: str
    unit: str = ""
    scale: float = 1.0
    words: tuple[str, ...] = ()
    name: str = ""
    empty: bool = False


class TopicFound(msgspec.Struct, frozen=True, omit_defaults=True):
    """A topic that somebody publishes or listens to.

    Attributes:
        type: ``package/msg/Name``.
        publishers: how many publish it.
        subscribers: how many listen to it, without the probe.
        rate: messages a second, by the spacing of those that came while looking (Hz); 0 where
            fewer than two came.
        latched: the last message is kept for whoever comes later (ROS 2: transient local): it is
            state.
        fields: what can be read of one message.
        names: of a topic that carries many sensors (CloudConnect's ``/metric``, ROS's
            ``/diagnostics``): their names that were heard.
        left_out: what was left out of ``fields`` and why, in words.
        stamped: its messages say themselves of when they are, in a header.
        problem: why it cannot be read at all, in words; empty when it can.

    """

    topic: str
    type: str
    publishers: int = 0
    subscribers: int = 0
    rate: float = 0.0
    latched: bool = False
    fields: tuple[FieldFound, ...] = ()
    names: tuple[str, ...] = ()
    left_out: tuple[str, ...] = ()
    stamped: bool = False
    problem: str = ""


class ServiceFound(msgspec.Struct, frozen=True, omit_defaults=True):
    """A service: its type, and what a request holds."""

    service: str
    type: str
    fields: tuple[FieldFound, ...] = ()
    problem: str = ""


class ActionFound(msgspec.Struct, frozen=True, omit_defaults=True):
    """An action: its type, and what a goal holds."""

    action: str
    type: str
    fields: tuple[FieldFound, ...] = ()
    problem: str = ""


class ParameterFound(msgspec.Struct, frozen=True, omit_defaults=True):
    """A parameter of a node. Its value is left out: a file of a probe is passed around.

    Attributes:
        type: ``number``, ``integer``, ``boolean`` or ``text``.
        read_only: the node never takes another value.
        minimum: what the node takes at least; none where it says no range.

    """

    parameter: str
    type: str
    read_only: bool = False
    minimum: float | None = None
    maximum: float | None = None
    description: str = ""


class NodeFound(msgspec.Struct, frozen=True, omit_defaults=True):
    """A ROS node that has parameters of its own or, in ROS 2, a life cycle.

    Attributes:
        node: absolute, with its name space.
        lifecycle: it has a life cycle (``rclcpp_lifecycle``).
        state: where it is in its life cycle; empty without one.
        publishes: its topics.
        left_out: parameters that are left out and why, in words.

    """

    node: str
    lifecycle: bool = False
    state: str = ""
    publishes: tuple[str, ...] = ()
    parameters: tuple[ParameterFound, ...] = ()
    left_out: tuple[str, ...] = ()


class JointFound(msgspec.Struct, frozen=True, omit_defaults=True):
    """A joint that the robot's model (URDF) names and that can move.

    Attributes:
        type: ``revolute``, ``continuous``, ``prismatic``, as in URDF.
        lower: where it ends, in rad, or m for a prismatic one; none where it does not end.
        upper: the same, at the other end.
        velocity: at most, in rad/s or m/s; none where the model does not say it.
        effort: at most, in N·m or N; none where the model does not say it.

    """

    joint: str
    type: str
    lower: float | None = None
    upper: float | None = None
    velocity: float | None = None
    effort: float | None = None


class PoseFound(msgspec.Struct, frozen=True, omit_defaults=True):
    """A place of joints that has a name (SRDF's ``group_state``).

    Attributes:
        group: the joints that belong together: ``left_arm``.
        joints: where each is to be, in rad or m.

    """

    pose: str
    group: str
    joints: dict[str, float]


class ElementFound(msgspec.Struct, frozen=True, omit_defaults=True):
    """One member of an INDI property.

    Attributes:
        label: what its driver calls it.
        value: as it was, a number in digits; empty for pictures and for what is not known.
        minimum: of a number; equal to ``maximum`` where the driver sets no limit.

    """

    element: str
    label: str = ""
    value: str = ""
    minimum: float = 0.0
    maximum: float = 0.0


class PropertyFound(msgspec.Struct, frozen=True, omit_defaults=True):
    """A property of an INDI device.

    Attributes:
        type: ``number``, ``switch``, ``text``, ``light`` or ``blob``.
        state: ``Idle``, ``Ok``, ``Busy`` or ``Alert``.
        writable: whether a client may set it.

    """

    property: str
    type: str
    label: str = ""
    group: str = ""
    state: str = ""
    writable: bool = False
    elements: tuple[ElementFound, ...] = ()


class DeviceFound(msgspec.Struct, frozen=True, omit_defaults=True):
    """A device that says itself what it is, as INDI's do.

    Attributes:
        device: its name at the server.
        driver: the program behind it, and its version.
        connected: whether the driver has reached its hardware; before that it shows little.
        properties: all that it has.
        word: its word in addresses.
        described: as the site description would have it, by its own words; none for one that is
            not connected, whom the gateway describes when it is.
        address: of a camera: where it is asked.
        profile: of a camera that moves: the token of what is moved.
        problem: why it cannot be described at all, in words; empty when it can.
        left_out: what of it is left out and why, in words.

    """

    device: str
    driver: str = ""
    connected: bool = False
    properties: tuple[PropertyFound, ...] = ()
    word: str = ""
    described: Device | None = None
    address: str = ""
    profile: str = ""
    problem: str = ""
    left_out: tuple[str, ...] = ()


class Found(msgspec.Struct, frozen=True, omit_defaults=True):
    """All that a probe saw.

    Attributes:
        talaia_probe: version of this form; 1.
        protocol: ``ros2``, ``ros1``, ``rosbridge``, ``indi``, ``alpaca``, ``onvif``, ``mqtt``
            or ``http``.
        where: which graph or server, in words.
        seconds: how long was looked (s).
        domain: the ROS domain id; none for other protocols.
        definitions: folder or recording that definitions of types were read from, if there was one.
        sim_time: the robot has a clock of its own, as a simulator's (``/clock``); ROS 1 says so by
            a parameter.
        joints: what can move, by the robot's model (URDF), where one was published.
        poses: what the robot's model (SRDF) calls places of its joints, where one was published.
        master: where the ROS 1 master answers; empty for other protocols.
        host: of the INDI or Alpaca server; empty for other protocols.
        port: of that server.
        ros: which ROS stands behind a rosbridge server, 1 or 2; 0 for other protocols.
        url: of the MQTT broker, rosbridge server or named camera, or the address that a server was
            asked for.
        user: that signed in there.
        password_file: where its password was read; never the password.
        token_file: where a server's token was read.
        ca: file of the authorities that were trusted.

    """

    talaia_probe: int
    protocol: str
    where: str
    seconds: float
    domain: int | None = None
    definitions: str = ""
    sim_time: bool = False
    topics: tuple[TopicFound, ...] = ()
    services: tuple[ServiceFound, ...] = ()
    actions: tuple[ActionFound, ...] = ()
    nodes: tuple[NodeFound, ...] = ()
    joints: tuple[JointFound, ...] = ()
    poses: tuple[PoseFound, ...] = ()
    master: str = ""
    host: str = ""
    port: int = 0
    devices: tuple[DeviceFound, ...] = ()
    ros: int = 0
    url: str = ""
    user: str = ""
    password_file: str = ""
    token_file: str = ""
    ca: str = ""


def found_from(data: bytes, where: str) -> Found:
    """Read what `talaia probe --json` printed.

    Args:
        data: the JSON.
        where: what it was read from, for the message.

    Raises:
        NotAProbe: it is something else, or of another version's form.

    """
    try:
        found = msgspec.json.decode(data, type=Found)
    except (msgspec.DecodeError, UnicodeDecodeError) as error:
        raise NotAProbe(f"{where} is not what `talaia probe --json` prints: {error}") from error
    if found.talaia_probe != FORMAT:
        raise NotAProbe(
            f"{where} is of form {found.talaia_probe}, and this Talaia reads form {FORMAT}; "
            "use the same version at both places"
        )
    return found
