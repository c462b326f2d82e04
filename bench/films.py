"""What a film costs the gateway: processor time for each picture, and for finishing a long one.

    python bench/films.py [PICTURES]

A picture of 640x480 with something that moves in it, as a ROS camera sends it (rgb8), at 30 Hz.
Times are those of the thread that does the work (`time.thread_time`), so that other programs on
the machine count for little.
"""

from __future__ import annotations

import sys
import tempfile
import time
from pathlib import Path
from types import SimpleNamespace
from typing import TYPE_CHECKING

import numpy as np

from talaia.gateway.ports import Filming
from talaia.gateway.recording.film_file import FilmFile
from talaia.gateway.video.camera import PictureStream
from talaia.model.connection import RosSource
from talaia.model.site import Stream
from talaia.wire.frames import PictureForm, PictureFrame

if TYPE_CHECKING:
    from collections.abc import Iterable, Sequence

WIDTH, HEIGHT, STEP_US = 640, 480, 33_333
START_US = 1_700_000_000_000_000
SECONDS = 600
RUNS = 5


class Sink:
    """A `PictureSink`: viewers or none, a film or none, a line that is good or bad."""

    def __init__(self, *forms: PictureForm, film: bool, share: float = 1.0) -> None:
        """Want these."""
        self.forms, self.share = forms, share
        self.wish = Filming.ON if film else Filming.NO
        self.filmed: list[PictureFrame] = []

    def asked(self, _stream: str) -> tuple[PictureForm, ...]:
        """See `PictureSink.asked`."""
        return self.forms

    def key_due(self, _stream: str, _form: str) -> bool:
        """See `PictureSink.key_due`."""
        return False

    def room(self) -> float:
        """See `PictureSink.room`."""
        return self.share

    def offer_frame(self, *_frame: object) -> None:
        """See `PictureSink.offer_frame`."""

    def filming(self, _stream: str, _time_us: int) -> Filming:
        """See `PictureSink.filming`."""
        return self.wish

    def film(self, picture: PictureFrame) -> None:
        """See `PictureSink.film`."""
        self.filmed.append(picture)

    def offer(self, picture: PictureFrame) -> None:
        """See `PictureSink.offer`."""

    def trouble(self, _stream: str, why: str) -> None:
        """See `PictureSink.trouble`."""
        raise AssertionError(why)


def pictures(count: int) -> list[SimpleNamespace]:
    """Make what is sent over and over: a room that passes by, with a box that wanders in it."""
    rng = np.random.default_rng(1)
    room = rng.integers(90, 150, (HEIGHT // 4, WIDTH // 4, 3), np.uint8)
    room = room.repeat(4, 0).repeat(4, 1)
    found = []
    for at in range(min(count, 60)):
        picture = np.roll(room, 3 * at, 1)
        left = 8 * at
        picture[200:300, left : left + 80] = (200, 60, 40)
        found.append(
            SimpleNamespace(
                width=WIDTH, height=HEIGHT, encoding="rgb8", is_bigendian=0, step=3 * WIDTH,
                data=picture.ravel(),
            )
        )  # fmt: skip
    return found


def run(sink: Sink, count: int) -> float:
    """Give the processor time for a picture (ms), the best of some runs."""
    return min(once(sink, count) for _ in range(RUNS))


def once(sink: Sink, count: int) -> float:
    """Give the same of one run."""
    sink.filmed.clear()
    source = RosSource(topic="/i", type="sensor_msgs/msg/Image")
    taker = PictureStream("c/f", Stream(name="F", source=source), lambda raw: raw, lambda *_: None)
    sent = pictures(count)
    begin = 0.0
    for at in range(count + 30):
        if at == 30:
            begin = time.thread_time()
        taker.process_picture(sent[at % len(sent)], at * STEP_US, at * STEP_US, sink)
    return (time.thread_time() - begin) / count * 1e3


def write_pictures(
    part: Path, film: Sequence[PictureFrame], times_us: Iterable[int], *, stream: str
) -> FilmFile:
    """Write a film of these pictures, again and again, with one at each time."""
    file: FilmFile | None = None
    for at, time_us in enumerate(times_us):
        one = film[at % len(film)]
        told = PictureFrame(
            stream=stream, seq=at, time_us=time_us, mono_us=at, width=WIDTH, height=HEIGHT,
            format="h264", key=one.key, data=one.data,
        )  # fmt: skip
        if file is None:
            file = FilmFile(part, told)
        else:
            file.add_picture(told)
    assert file is not None
    return file


def main() -> None:
    """Print all of it."""
    count = int(sys.argv[1]) if len(sys.argv) > 1 else 300
    alone = Sink(film=True)
    rows = [
        ("nobody looks, nothing is filmed", Sink(film=False)),
        ("a viewer", Sink(PictureForm.H264, film=False)),
        ("a viewer and a film (one encoding)", Sink(PictureForm.H264, film=True)),
        ("a film alone", alone),
        ("a viewer on a bad line and a film (two)", Sink(PictureForm.H264, film=True, share=0.4)),
    ]
    for what, sink in rows:
        print(f"{what:42s} {run(sink, count):6.2f} ms a picture")
    film = alone.filmed
    size = sum(len(each.data) for each in film) / len(film)
    print(f"{'a film of 640x480 at 30 Hz':42s} {size * 30 * 8 / 1e6:6.2f} Mbit/s")
    with tempfile.TemporaryDirectory() as folder:
        part, whole = Path(folder) / "f.mp4.part", Path(folder) / "f.mp4"
        begin = time.thread_time()
        times_us = range(START_US, START_US + SECONDS * 30 * STEP_US, STEP_US)
        file = write_pictures(part, film, times_us, stream="c/f")
        wrote, ended = time.thread_time() - begin, time.perf_counter()
        file.finish_file(part, whole)
        took = time.perf_counter() - ended
        print(f"{'to write a picture of it':42s} {wrote / SECONDS / 30 * 1e6:6.1f} µs")
        size_mb = whole.stat().st_size / 1e6
        print(f"{f'to finish ten minutes of it ({size_mb:.0f} MB)':42s} {took:6.2f} s")


if __name__ == "__main__":
    main()
