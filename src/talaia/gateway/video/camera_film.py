"""What is filmed of one camera: encoded once, with those who look on where that can be. Needs PyAV.

While viewers get every picture in full, the film is theirs. When their line is bad, they get fewer
pictures or worse ones, and a film must not: from there on it has an encoder of its own, until the
viewers' film has another picture that needs none before it.
"""

from __future__ import annotations

from typing import TYPE_CHECKING

from talaia.gateway.video.h264 import Encoder
from talaia.wire.frames import PictureFrame

if TYPE_CHECKING:
    from talaia.gateway.video.camera import FrameStamp
    from talaia.gateway.video.pixels import Pixels

__all__ = ["KEY_EVERY_S", "CameraFilm"]

# To jump to a picture, all since the last of these are decoded.
KEY_EVERY_S = 2.0


class CameraFilm:
    """One camera's film; used by the encoding thread alone."""

    def __init__(self) -> None:
        """Begin with a picture that needs none before it."""
        self._shared = False  # What viewers get is filmed; until their pace leaves pictures out.
        # Its own; None while the viewers' serves, or nobody films.
        self._encoder: Encoder | None = None
        # Width, height, bit/s and Hz of `_encoder`.
        self._made_for: tuple[int, int, int, float] | None = None
        self._wants_key = True  # The next picture must need none before it.
        self._key_us = 0  # When the last such picture of its own was made (monotonic µs).

    def stop_filming(self) -> None:
        """Nobody films now."""
        self._shared, self._wants_key = False, True
        self._encoder = self._made_for = None

    def can_share(self, picture: PictureFrame | None, *, whole: bool, anew: bool) -> bool:
        """Tell whether the viewers' film serves; else the picture must be encoded by `encode_own`.

        Args:
            picture: what the viewers get of this picture; none where their pace leaves it out.
            whole: they get every picture, in full.
            anew: one that needs none before it is wanted.

        """
        if anew:
            self._shared, self._wants_key = False, True
        if not whole:
            # From a shared film to its own: the new encoder has seen nothing of what came before.
            self._wants_key = self._wants_key or self._shared
            self._shared = False
        # A film may only change over at a picture that needs none before it.
        elif picture is not None and picture.key:
            self._shared, self._wants_key = True, False
        return self._shared

    def encode_own(
        self, address: str, stamp: FrameStamp, pixels: Pixels, made_for: tuple[int, int, int, float]
    ) -> PictureFrame | None:
        """Encode a picture for the film alone.

        Args:
            address: the camera's.
            stamp: the picture's number and times.
            pixels: the picture.
            made_for: width and height (px), bit rate (bit/s) and rate (Hz) of the film.

        Raises:
            FieldError: it cannot be encoded.

        """
        if self._encoder is None or self._made_for != made_for:
            width, height, bits, rate = made_for
            self._encoder = Encoder(
                width=width, height=height, rate=rate, bits=bits, key_every_s=KEY_EVERY_S
            )
            self._made_for, self._wants_key = made_for, True
        encoder = self._encoder
        # By the time that passes, for a camera may be slower than it is allowed to be.
        due = self._wants_key or stamp.mono_us - self._key_us >= KEY_EVERY_S * 1e6
        made = encoder.encode_picture(pixels, stamp.mono_us, key=due)
        if made is None:
            # No packet yet: `_wants_key` and the last key picture's time stand.
            return None
        if made.key:
            self._wants_key, self._key_us = False, stamp.mono_us
        return PictureFrame(
            stream=address,
            **stamp._asdict(),
            width=encoder.width,
            height=encoder.height,
            format="h264",
            key=made.key,
            codec=encoder.codec if made.key else "",
            data=made.data,
        )
