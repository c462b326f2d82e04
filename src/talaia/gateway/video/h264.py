"""Pictures to H.264 that can be decoded at once: no reordering, no look-ahead. Needs PyAV.

Only `talaia.gateway.video.camera` imports this, and does without where PyAV is missing: it is
an extra, for the x264 in its wheels is under the GPL.
"""

from __future__ import annotations

import functools
import platform
from fractions import Fraction
from pathlib import Path
from typing import TYPE_CHECKING, NamedTuple

import av
import numpy as np
from av.video.frame import PictureType
from av.video.reformatter import VideoReformatter

from talaia.gateway.errors import FieldError
from talaia.gateway.video.pixels import Pixels, rgb_of

if TYPE_CHECKING:
    from av.video.codeccontext import VideoCodecContext

__all__ = ["Encoded", "Encoder", "bits_for", "can_encode", "png_pixels"]

# Layouts that PyAV takes as they lie.
_FORMATS = {
    "RGB": "rgb24",
    "BGR": "bgr24",
    "RGBA": "rgba",
    "BGRA": "bgra",
    "GRAY": "gray",
    "YUYV": "yuyv422",
    "NV12": "nv12",
    "I420": "yuv420p",
}
# Of those, the ones that it reads where they lie: a copy of a picture costs a quarter of a
# millisecond at 640x480, with the interpreter's lock, for which driving would wait.
_AS_THEY_LIE = ("rgb24", "bgr24", "rgba", "bgra", "gray", "nv12", "yuv420p")
_MICROS = Fraction(1, 1_000_000)  # Times go through unchanged, in µs.
# FFmpeg's numbers: SMPTE 170M is BT.601; 1 is the limited range.
_SMPTE170M, _LIMITED = 6, 1
# A key picture may take as much of the link as this time of the stream (s).
_BURST_S = 0.25
# However few bits a second there are, a key picture gets so many bytes for each of its pixels: with
# less it was a grey area of 277 bytes that looked live. Those after it pay for it, and where the
# line is too narrow for that it is found full, and fewer pictures are made.
_KEY_BYTES = 0.05


class Encoded(NamedTuple):
    """One encoded picture (Annex B)."""

    data: bytes
    key: bool


def can_encode() -> bool:
    """Tell whether this PyAV has x264: distributions may build it without."""
    return "libx264" in av.codecs_available


def bits_for(width: int, height: int, rate: float) -> int:
    """Give the bit rate (bit/s) at which pictures of this size and rate (Hz) look well.

    1.5 Mbit/s for 640x480 at 30 Hz; larger pictures need less for each pixel.
    """
    pixels = width * height / (640 * 480)
    # Roots: twice the pixels, or twice the rate, looks as well with less than twice the bits.
    return int(1_500_000 * pixels**0.75 * (min(rate, 60.0) / 30) ** 0.5)


class Encoder:
    """One H.264 stream of one size. The codec works without the interpreter's lock."""

    def __init__(
        self, *, width: int, height: int, rate: float, bits: int, key_every_s: float = 10
    ) -> None:
        """Make pictures of ``width`` and ``height`` (made even), at most ``bits`` a second.

        A picture to begin with comes so often without being asked for.

        Raises:
            FieldError: x264 does not take that size.

        """
        # 4:2:0 wants even sizes; 16 px is the least block.
        self.width, self.height = max(16, width & ~1), max(16, height & ~1)
        self.bits = bits
        self.codec = ""  # As WebCodecs names it; empty until the first key picture.
        context: VideoCodecContext = av.CodecContext.create("libx264", "w")
        context.width, context.height, context.pix_fmt = self.width, self.height, "yuv420p"
        context.time_base = _MICROS
        # x264's rate control goes by it; below 1 it would round to none.
        context.framerate = Fraction(round(max(1.0, rate)))
        context.color_range = _LIMITED
        # Said in the stream: a decoder that guesses may take large pictures for BT.709.
        context.colorspace = context.color_primaries = context.color_trc = _SMPTE170M
        # With more, each thread may hold a picture back.
        context.thread_count = 1
        context.options = {
            # The least work for each picture: it runs beside the robot's own programs.
            "preset": "ultrafast",
            # No look-ahead and no reordering: a picture comes out as soon as it is in.
            "tune": "zerolatency",
            # What every browser decodes; it has no pictures that refer to later ones.
            "profile": "baseline",
            # A key picture is one after which nothing refers to what came before.
            "forced-idr": "1",
            # A still scene costs next to nothing; a busy one the limit.
            "crf": "25",
            "maxrate": str(bits),
            # The bucket: by it the largest picture is bounded.
            "bufsize": str(round(max(bits * _BURST_S, 8 * _KEY_BYTES * width * height))),
            "x264-params": (
                # No key pictures of its own accord at a cut: they are asked for, or come by time.
                f"scenecut=0:threads=1:sliced-threads=0:keyint={round(rate * key_every_s) or 10}"
                f"{_instructions()}"
            ),
        }
        self._context = context
        # Kept: it uses the scaler again that it made for these sizes.
        self._reformatter = VideoReformatter()

    def encode_picture(self, pixels: Pixels, time_us: int, *, key: bool) -> Encoded | None:
        """Encode a picture, made to the size of this stream; with ``key`` one to begin with.

        ``time_us`` must rise.

        Raises:
            FieldError: it cannot be encoded.

        """
        try:
            frame = self._reformatter.reformat(
                _frame_of(pixels),
                self.width,
                self.height,
                "yuv420p",
                dst_colorspace=_SMPTE170M,
                # When it gets smaller each pixel is the mean of its area, else fine lines would
                # flicker. Of the same size brightness is exact with each of them; with this one
                # colours are those of every second line, for two thirds of the work.
                interpolation="AREA" if pixels.width > self.width else "POINT",
                threads=1,
            )
            frame.pts, frame.time_base = time_us, _MICROS
            frame.pict_type = PictureType.I if key else PictureType.NONE
            packets = self._context.encode(frame)
        except (av.FFmpegError, ValueError) as error:
            raise FieldError("data", f"it cannot be encoded ({error})") from error
        # An encoder may take a picture without giving one out.
        if not packets:
            return None
        data = b"".join(bytes(packet) for packet in packets)
        is_key = any(packet.is_keyframe for packet in packets)
        # The parameters stand in front of key pictures only.
        if is_key and not self.codec:
            self.codec = _codec_in(data)
        return Encoded(data, is_key)


def png_pixels(data: bytes) -> Pixels:
    """Decode a PNG.

    Raises:
        FieldError: it is none, or is cut off.

    """
    try:
        context: VideoCodecContext = av.CodecContext.create("png", "r")
        # The empty packet at the end makes the decoder give out what it holds.
        frames = [*context.decode(av.Packet(data)), *context.decode(None)]
        rgb = np.asarray(frames[0].to_ndarray(format="rgb24"), np.uint8)
    except (av.FFmpegError, ValueError, IndexError) as error:
        raise FieldError("data", f"the PNG cannot be decoded ({error})") from error
    return Pixels("RGB", rgb.shape[1], rgb.shape[0], rgb)


@functools.cache
def _instructions() -> str:
    """Keep x264 from AVX-512, with the same pictures for a sixth less work.

    Its wide registers slow a processor down for a while, and a picture now and then never makes
    that up: 1.40 ms instead of 1.70. What has AVX-512 has all that this names.
    """
    if platform.machine() != "x86_64":
        return ""
    try:
        facts = Path("/proc/cpuinfo").read_text(encoding="ascii", errors="replace")
    except OSError:
        return ""
    return ":asm=avx2" if " avx512f" in facts else ""


def _frame_of(pixels: Pixels) -> av.VideoFrame:
    form = _FORMATS.get(pixels.layout)
    odd = pixels.width % 2 or pixels.height % 2
    # Shared colours need even sizes; what lies in whole pixels does not.
    if form is None or (odd and form not in ("rgb24", "bgr24", "rgba", "bgra", "gray")):
        return av.VideoFrame.from_ndarray(rgb_of(pixels), format="rgb24")
    data = pixels.data[:, :, 0] if form == "gray" else pixels.data
    # It takes the planes of other heights for shorter than they are.
    whole = form not in ("nv12", "yuv420p") or pixels.height % 4 == 0
    if form in _AS_THEY_LIE and whole and data.flags.c_contiguous:
        return av.VideoFrame.from_numpy_buffer(data, format=form)
    return av.VideoFrame.from_ndarray(data, format=form)


def _codec_in(data: bytes) -> str:
    """Name the profile and level as WebCodecs does, from the sequence parameters (RFC 6381)."""
    # 0x67: a sequence parameter set; profile, constraints and level are its next three bytes.
    at = data.find(b"\0\0\1\x67")
    return f"avc1.{data[at + 4 : at + 7].hex().upper()}" if at >= 0 else "avc1.42C01E"
