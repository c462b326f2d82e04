"""Cameras behind a rosbridge server: subscribed while somebody looks at them.

A camera is subscribed if, and only if, it is watched and the server is there: pictures through a
WebSocket cost the robot much, so none comes for nobody.
"""

from __future__ import annotations

from typing import TYPE_CHECKING

from talaia.gateway.adapters.rosbridge.protocol import bytes_of
from talaia.gateway.video.camera import PictureStream
from talaia.model.connection import RosSource, source_as, topic_of

if TYPE_CHECKING:
    from collections.abc import Callable, Collection, Iterable

    from talaia.gateway.adapters.connection_scope import ConnectionScope
    from talaia.gateway.adapters.rosbridge.outgoing_frames import ServerTopics
    from talaia.model.site import Stream

__all__ = ["CameraSubscriptions"]


class CameraSubscriptions:
    """All cameras of one connection. On the event loop."""

    def __init__(
        self,
        scope: ConnectionScope,
        topics: ServerTopics,
        report: Callable[[str, str], None],
        *,
        cbor: bool,
    ) -> None:
        """Take the cameras, where they are asked for, and who is told what cannot be read."""
        self._topics, self._report = topics, report
        # Whether the server can send bytes as they are, and not as base64 in JSON.
        self._cbor = cbor
        # By address, ``device/stream``.
        self._streams: dict[str, Stream] = {
            f"{device_id}/{stream_id}": stream
            for device_id, device in scope.devices.items()
            for stream_id, stream in device.streams.items()
        }
        # By topic and then address: two streams may show one topic at different rates.
        self._readers: dict[str, dict[str, PictureStream]] = {}
        # Streams that somebody looks at, whether or not the server is there.
        self._watched: frozenset[str] = frozenset()

    def begin_connection(self) -> None:
        """Subscribe what is watched at a server that has just come."""
        self._readers.clear()
        for address in self._watched_streams():
            self._subscribe_camera(address)

    def watch_streams(self, streams: Collection[str], *, connected: bool) -> None:
        """Take which streams are watched from now on."""
        before, self._watched = self._watched, frozenset(streams)
        if not connected:
            return
        for address in sorted(before ^ self._watched):
            if address in self._watched:
                self._subscribe_camera(address)
            else:
                self._unsubscribe_camera(address)

    def subscribe_again(self, device: str) -> None:
        """Subscribe a device's watched cameras anew."""
        for address in self._watched_streams():
            if address.startswith(f"{device}/"):
                self._unsubscribe_camera(address)
                self._subscribe_camera(address)

    def readers_of(self, topic: str) -> list[PictureStream]:
        """Give what reads the pictures of a topic now."""
        return list(self._readers.get(topic, {}).values())

    def _watched_streams(self) -> Iterable[str]:
        return sorted(self._watched & self._streams.keys())

    def _subscribe_camera(self, address: str) -> None:
        stream = self._streams.get(address)
        if stream is None:
            return
        reader = PictureStream(address, stream, bytes_of, self._report)
        source = source_as(stream.source, RosSource)
        self._readers.setdefault(source.topic, {})[address] = reader
        # A little sooner than shown, so that the two paces do not lose every other picture.
        # Only pictures as CBOR: a server on ROS 2 cannot write lists of fixed length that way (the
        # covariance of an odometry), and pictures are what is worth it.
        self._topics.subscribe_topic(
            f"stream {address}",
            source.topic,
            source.type,
            throttle_rate=int(700 / stream.max_rate),
            queue_length=1,
            compression="cbor" if self._cbor else "none",
        )

    def _unsubscribe_camera(self, address: str) -> None:
        stream = self._streams.get(address)
        if stream is not None:
            topic = topic_of(stream.source)
            self._readers.get(topic, {}).pop(address, None)
            self._topics.unsubscribe_topic(f"stream {address}", topic)
