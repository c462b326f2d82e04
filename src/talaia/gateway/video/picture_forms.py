"""The forms in which one camera's pictures are wanted: each made once, at its own pace."""

from __future__ import annotations

import functools
from typing import TYPE_CHECKING

from talaia.gateway.video import jpeg
from talaia.gateway.video.pixels import Pixels, thin_pixels
from talaia.wire.frames import PictureForm, PictureFrame

if TYPE_CHECKING:
    from collections.abc import Collection

    from talaia.gateway.ports import PictureSink
    from talaia.gateway.video import h264
    from talaia.gateway.video.camera import CapturedFrame, FrameStamp
    from talaia.model.site import Stream

__all__ = ["PictureForms", "can_film", "film_size"]

# The small rung: no wider than this (px), at most so many a second, and its share of the bits.
SMALL_PX, SMALL_HZ, SMALL_BITS, SMALL_QUALITY = 320, 15.0, 250_000, 50
STILL_HZ = 1.0  # One picture now and then, where nobody looks at a film.
# By its large pictures a hub sees whether a connection on the small rung would carry more.
KEY_EVERY_S = {PictureForm.H264: 10.0, PictureForm.H264_SMALL: 3.0}
# One who asks for key pictures all the time makes them no dearer than this for the others.
_KEY_EVERY_US = 300_000
_LEAST_QUALITY = 20  # However narrow the line: below that fewer pictures come instead.
# An encoder goes on while its bits are within this factor of what the line bears.
_NEAR = 0.6


@functools.cache
def can_film() -> bool:
    """Tell whether films can be made here.

    The first call loads PyAV: 15 MiB, and a tenth of a second of the interpreter. A gateway without
    a camera does without.
    """
    try:
        from talaia.gateway.video import h264
    except ImportError:
        # PyAV is an extra, and without it all is JPEG.
        return False
    return h264.can_encode()


class _Rung:
    """One form of one camera: keeps its own pace, and its encoder where it has one.

    Attributes:
        encoder: of a film; none for single pictures.
        slower: how many times slower than the form's own the pace is that the encoder was made for.
            Each picture gets what the line bears in that time, so they come no faster.

    """

    def __init__(self, rate: float) -> None:
        self.period_us = round(1e6 / rate)  # Between two pictures of this form, µs.
        self._due_us = 0  # When the next is due (monotonic µs).
        # When the last key picture was made; so long ago that the first may be one.
        self._key_us = -_KEY_EVERY_US
        # Somebody waits for a picture to begin with; kept until it may be made.
        self._wants_key = True
        # Made with the first picture; replaced when size or bit rate change too much.
        self.encoder: h264.Encoder | None = None
        self.slower = 1

    def is_due(self, mono_us: int, share: float) -> bool:
        """Tell whether the pace allows a picture now; if so, count it as taken."""
        # On a whole line the next picture gets an encoder of its own pace, so nothing is left out.
        slower = 1 if share >= 1 else max(_slowdown_factor(share), self.slower)
        period = self.period_us * slower
        # A tenth early will do: pictures come with jitter.
        if mono_us < self._due_us - period // 10:
            return False
        late = mono_us - self._due_us
        self._due_us = (self._due_us if late < period else mono_us) + period
        return True

    def key_now(self, mono_us: int, *, asked: bool) -> bool:
        """Tell whether this is to be a key picture."""
        self._wants_key = self._wants_key or asked
        if not self._wants_key or mono_us - self._key_us < _KEY_EVERY_US:
            return False
        self._wants_key, self._key_us = False, mono_us
        return True

    def is_key_old(self, mono_us: int, longest_s: float) -> bool:
        """Tell whether the last key picture is older than it may be."""
        return mono_us - self._key_us >= longest_s * 1e6


class PictureForms:
    """What goes to the hub of one stream of pictures, in the forms that are wanted now."""

    def __init__(self, address: str, stream: Stream) -> None:
        """Name the pictures by ``address``; ``stream`` says how large and how good they are."""
        self._address = address
        self._stream = stream
        # Forms that somebody wants now; a form that nobody wants loses its encoder.
        self._rungs: dict[PictureForm, _Rung] = {}

    def wanted(self, sink: PictureSink) -> dict[PictureForm, list[str]]:
        """Give what is to be made now, and what each is made for."""
        forms = _pair_forms(sink.asked(self._address))
        # An encoder nobody needs is let go; one who comes back begins with a key picture anyway.
        for form in self._rungs.keys() - forms.keys():
            del self._rungs[form]
        return forms

    def make_picture(
        self,
        *,
        taken: CapturedFrame,
        stamp: FrameStamp,
        form: PictureForm,
        served: list[str],
        share: float,
        sink: PictureSink,
        divisor: int = 1,
    ) -> PictureFrame | None:
        """Give a picture in one form, or none now; large ones are made smaller by ``divisor``."""
        rung = self._rungs.get(form)
        if rung is None:
            rung = self._rungs[form] = _Rung(_form_rate(form, self._stream.max_rate))
        # A list, not `any` of a generator: each question takes its answer away.
        asked = any([sink.key_due(self._address, picture_form) for picture_form in served])  # noqa: C419 - each is asked
        if share <= 0 or not rung.is_due(stamp.mono_us, share):
            # One who has just come waits no longer than need be.
            if asked:
                rung.key_now(-_KEY_EVERY_US, asked=True)
            return None
        if form in (PictureForm.H264, PictureForm.H264_SMALL):
            return self._make_h264(
                taken=taken,
                stamp=stamp,
                form=form,
                served=served,
                share=share,
                rung=rung,
                asked=asked,
                divisor=divisor,
            )
        data, width, height = self._make_jpeg(taken, form, share, divisor)
        return PictureFrame(
            stream=self._address,
            **stamp._asdict(),
            width=width,
            height=height,
            forms=served,
            data=data,
        )

    def _make_jpeg(
        self, taken: CapturedFrame, form: PictureForm, share: float, divisor: int
    ) -> tuple[bytes, int, int]:
        stream = self._stream
        small = form is PictureForm.JPEG_SMALL
        # The camera's own JPEG is passed on untouched where nothing has to be smaller.
        own = taken.as_jpeg()
        wide = stream.width and own is not None and own[1] > stream.width
        if own is not None and not small and not wide and share >= 1:
            return own
        pixels = taken.read_pixels()
        most = min(stream.width or SMALL_PX, SMALL_PX) if small else stream.width
        if divisor > 1 and not small:
            most = min(most or pixels.width, -(-pixels.width // divisor))
        pixels = thin_pixels(pixels, most)
        quality = SMALL_QUALITY if small else stream.quality
        # Bytes go roughly with the square of the quality.
        quality = max(_LEAST_QUALITY, round(quality * share**0.5))
        return jpeg.encode_jpeg(pixels, quality), pixels.width, pixels.height

    def _make_h264(
        self,
        *,
        taken: CapturedFrame,
        stamp: FrameStamp,
        form: PictureForm,
        served: list[str],
        share: float,
        rung: _Rung,
        asked: bool,
        divisor: int,
    ) -> PictureFrame | None:
        pixels = taken.read_pixels()
        rate = 1e6 / rung.period_us
        width, height, bits = film_size(self._stream, pixels, form, rate, divisor=divisor)
        encoder, slower, every_s = rung.encoder, _slowdown_factor(share), KEY_EVERY_S[form]
        asked = asked or (share < 1 and rung.is_key_old(stamp.mono_us, every_s))
        key = rung.key_now(stamp.mono_us, asked=asked)
        # On a narrow line an encoder that has spent its bits on a busy scene has none for a key
        # picture: one of 709 bytes in 320x240 was a grey area. A new encoder has them again, and is
        # the only one to begin: its own period would bring key pictures without bits.
        fresh = key and share < 1
        if (
            encoder is None
            or fresh
            or not _encoder_fits(
                encoder=encoder, width=width, height=height, bits=bits, share=share
            )
        ):
            # Made for the pace that the line allows: x264 gives each picture its part of a second,
            # and with the camera's own pace a fifth of the line's bits was used at the least.
            from talaia.gateway.video.h264 import Encoder

            encoder = rung.encoder = Encoder(
                width=width,
                height=height,
                rate=rate / slower,
                bits=round(bits * share),
                key_every_s=every_s if share >= 1 else 2 * every_s,
            )
            rung.slower = slower
        made = encoder.encode_picture(pixels, stamp.mono_us, key=key)
        if made is None:
            return None
        return PictureFrame(
            stream=self._address,
            **stamp._asdict(),
            width=encoder.width,
            height=encoder.height,
            format="h264",
            forms=served,
            key=made.key,
            codec=encoder.codec if made.key else "",
            data=made.data,
        )


def film_size(
    stream: Stream, pixels: Pixels, form: PictureForm, rate: float, *, divisor: int = 1
) -> tuple[int, int, int]:
    """Give width and height (px) and bit rate (bit/s) of a film of these pictures.

    It is made smaller by ``divisor`` at the least, where the cores do not bear all of it.
    """
    from talaia.gateway.video.h264 import bits_for

    most = stream.width or pixels.width
    if form is PictureForm.H264_SMALL:
        most = min(most, SMALL_PX)
    by = max(divisor, -(-pixels.width // most))
    # H.264 4:2:0 wants even sizes; 16 px is the least block.
    width, height = max(16, pixels.width // by & ~1), max(16, pixels.height // by & ~1)
    bits = stream.kbits * 1000 or bits_for(width, height, rate)
    return width, height, min(bits, SMALL_BITS) if form is PictureForm.H264_SMALL else bits


def _encoder_fits(
    *, encoder: h264.Encoder, width: int, height: int, bits: int, share: float
) -> bool:
    """Tell whether an encoder goes on: a new one begins with a key picture, which is the dearest.

    ``bits`` a second are the line's whole; while the share of it wavers, an encoder that is near
    enough stays.
    """
    if (encoder.width, encoder.height) != (width, height):
        return False
    if share >= 1:
        return encoder.bits == bits
    return _NEAR <= encoder.bits / (bits * share) <= 1 / _NEAR


def _pair_forms(asked: Collection[str]) -> dict[PictureForm, list[str]]:
    """Pair what is made with what it is made for; without an encoder all is JPEG."""
    made: dict[PictureForm, list[str]] = {}
    for form in sorted(set(asked) & set(PictureForm)):
        as_form = PictureForm(form)
        if not can_film():
            as_form = {
                PictureForm.H264: PictureForm.JPEG,
                PictureForm.H264_SMALL: PictureForm.JPEG_SMALL,
            }.get(as_form, as_form)
        made.setdefault(as_form, []).append(form)
    return made


def _form_rate(form: PictureForm, most: float) -> float:
    if form is PictureForm.STILL:
        return min(most, STILL_HZ)
    return min(most, SMALL_HZ) if form in (PictureForm.H264_SMALL, PictureForm.JPEG_SMALL) else most


def _slowdown_factor(share: float) -> int:
    """Give how many times slower pictures come on a link with this share of room."""
    return 1 if share >= 0.5 else 2 if share >= 0.25 else 3 if share >= 0.15 else 5
