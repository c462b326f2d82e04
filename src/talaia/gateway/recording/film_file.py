"""Films of one camera as MP4: written so that a kill leaves them readable, and made whole again.

While it is written, a film is *fragmented*: what is needed to read a part of it stands in front of
that part. Once it has ended, all of that is moved to the front of the file, and no picture is
encoded again: then a browser can jump to any of them. Needs PyAV.
"""

from __future__ import annotations

import contextlib
import datetime as dt
from fractions import Fraction
from typing import TYPE_CHECKING

import av

from talaia import __version__
from talaia.gateway.recording.recording_store import RecoveredFile

if TYPE_CHECKING:
    from collections.abc import Iterator
    from pathlib import Path

    from talaia.wire.frames import PictureFrame

__all__ = ["FilmFile", "recover_film"]

# Time base of MP4 packets: µs, like the pictures' own times.
_MICROS = Fraction(1, 1_000_000)
# What a killed gateway loses of a film is at most this (µs).
_FRAGMENT_US = 500_000
_PARTS = {
    # FFmpeg's mov flags: a header without pictures, fragments that stand by themselves.
    "movflags": "empty_moov+delay_moov+default_base_moof",
    "frag_duration": str(_FRAGMENT_US),
    "flush_packets": "1",
}
# Index in front, so that a browser jumps without reading the file to its end.
_WHOLE = {"movflags": "faststart"}
# In the file's comment: when its first picture came, for who has nothing but the file.
_BEGIN = "first picture (us since 1970, UTC): "


class FilmFile:
    """One film that is being written. Used by one thread.

    Attributes:
        pictures: how many are in it.
        size: bytes of its pictures.
        end_us: when the last one came (wall, UTC).

    """

    def __init__(self, path: Path, first: PictureFrame) -> None:
        """Begin with ``first``, which needs none before it.

        Raises:
            OSError: it cannot be written.

        """
        # Wall (µs UTC); packets count from the first picture.
        self._begin_us = self.end_us = first.time_us
        # A change of size needs another file.
        self.width, self.height = first.width, first.height
        self.pictures = self.size = 0
        with _translated_errors():
            self._container = av.open(str(path), "w", format="mp4", options=_PARTS)
            self._container.metadata.update(_metadata_of(first))
            self._stream = self._container.add_mux_stream(
                "h264", width=first.width, height=first.height
            )
            self._stream.time_base = _MICROS
        try:
            self.add_picture(first)
        except BaseException:
            self.drop_file()
            raise

    def may_follow(self, picture: PictureFrame) -> bool:
        """Tell whether a picture may follow: it is later, and of the same size."""
        same = (picture.width, picture.height) == (self.width, self.height)
        return same and picture.time_us > self.end_us

    def add_picture(self, picture: PictureFrame) -> None:
        """Write a picture that `may_follow`.

        Raises:
            OSError: the disk is full, or worse.

        """
        packet = av.Packet(picture.data)
        # Decode order is show order: the encoder makes no B-frames.
        packet.pts = packet.dts = picture.time_us - self._begin_us
        packet.time_base = _MICROS
        packet.is_keyframe = picture.key
        packet.stream = self._stream
        with _translated_errors():
            self._container.mux(packet)
        self.end_us = picture.time_us
        self.pictures += 1
        self.size += len(picture.data)

    def finish_file(self, part: Path, whole: Path) -> None:
        """Close ``part``, and write the same to ``whole`` as it is to stay.

        Raises:
            OSError: the disk is full, or worse.

        """
        with _translated_errors():
            self._container.close()
        recover_film(part, whole)

    def drop_file(self) -> None:
        """Close as it is."""
        with contextlib.suppress(OSError), _translated_errors():
            self._container.close()


def recover_film(broken: Path, whole: Path) -> RecoveredFile:
    """Copy all pictures that can be read into a file that begins with where each of them is.

    Raises:
        OSError: it cannot be read or written.
        ValueError: there is no picture in it.

    """
    count = last = begin_us = 0
    with _translated_errors(), av.open(str(broken), format="mp4") as source:
        begin_us = _begin_in(source.metadata)
        stream = source.streams.video[0]
        with av.open(str(whole), "w", format="mp4", options=_WHOLE) as target:
            target.metadata.update(source.metadata)
            copy = target.add_stream_from_template(stream)
            copy.time_base = stream.time_base
            for packet in _read_packets(source, stream):
                # FFmpeg ends a stream with an empty packet; a torn one has no time.
                if packet.pts is None or packet.is_corrupt or not packet.size:
                    continue
                last = packet.pts
                packet.stream = copy
                target.mux(packet)
                count += 1
    if not count:
        # An empty MP4 is no film; nobody should be offered it.
        whole.unlink(missing_ok=True)
        raise ValueError("it holds no picture")
    return RecoveredFile(count, begin_us + last)


def _read_packets(
    source: av.container.InputContainer, stream: av.VideoStream
) -> Iterator[av.Packet[av.VideoStream]]:
    # 0 becomes a picture in 1970 nowhere: without pictures it is never kept.
    packets = source.demux(stream)
    while True:
        try:
            yield next(packets)
        except (StopIteration, av.FFmpegError):
            # Here it was cut off.
            return


def _metadata_of(first: PictureFrame) -> dict[str, str]:
    moment = dt.datetime.fromtimestamp(first.time_us / 1e6, dt.UTC)
    return {
        "title": first.stream,
        "creation_time": moment.isoformat(timespec="microseconds").replace("+00:00", "Z"),
        "comment": f"{_BEGIN}{first.time_us}",
        "encoder": f"talaia {__version__}",
    }


def _begin_in(metadata: dict[str, str]) -> int:
    number = metadata.get("comment", "").removeprefix(_BEGIN)
    return int(number) if number.isascii() and number.isdecimal() else 0


@contextlib.contextmanager
def _translated_errors() -> Iterator[None]:
    """Raise what the library raises as what the caller knows."""
    try:
        yield
    except (av.FFmpegError, IndexError) as error:
        raise OSError(f"the film cannot be read or written: {error}") from error
