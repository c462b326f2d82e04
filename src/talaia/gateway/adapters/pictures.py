"""ROS images to JPEG, on a thread of their own; of pictures that wait, the newest wins."""

from __future__ import annotations

import logging
import threading
from typing import TYPE_CHECKING, Any, Protocol, cast

import numpy as np
import simplejpeg

from talaia.gateway.errors import FieldError
from talaia.wire.frames import Picture

if TYPE_CHECKING:
    from collections.abc import Callable

    from numpy.typing import NDArray

    from talaia.clock import Clock
    from talaia.gateway.ports import PictureSink
    from talaia.model.site import Stream

__all__ = ["PictureStream", "PictureWorker", "jpeg_of", "jpeg_size"]

log = logging.getLogger(__name__)
IMAGE = "sensor_msgs/msg/Image"
COMPRESSED = "sensor_msgs/msg/CompressedImage"
# encoding: (bytes a pixel, simplejpeg's name)
_LAYOUTS = {
    "rgb8": (3, "RGB"),
    "bgr8": (3, "BGR"),
    "rgba8": (4, "RGBA"),
    "bgra8": (4, "BGRA"),
    "mono8": (1, "GRAY"),
    "8UC1": (1, "GRAY"),
    "8UC3": (3, "BGR"),
}


class _Image(Protocol):
    height: int
    width: int
    encoding: str
    step: int
    data: NDArray[np.uint8]


class _Compressed(Protocol):
    format: str
    data: NDArray[np.uint8]


def jpeg_of(message: object, quality: int, width: int) -> tuple[bytes, int, int]:
    """Encode a ``sensor_msgs/Image``: JPEG bytes, width and height.

    Wider pictures than ``width`` (0: no limit) are thinned by a whole number.

    Raises:
        FieldError: an encoding we do not know, or fewer bytes than the size asks for.

    """
    image = cast("_Image", message)
    layout = _LAYOUTS.get(image.encoding)
    if layout is None:
        known = ", ".join(_LAYOUTS)
        raise FieldError("encoding", f"{image.encoding[:40]!r} is not one of: {known}")
    depth, space = layout
    data = np.frombuffer(cast("bytes", image.data), np.uint8)
    if image.step < image.width * depth or data.size < image.step * image.height:
        raise FieldError("data", f"{data.size} bytes are too few for {image.width}x{image.height}")
    if not image.width or not image.height:
        raise FieldError("width", "the picture is empty")
    rows = data[: image.step * image.height].reshape(image.height, image.step)
    pixels = rows[:, : image.width * depth].reshape(image.height, image.width, depth)
    if width and image.width > width:
        thin = -(-image.width // width)
        pixels = pixels[::thin, ::thin]
    pixels = np.ascontiguousarray(pixels)
    subsampling = "Gray" if space == "GRAY" else "420"
    jpeg = simplejpeg.encode_jpeg(pixels, quality, space, subsampling, fastdct=True)
    return jpeg, pixels.shape[1], pixels.shape[0]


def jpeg_size(message: object) -> tuple[bytes, int, int]:
    """Take the bytes of a ``sensor_msgs/CompressedImage`` that is a JPEG, with width and height.

    Raises:
        FieldError: it is no JPEG.

    """
    data = bytes(cast("_Compressed", message).data)
    try:
        height, width, _, _ = simplejpeg.decode_jpeg_header(data)
    except ValueError as error:
        shown = cast("_Compressed", message).format[:40]
        raise FieldError("data", f"format {shown!r} is no JPEG ({error})") from error
    return data, width, height


class PictureStream:
    """One camera: keeps its rate, numbers its pictures, and says once what it cannot read."""

    def __init__(
        self,
        address: str,
        stream: Stream,
        decode: Callable[[Any], object],
        tell: Callable[[str, str], None],
    ) -> None:
        """Take how to decode what `PictureWorker.offer` is given, and who is told problems once."""
        self.address = address
        self._stream = stream
        self._decode = decode
        self._tell = tell
        self._complained = False
        self._period_ns = round(1e9 / stream.max_rate)
        self._due_ns = 0
        self._seq = 0

    def is_due(self, mono_ns: int) -> bool:
        """Tell whether the rate allows a picture now; if so, count it as taken."""
        if mono_ns < self._due_ns:
            return False
        # From the due time, not from now: a camera at just this rate keeps all its pictures.
        late = mono_ns - self._due_ns
        self._due_ns = (self._due_ns if late < self._period_ns else mono_ns) + self._period_ns
        return True

    def picture(self, raw: object, time_us: int, mono_us: int) -> Picture | None:
        """Make a picture of raw bytes, or none when they are not understood."""
        try:
            message = self._decode(raw)
            if self._stream.source.type == COMPRESSED:
                data, width, height = jpeg_size(message)
            else:
                data, width, height = jpeg_of(message, self._stream.quality, self._stream.width)
        except (FieldError, ValueError) as error:
            if not self._complained:
                self._complained = True
                self._tell(self.address, f"{self._stream.source.topic}: {error}")
            return None
        self._seq += 1
        return Picture(
            stream=self.address,
            seq=self._seq,
            time_us=time_us,
            mono_us=mono_us,
            width=width,
            height=height,
            data=data,
        )


class PictureWorker:
    """The encoding thread. At most one raw picture of each stream waits."""

    def __init__(self, sink: PictureSink, clock: Clock) -> None:
        """Take where pictures go; `start` begins."""
        self._sink = sink
        self._clock = clock
        self._waiting: dict[str, tuple[PictureStream, object, int, int]] = {}
        self._turn = threading.Condition()
        self._ended = False
        self._thread = threading.Thread(target=self._run, name="talaia-pictures", daemon=True)

    def start(self) -> None:
        """Begin."""
        self._thread.start()

    def offer(self, stream: PictureStream, raw: object) -> None:
        """Take the newest raw picture of a stream; stamped now."""
        mono_ns = self._clock.monotonic_ns()
        if not stream.is_due(mono_ns):
            return
        with self._turn:
            self._waiting.pop(stream.address, None)
            stamp = (self._clock.wall_ns() // 1000, mono_ns // 1000)
            self._waiting[stream.address] = (stream, raw, *stamp)
            self._turn.notify()

    def _run(self) -> None:
        while True:
            with self._turn:
                while not self._waiting and not self._ended:
                    self._turn.wait()
                if self._ended:
                    return
                stream, raw, time_us, mono_us = self._waiting.pop(next(iter(self._waiting)))
            picture = stream.picture(raw, time_us, mono_us)
            if picture is not None:
                self._sink.offer(picture)

    def close(self) -> None:
        """End the thread."""
        with self._turn:
            self._ended = True
            self._turn.notify()
        if self._thread.is_alive():
            self._thread.join()
