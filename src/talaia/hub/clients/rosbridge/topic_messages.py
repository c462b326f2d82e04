"""Samples and raw messages as what a client subscribed to: JSON, CBOR or bytes. Pure."""

from __future__ import annotations

import math
import struct
from functools import lru_cache
from typing import TYPE_CHECKING, NamedTuple

from talaia.hub.clients.rosbridge.offer import TEXT_TYPE
from talaia.hub.clients.rosbridge.ros_types import MOST_READ, message_reader
from talaia.hub.live.taps.type_texts import MessageUnreadable
from talaia.wire.rosbridge.codec import encode_rosbridge

if TYPE_CHECKING:
    from talaia.hub.clients.rosbridge.offer import SignalTopic
    from talaia.hub.clients.rosbridge.wanted_topics import TopicForm
    from talaia.hub.clients.signal_subscriptions import ClientSample
    from talaia.hub.live.taps.tapped import TappedMessage
    from talaia.wire.frames import TapSchema

__all__ = ["TopicFrames", "encode_sample_frames", "encode_tapped_frames", "sample_data"]

_CDR = b"\x00\x01\x00\x00"
_MICROS = 1_000_000
# Compiled once for all clients.
_reader_of = lru_cache(maxsize=64)(message_reader)


class TopicFrames(NamedTuple):
    """How a message goes: under which name, in which form, and the number of its fragments."""

    name: str
    form: TopicForm
    number: int

    def encode_message(self, message: object) -> list[str | bytes]:
        """Write a message of the topic."""
        return encode_rosbridge(
            {"op": "publish", "topic": self.name, "msg": message},
            fragment_size=self.form.fragment_size,
            fragment_id=f"{self.name}:{self.number}",
            cbor=self.form.compression != "none",
        )


def sample_data(topic: SignalTopic, sample: ClientSample) -> float | str:
    """Give what a sample's ``data`` is: a number, a text, or the word of a state."""
    if sample.text is not None:
        return sample.text
    if topic.type != TEXT_TYPE:
        return sample.value
    if not math.isfinite(sample.value):
        return ""
    at = int(sample.value)
    return topic.states[at] if 0 <= at < len(topic.states) else str(at)


def encode_sample_frames(
    frames: TopicFrames, topic: SignalTopic, sample: ClientSample
) -> list[str | bytes]:
    """Write a sample as the ``std_msgs`` message of its topic."""
    data = sample_data(topic, sample)
    if frames.form.compression != "cbor-raw":
        return frames.encode_message({"data": data})
    if isinstance(data, str):
        text = data.encode("utf-8", "replace") + b"\x00"
        serialized = _CDR + struct.pack("<I", len(text)) + text
    else:
        serialized = _CDR + struct.pack("<d", data)
    return frames.encode_message(_raw_message(sample.time_us, serialized))


def encode_tapped_frames(
    frames: TopicFrames, schema: TapSchema, message: TappedMessage
) -> list[str | bytes]:
    """Write a raw message of the robot; it is read only where its form needs that.

    Raises:
        MessageUnreadable: it cannot be read, or is too large for that.

    """
    if frames.form.compression == "cbor-raw":
        return frames.encode_message(_raw_message(message.log_us, message.data))
    # As it is (``cbor-raw``) it may be larger.
    if len(message.data) > MOST_READ:
        raise MessageUnreadable(
            f"a message of {len(message.data)} bytes; over {MOST_READ} take compression cbor-raw"
        )
    return frames.encode_message(_reader_of(schema)(message.data))


def _raw_message(time_us: int, data: bytes) -> dict[str, object]:
    seconds, micros = divmod(time_us, _MICROS)
    return {"secs": seconds, "nsecs": micros * 1000, "bytes": data}
