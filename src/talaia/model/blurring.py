"""What a description says of pictures on which nobody is to be recognized. Pure."""

from __future__ import annotations

import functools
import re
from typing import TYPE_CHECKING

from talaia.model.connection import topic_of

if TYPE_CHECKING:
    from talaia.model.site import Site, Stream

__all__ = ["blurred_cameras", "blurred_topics", "carries_pictures"]

# Message types that hold pictures of a camera, by the last part of their name: of sensor_msgs and
# stereo_msgs, of Foxglove's schemas, of image_transport's plug-ins (Theora, FFmpeg).
_PICTURES = re.compile(r"(?:Image|Video|Picture|Packet|Disparity)\w*$")
# In the text of a type, a field's type begins its line, and a part's name stands behind MSG.
_PARTS = re.compile(r"^\s*(?:MSG:\s*)?([\w/]+)(?:\[[^]]*\])?", re.MULTILINE)
# What a topic of image_transport is called behind the name that its plug-ins share.
_TRANSPORTS = frozenset({"compressed", "compressedDepth", "theora", "ffmpeg", "zstd"})


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
        above, _, last = topic.rpartition("/")
        base = above if last in _TRANSPORTS and above else topic
        for name in (base, *(f"{base}/{transport}" for transport in sorted(_TRANSPORTS))):
            found.setdefault(name, address.partition("/")[0])
    return found


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
