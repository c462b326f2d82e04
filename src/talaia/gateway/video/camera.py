"""One camera: what comes of it, in each form that somebody wants.

A picture is read once and encoded once for each form (`picture_forms`), however many look at it,
and not at all in a form that nobody wants. Of a camera that is blurred (`camera_blur`) whatever
leaves this gateway is blurred first, but for the stream of those who have the right to more.

Long, because what becomes of a picture that leaves, and of one that stays, is read together.
"""

from __future__ import annotations

import struct
from typing import TYPE_CHECKING, Any, NamedTuple, cast

from talaia.gateway.errors import FieldError
from talaia.gateway.ports import Filming
from talaia.gateway.video import jpeg
from talaia.gateway.video.camera_blur import CameraBlur
from talaia.gateway.video.picture_forms import PictureForms, can_film, film_size
from talaia.gateway.video.pixels import Pixels, pixels_of, rgb_of
from talaia.model.connection import RosSource, VideoSource, source_as
from talaia.objects.errors import DetectorError
from talaia.wire.frames import PictureForm, PictureFrame, unblurred_address

if TYPE_CHECKING:
    from collections.abc import Callable, Mapping

    import numpy as np
    from numpy.typing import NDArray

    from talaia.gateway.ports import PictureSink
    from talaia.gateway.video.camera_film import CameraFilm
    from talaia.model.site import Source, Stream

__all__ = ["IMAGE", "CapturedFrame", "FrameStamp", "PictureStream", "can_film"]

# Types of ROS messages; pictures of other cameras come as pixels.
IMAGE = "sensor_msgs/msg/Image"
COMPRESSED = "sensor_msgs/msg/CompressedImage"
# A problem that lasts is told again so often, to those who have come meanwhile.
_AGAIN_US = 2_000_000
# What decoders of foreign bytes raise; a camera's nonsense must not end the thread of them all.
_UNREADABLE = (
    DetectorError,
    FieldError,
    ValueError,
    TypeError,
    AttributeError,
    RuntimeError,
    ArithmeticError,
    LookupError,
    BufferError,
    MemoryError,
    struct.error,
)
_PNG = b"\x89PNG"  # How a PNG begins; `CompressedImage` carries both.


class FrameStamp(NamedTuple):
    """A picture's number and when it came: wall and monotonic clock (µs)."""

    seq: int
    time_us: int
    mono_us: int


class CapturedFrame:
    """One picture as it came, read once and only when somebody wants it."""

    def __init__(self, read: Callable[[], object], kind: str) -> None:
        """Take what gives the message (or `Pixels`), and the message's type."""
        self._read = read  # Gives the message or its pixels; called at most once.
        self._kind = kind  # ROS message type, or "" where `read` gives pixels itself.
        # Its own JPEG with width and height, and its pixels; filled by the first who asks.
        self._jpeg: tuple[bytes, int, int] | None = None
        self._pixels: Pixels | None = None
        self._seen = False  # `read` has been called.

    def as_jpeg(self) -> tuple[bytes, int, int] | None:
        """Give it as the camera's own JPEG with width and height, if that is what came."""
        self._read_once()
        return self._jpeg

    def read_pixels(self) -> Pixels:
        """Give its pixels.

        Raises:
            FieldError: it is not what it says, or not known.

        """
        self._read_once()
        if self._pixels is None and self._jpeg is not None:
            self._pixels = jpeg.pixels_in(self._jpeg[0])
        assert self._pixels is not None  # noqa: S101 - told to mypy; `_read_once` raised
        return self._pixels

    def as_rgb(self) -> NDArray[np.uint8] | None:
        """Give it as RGB, or none where it cannot be read."""
        try:
            return rgb_of(self.read_pixels())
        except _UNREADABLE:
            return None

    def _read_once(self) -> None:
        if self._seen:
            return
        message = self._read()
        if isinstance(message, Pixels):
            self._pixels = message
        elif self._kind == COMPRESSED:
            data = bytes(cast("jpeg.CompressedImageFields", message).data)
            if data[:4] == _PNG:
                if not can_film():
                    raise FieldError("format", "PNG needs PyAV: install talaia[camera]")
                from talaia.gateway.video import h264

                self._pixels = h264.png_pixels(data)
            else:
                self._jpeg = jpeg.jpeg_size(message)
        else:
            self._pixels = pixels_of(message)
        # Only after it was read: a failure is raised again for whoever asks next.
        self._seen = True


class PictureStream:
    """One camera: keeps its rate, numbers its pictures, and says what it cannot read."""

    def __init__(
        self,
        address: str,
        stream: Stream,
        decode: Callable[[Any], object],
        tell: Callable[[str, str], None],
    ) -> None:
        """Take how to decode what `PictureWorker.offer_raw` is given, and who is told problems."""
        self.address = address  # `device/stream`.
        self._stream = stream  # The description.
        # How a ROS message says that its bytes are to be read; nothing for other cameras.
        self._encoding = source_as(stream.source, RosSource).type
        self._decode = decode  # Message bytes to a message.
        self._tell = tell  # Writes a trouble down.
        self._told = ""  # The last trouble that was told; "" after a picture that went well.
        self._told_us = 0  # When it was told to viewers (monotonic µs).
        # Between two pictures that are looked at at all, ns.
        self._period_ns = round(1e9 / stream.max_rate)
        self._due_ns = 0  # When the next may be (monotonic ns).
        self._seq = 0  # Numbers the pictures of this camera in this run.
        self._divisor = 1  # Of the picture that is being made; see `process_picture`.
        self._forms = PictureForms(address, stream)
        # None where pictures leave as they are; else what they leave as, and as what they stay.
        self._blur = None if stream.blur is None else CameraBlur(stream.blur)
        self._unblurred = PictureForms(unblurred_address(address), stream)
        self._reel = _new_film()  # None where no encoder is installed.

    def is_due(self, mono_ns: int) -> bool:
        """Tell whether the rate allows a picture now; if so, count it as taken."""
        if mono_ns < self._due_ns:
            # Read before decoding: a picture too many costs nothing.
            return False
        # From the due time, not from now: a camera at just this rate keeps all its pictures.
        late = mono_ns - self._due_ns
        self._due_ns = (self._due_ns if late < self._period_ns else mono_ns) + self._period_ns
        return True

    def process_picture(
        self, raw: object, time_us: int, mono_us: int, sink: PictureSink, *, divisor: int = 1
    ) -> None:
        """Make of one raw picture what is wanted of it, and give that to ``sink``.

        Width and height are divided by ``divisor``, where the cores do not bear all of it.
        """
        self._divisor = divisor
        self._seq += 1
        stamp = FrameStamp(self._seq, time_us, mono_us)
        taken = CapturedFrame(lambda: self._decode(raw), self._encoding)
        shown = self._blurred(taken, mono_us, sink)
        # Before the forms are asked for: detectors look whether or not a person does. They see what
        # is there; of that a page is shown no more than of the picture.
        sink.offer_frame(
            self.address, stamp, taken.as_rgb, None if shown is taken else shown.as_rgb
        )
        if shown is not taken:
            # First, for it waits for no detector.
            self._send_unblurred(taken, stamp, sink)
        forms = self._forms.wanted(sink)
        filming = Filming.NO if self._reel is None else sink.filming(self.address, time_us)
        if not forms and filming is Filming.NO:
            return
        share = sink.room()
        try:
            large = self._send_forms(shown, stamp, self._forms, forms, share=share, sink=sink)
            # Last: those who look on do not wait for it.
            self._encode_film(
                taken=shown,
                stamp=stamp,
                large=large,
                filming=filming,
                sink=sink,
                whole=PictureForm.H264 in forms and share >= 1,
            )
        except _UNREADABLE as error:
            self._report_problem(str(error) or type(error).__name__, mono_us, sink)

    @property
    def is_blurred(self) -> bool:
        """Whether its pictures wait for a detector before they leave."""
        return self._blur is not None

    def _blurred(self, taken: CapturedFrame, mono_us: int, sink: PictureSink) -> CapturedFrame:
        """Give a picture as it may leave; it is looked at only when somebody wants it."""
        blur = self._blur
        if blur is None:
            return taken
        return CapturedFrame(
            lambda: blur.cover(rgb_of(taken.read_pixels()), mono_us, sink.find_private), ""
        )

    def _send_unblurred(self, taken: CapturedFrame, stamp: FrameStamp, sink: PictureSink) -> None:
        forms = self._unblurred.wanted(sink)
        if not forms:
            return
        share = sink.room()
        try:
            self._send_forms(taken, stamp, self._unblurred, forms, share=share, sink=sink)
        except _UNREADABLE as error:
            why = f"{_place_of(self._stream.source)}: {str(error) or type(error).__name__}"
            sink.trouble(unblurred_address(self.address), why)

    def _send_forms(
        self,
        taken: CapturedFrame,
        stamp: FrameStamp,
        made: PictureForms,
        forms: Mapping[PictureForm, list[str]],
        *,
        share: float,
        sink: PictureSink,
    ) -> PictureFrame | None:
        """Give the hub a picture in each form that is wanted; return the large film's."""
        large: PictureFrame | None = None
        for form, served in forms.items():
            picture = made.make_picture(
                taken=taken,
                stamp=stamp,
                form=form,
                served=served,
                share=share,
                sink=sink,
                divisor=self._divisor,
            )
            if picture is not None:
                if made is self._forms:
                    self._told = ""
                sink.offer(picture)
                # Only the large film of viewers can be the recorded one, too.
                large = picture if form is PictureForm.H264 else large
        return large

    def _encode_film(
        self,
        *,
        taken: CapturedFrame,
        stamp: FrameStamp,
        large: PictureFrame | None,
        filming: Filming,
        sink: PictureSink,
        whole: bool,
    ) -> None:
        """Give the film its next picture: what viewers get where they get all, else one for it."""
        reel = self._reel
        if reel is None:
            return
        if filming is Filming.NO:
            reel.stop_filming()
            return
        picture = large if whole else None
        if not reel.can_share(picture, whole=whole, anew=filming is Filming.ANEW):
            pixels = taken.read_pixels()
            width, height, bits = film_size(
                self._stream, pixels, PictureForm.H264, self._stream.max_rate, divisor=self._divisor
            )
            picture = reel.encode_own(
                self.address, stamp, pixels, (width, height, bits, self._stream.max_rate)
            )
        if picture is not None:
            self._told = ""
            sink.film(picture)

    def _report_problem(self, why: str, mono_us: int, sink: PictureSink) -> None:
        where = _place_of(self._stream.source)
        if why != self._told:
            self._tell(self.address, f"{where}: {why}")
        elif mono_us - self._told_us < _AGAIN_US:
            return
        self._told, self._told_us = why, mono_us
        sink.trouble(self.address, f"{where}: {why}")


def _new_film() -> CameraFilm | None:
    if not can_film():
        return None
    from talaia.gateway.video.camera_film import CameraFilm

    return CameraFilm()


def _place_of(source: Source) -> str:
    """Say where a camera is, for problems."""
    match source:
        case RosSource(topic=topic):
            return topic
        case VideoSource(url=url, file=file):
            return url or file
        case _:
            return ""
