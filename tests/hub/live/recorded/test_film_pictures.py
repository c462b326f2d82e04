"""One picture of a film: the hub gives what a decoder needs for it, of a broken file nothing."""

from __future__ import annotations

import random
import struct
from fractions import Fraction

import av
import numpy as np
import pytest

from talaia.gateway.recording.film_file import FilmFile
from talaia.hub.files.local_folder import LocalFolder
from talaia.hub.live.recorded.errors import RecordingUnreadable
from talaia.hub.live.recorded.film_index import find_tables, read_index
from talaia.hub.live.recorded.film_pictures import FilmPictures
from talaia.hub.store.sites.recordings import Recorded, RecordingState
from talaia.wire.frames import PictureFrame

BEGIN_US, SIZE, KEY_EVERY = 1_700_000_000_000_000, 64, 10
# Pictures come when they come.
TIMES_US = [0, *np.cumsum(np.random.default_rng(1).integers(20_000, 300_000, 39)).tolist()]


def encoded():
    """Encode grey pictures, each a little lighter than the last, as a gateway does."""
    encoder = av.CodecContext.create("libx264", "w")
    encoder.width = encoder.height = SIZE
    encoder.pix_fmt, encoder.time_base = "yuv420p", Fraction(1, 1_000_000)
    forced = f"keyint={KEY_EVERY}:scenecut=0"
    encoder.options = {"tune": "zerolatency", "profile": "baseline", "x264-params": forced}
    for number, at_us in enumerate(TIMES_US):
        plane = np.full((SIZE, SIZE, 3), 20 + 5 * number, np.uint8)
        frame = av.VideoFrame.from_ndarray(plane, format="rgb24")
        frame.pts = at_us
        (packet,) = encoder.encode(frame)
        yield PictureFrame(
            stream="camera/front", seq=number, time_us=BEGIN_US + at_us, mono_us=number,
            width=SIZE, height=SIZE, format="h264", key=packet.is_keyframe, data=bytes(packet),
        )  # fmt: skip


@pytest.fixture(scope="module")
def film(tmp_path_factory):
    """Have a film in a hub's folder; the folder, and what the list says of it."""
    folder = tmp_path_factory.mktemp("films")
    whole, part = folder / "recordings" / "agv" / "film1.mp4", folder / "film.part"
    whole.parent.mkdir(parents=True)
    first, *others = encoded()
    file = FilmFile(part, first)
    for picture in others:
        file.add_picture(picture)
    file.finish_file(part, whole)
    told = Recorded(
        site="agv", id="film1", state=RecordingState.COMPLETE, why="", who="", note="",
        begin_us=BEGIN_US, end_us=file.end_us, size=whole.stat().st_size, have=0,
        messages=file.pictures, digest="", topics=(), stream="camera/front",
    )  # fmt: skip
    return folder, told


def light_of(picture):
    """Decode what the hub gave, as a browser does; how light the last picture is."""
    decoder = av.CodecContext.create("h264", "r")
    decoder.extradata = picture.description
    frames = [frame for data in picture.data for frame in decoder.decode(av.Packet(data))]
    frames += decoder.decode(None)
    assert len(frames) == len(picture.data) == len(picture.times_us)
    return float(frames[-1].to_ndarray(format="rgb24").mean())


@pytest.mark.parametrize(
    ("at_us", "number"),
    [(-5_000_000, 0), (0, 0), (TIMES_US[1] - 1, 0), (TIMES_US[1], 1), (TIMES_US[9] + 1, 9),
     (TIMES_US[10], 10), (TIMES_US[27] + 10_000, 27), (TIMES_US[-1] + 9_000_000, 39)],
)  # fmt: skip
async def test_the_picture_of_a_moment_is_the_last_that_has_come(film, at_us, number) -> None:
    folder, told = film
    picture = await FilmPictures(LocalFolder(folder)).find_picture(told, BEGIN_US + at_us)
    assert picture.times_us[-1] == BEGIN_US + TIMES_US[number]
    # From the last whole one on, and not one more.
    assert picture.times_us[0] == BEGIN_US + TIMES_US[number // KEY_EVERY * KEY_EVERY]
    assert light_of(picture) == pytest.approx(20 + 5 * number, abs=2)
    beside = [BEGIN_US + TIMES_US[at] if 0 <= at < 40 else None for at in (number - 1, number + 1)]
    assert [picture.before_us, picture.next_us] == beside
    assert picture.codec.startswith("avc1.42")


def test_what_a_film_s_tables_say_wrongly_is_refused_and_nothing_else_happens(film) -> None:
    folder, told = film
    whole = (folder / "recordings" / "agv" / "film1.mp4").read_bytes()
    begin, end = find_tables(whole)
    tables = whole[begin:end]
    assert len(read_index(tables, told.size).times_us) == 40
    with pytest.raises(RecordingUnreadable, match="shorter"):
        read_index(tables, told.size - 1)
    chance, refused = random.Random(2), 0  # noqa: S311 - breaks what is read
    for _ in range(3000):
        broken = bytearray(tables)
        for _ in range(chance.randrange(1, 4)):
            at = chance.randrange(len(broken))
            broken[at] = chance.choice((0, 1, 127, 255, broken[at] ^ 128))
        try:
            cut = chance.choice((len(broken), chance.randrange(len(broken))))
            index = read_index(bytes(broken[:cut]), told.size)
        except RecordingUnreadable:
            refused += 1
            continue
        # What is taken lies within the file, and within the film.
        assert (index.offsets >= 0).all()
        assert int((index.offsets + index.sizes).max()) <= told.size
        assert ((index.keys >= 0) & (index.keys <= np.arange(len(index.keys)))).all()
    assert refused > 300


def box(kind: bytes, *parts: bytes) -> bytes:
    body = b"".join(parts)
    return struct.pack(">I4s", 8 + len(body), kind) + body


def words(*numbers: int) -> bytes:
    return struct.pack(f">{len(numbers)}I", *numbers)


def tables_of(pictures: int, size: int, at: int) -> bytes:
    """Tables of pictures that all lie at one place, of which only the first is whole."""
    head = box(b"avcC", b"\x01\x42\xc0\x1e\xff")
    form = box(b"avc1", bytes(78), head)
    tables = box(
        b"stbl",
        box(b"stsd", words(0, 1), form),
        box(b"stts", words(0, 1, pictures, 100)),
        box(b"stsz", words(0, size, pictures)),
        box(b"stsc", words(0, 1, 1, 1, 1)),
        box(b"stco", words(0, pictures), words(*[at] * pictures)),
        box(b"stss", words(0, 1, 1)),
    )
    return box(b"trak", box(b"mdia", box(b"mdhd", words(0, 0, 0, 1000, 0)), box(b"minf", tables)))


def test_pictures_that_lie_upon_each_other_are_refused() -> None:
    # A small file would be an answer of any size.
    assert len(read_index(tables_of(10, 100, 5000), 6000).sizes) == 10
    with pytest.raises(RecordingUnreadable, match="shorter"):
        read_index(tables_of(100, 1000, 5000), 6000)


async def test_between_two_whole_pictures_stands_no_more_than_an_answer_holds(
    tmp_path, film
) -> None:
    _, told = film
    tables = box(b"moov", tables_of(30, 400_000, 1000))
    file = tmp_path / "recordings" / "agv" / "film1.mp4"
    file.parent.mkdir(parents=True)
    # 30 times 400 kB at one place, in a file that has room for them.
    file.write_bytes(tables + bytes(12_100_000 - len(tables)))
    pictures = FilmPictures(LocalFolder(tmp_path))
    told = told._replace(size=file.stat().st_size)
    assert len((await pictures.find_picture(told, BEGIN_US)).data) == 1
    with pytest.raises(RecordingUnreadable, match="too much"):
        await pictures.find_picture(told, BEGIN_US + 9_000_000)


async def test_a_file_that_is_no_film_is_said_to_be_none(tmp_path, film) -> None:
    _, told = film
    file = tmp_path / "recordings" / "agv" / "film1.mp4"
    file.parent.mkdir(parents=True)
    file.write_bytes(b"no film at all" * 400)
    with pytest.raises(RecordingUnreadable):
        await FilmPictures(LocalFolder(tmp_path)).find_picture(told, BEGIN_US)
