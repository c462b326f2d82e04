"""Raw topics of the robot: which may be tapped, by whom, how often; which show whose pictures."""

from __future__ import annotations

import functools
import re
from enum import StrEnum
from fnmatch import fnmatchcase
from typing import TYPE_CHECKING

from talaia.model.base import Shape
from talaia.model.connection import topic_of

if TYPE_CHECKING:
    from collections.abc import Sequence

    from talaia.model.site import Site, Stream

__all__ = [
    "TopicRight",
    "TopicRule",
    "blurred_cameras",
    "blurred_topics",
    "calibrated_cameras",
    "carries_pictures",
    "is_latched_by_convention",
    "matches_topic",
    "rule_of",
]

# Message types that hold pictures of a camera, by the last part of their name: of sensor_msgs and
# stereo_msgs, of Foxglove's schemas, of image_transport's plug-ins (Theora, FFmpeg).
_PICTURES = re.compile(r"(?:Image|Video|Picture|Packet|Disparity)\w*$")
# In the text of a type, a field's type begins its line, and a part's name stands behind MSG.
_PARTS = re.compile(r"^\s*(?:MSG:\s*)?([\w/]+)(?:\[[^]]*\])?", re.MULTILINE)
# What a topic of image_transport is called behind the name that its plug-ins share.
_TRANSPORTS = frozenset({"compressed", "compressedDepth", "theora", "ffmpeg", "zstd"})


# Who publishes these latches them, whether or not anybody says so.
_LATCHED_NAMES = ("tf_static", "robot_description")
_LATCHED_TYPES = ("nav_msgs/msg/OccupancyGrid",)


class TopicRight(StrEnum):
    """The right that a person needs to have a raw topic."""

    VIEW = "view"
    USE = "use"
    ADMIN = "admin"
    TAP = "tap"


class TopicRule(Shape, frozen=True, kw_only=True):
    """Who may have the raw topics whose name a pattern fits; of several rules the first counts.

    Attributes:
        pattern: shell-like, over absolute names: ``*`` and ``?`` stay within one part between
            slashes, ``**`` stands for any number of parts: ``/scan``, ``/camera/**``,
            ``/**/diagnostics``.
        right: what a person needs; those with the right ``tap`` have the topic, too, unless it is
            for admins.
        device: on which device the right is needed; on the whole site where it is left out.
        max_rate: at most so many messages a second are handed on (Hz); 0 sets no limit. Topics
            that are latched, or that come a few times a second, are handed on whole.

    """

    pattern: str
    right: TopicRight
    device: str = ""
    max_rate: float = 0.0


def rule_of(rules: Sequence[TopicRule], topic: str) -> TopicRule | None:
    """Give the first rule whose pattern fits a topic's absolute name."""
    return next((rule for rule in rules if matches_topic(rule.pattern, topic)), None)


def matches_topic(pattern: str, topic: str) -> bool:
    """Tell whether a topic's absolute name fits a pattern; see `TopicRule`."""
    parts = topic.split("/")
    # How many parts of the name the pattern so far can stand for: at most one step for each pair
    # of parts, whatever the pattern, so that none can be slow on purpose.
    reached = {0}
    for word in pattern.split("/"):
        if word == "**":
            reached = set(range(min(reached), len(parts) + 1))
        else:
            reached = {at + 1 for at in reached if at < len(parts) and fnmatchcase(parts[at], word)}
        if not reached:
            return False
    return len(parts) in reached


def blurred_cameras(site: Site) -> dict[str, Stream]:
    """Give every camera that is blurred, by ``device/stream``."""
    return {
        f"{device_id}/{stream_id}": stream
        for device_id, device in site.devices.items()
        for stream_id, stream in device.streams.items()
        if stream.blur is not None
    }


def blurred_topics(site: Site) -> dict[str, str]:
    """Give the topics that carry the pictures of a blurred camera, each with its device.

    Of a topic of image_transport these are all forms of it that have a usual name.
    """
    found: dict[str, str] = {}
    for address, stream in blurred_cameras(site).items():
        topic = topic_of(stream.source)
        if not topic:
            continue
        base = _untransported(topic)
        for name in (base, *(f"{base}/{transport}" for transport in sorted(_TRANSPORTS))):
            found.setdefault(name, address.partition("/")[0])
    return found


def _untransported(topic: str) -> str:
    """Give the topic of pictures that a plug-in of image_transport has made another form of."""
    above, _, last = topic.rpartition("/")
    return above if last in _TRANSPORTS and above else topic


def calibrated_cameras(site: Site, topic: str, type_name: str) -> tuple[str, ...]:
    """Give the described cameras, ``device/stream``, whose pictures a calibration speaks of.

    By ROS's convention these are the pictures in the calibration's own namespace:
    ``/front/image_raw`` beside ``/front/camera_info``.

    Args:
        site: the description.
        topic: absolute name.
        type_name: of its messages; there are none unless it is a calibration.

    """
    if type_name != "sensor_msgs/msg/CameraInfo":
        return ()
    space = topic.rpartition("/")[0]
    return tuple(
        f"{device_id}/{stream_id}"
        for device_id, device in site.devices.items()
        for stream_id, stream in device.streams.items()
        if (read := topic_of(stream.source)) and _untransported(read).rpartition("/")[0] == space
    )


# Asked for each message that is recorded.
@functools.lru_cache(maxsize=256)
def carries_pictures(type_name: str, definition: str = "") -> bool:
    """Tell whether messages of a type may hold a camera's picture: by its name, or by its parts.

    Args:
        type_name: ``sensor_msgs/msg/Image``, say.
        definition: what the type is made of, as its schema says it; empty where it is not known.

    """
    parts = (type_name, *_PARTS.findall(definition))
    return any(_PICTURES.search(part.rpartition("/")[2]) for part in parts)


def is_latched_by_convention(topic: str, type_name: str) -> bool:
    """Tell whether what such a topic said holds until it says something else (``pkg/msg/Name``)."""
    return topic.rsplit("/", 1)[-1] in _LATCHED_NAMES or type_name in _LATCHED_TYPES
