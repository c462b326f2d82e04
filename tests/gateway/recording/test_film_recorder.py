"""Cameras are filmed: what a film shows, and when, is what the camera sent, and when."""

from __future__ import annotations

import asyncio
import hashlib
import signal
import subprocess
import sys
import threading
import time
from pathlib import Path

import pytest
from patience import PATIENCE_S

pytest.importorskip("av")

import av
import numpy as np
from fake_hub import fake_hub
from gateway_bench import SITE, Peer, addresses_of, running
from hypothesis import given, settings, strategies as st

from talaia.clock import HandClock
from talaia.gateway.ports import Filming
from talaia.gateway.recording.film_file import recover_film
from talaia.gateway.recording.film_recorder import FilmRecorder
from talaia.gateway.recording.film_ring import FilmRing
from talaia.gateway.recording.recording_store import FILM, RecordingStore
from talaia.model.checks.site_checks import check_site
from talaia.model.recording import Recording, Trigger
from talaia.model.yaml_text.load import load_site
from talaia.wire.frames import (
    FileOffer,
    FilmOffer,
    PictureForm,
    PictureFrame,
    RecorderState,
    RecordingRequest,
    StopRequest,
)

from ..adapters.video.rtsp_camera import RtspCamera
from ..adapters.video.test_adapter import until, watched
from ..video.scenes import number_in, numbered, packed, psnr, scene
from ..video.test_camera import Hall, stream

SECOND = 1_000_000_000
CAMERA = "cam/front"


def shown(path: Path) -> list[tuple[int, np.ndarray]]:
    """Give each picture of a film with its time in it (µs)."""
    with av.open(str(path)) as film:
        return [(each.pts, each.to_ndarray(format="rgb24")) for each in film.decode(video=0)]


def numbers_in(path: Path) -> list[int]:
    return [number_in(picture) for _, picture in shown(path)]


class Bench:
    """Films with all that they tell, and a camera whose pictures have a number."""

    def __init__(
        self,
        folder: Path,
        cameras: tuple[str, ...] = (),
        clips: dict[str, float] | None = None,
        **plan: object,
    ) -> None:
        """Begin; ``plan`` is of `Recording`."""
        self.clock = HandClock()
        self.shelf = RecordingStore(folder, 10**9, 0, FILM)
        self.shelf.open(recover_film)
        self.events: list[tuple[str, str]] = []
        self.finished = threading.Semaphore(0)
        self.films = FilmRecorder(
            plan=Recording(**plan),
            cameras=cameras,
            clips=clips or {},
            shelf=self.shelf,
            clock=self.clock,
            events=self,
            finished=self.finished.release,
            changed=lambda: None,
        )
        self.films.start()
        self.hall = Hall()
        self.hall.filming = self.films.filming
        self.hall.film = self.films.add_picture
        self.camera, _ = stream(max_rate=30.0)
        self.seq = 0
        self.times: list[int] = []

    def report_event(self, kind: str, message: str, **_: object) -> None:
        self.events.append((kind, message))
        if kind == "recording_failed":
            self.finished.release()

    def send(self, count: int, step_ns: int = SECOND // 20, size: tuple[int, int] = (320, 240)):
        """Have the camera send so many pictures; give their times (µs)."""
        times = []
        for _ in range(count):
            wall, mono = self.clock.wall_ns() // 1000, self.clock.monotonic_ns() // 1000
            picture = packed(numbered(self.seq, *size), "rgb8")
            self.camera.process_picture(picture, wall, mono, self.hall)
            times.append(wall)
            self.seq += 1
            self.clock.advance(step_ns)
        return times

    def wait(self) -> None:
        assert self.finished.acquire(timeout=PATIENCE_S)

    def paths(self) -> list[Path]:
        return [self.shelf.whole_path(each.id) for each in self.shelf.list_waiting()]


def test_a_camera_of_clips_is_filmed_from_its_own_seconds_before_on_and_for_no_longer(tmp_path):
    bench = Bench(tmp_path, clips={CAMERA: 2.0}, before=0)
    assert bench.films.wanted_cameras() == {CAMERA}
    bench.send(200)
    bench.films.begin_film("", "person in sight", 1.0, CAMERA)
    bench.send(60)
    bench.wait()
    [path] = bench.paths()
    numbers = numbers_in(path)
    # 20 pictures a second: two seconds before, at the most a key picture earlier, and one after.
    assert 100 <= numbers[0] <= 160
    assert 215 <= numbers[-1] <= 225
    bench.films.redescribe((), {})
    assert bench.films.wanted_cameras() == frozenset()


PICTURES = st.builds(
    lambda step, size, key: (step, size, key),
    st.integers(0, 3_000_000), st.integers(0, 900), st.booleans(),
)  # fmt: skip


@settings(deadline=None)
@given(st.lists(PICTURES, max_size=60), st.integers(1, 10), st.integers(500, 20_000))
def test_what_is_held_begins_with_a_picture_that_needs_none_and_reaches_back_far_enough(
    steps, keep_s, most
) -> None:
    ring, now, sent = FilmRing(keep_s * 1_000_000, most), 0, []
    for at, (step, size, key) in enumerate(steps):
        now += step
        picture = PictureFrame(
            stream=CAMERA, seq=at, time_us=now, mono_us=now, width=2, height=2, key=key,
            data=bytes(size),
        )  # fmt: skip
        sent.append(picture)
        took = ring.add_picture(picture)
        assert ring.bytes <= most
        assert took == (len(ring) > 0)
    held = ring.drain_pictures()
    assert (len(ring), ring.bytes) == (0, 0)
    assert held == sent[len(sent) - len(held) :]
    if held:
        assert held[0].key
        keys = [each for each in held if each.key]
        # No more than is needed: without its first run it would not reach back far enough.
        assert len(keys) == 1 or now - keys[1].mono_us < keep_s * 1_000_000


def test_a_film_shows_what_was_sent_at_the_time_when_it_came(tmp_path) -> None:
    bench = Bench(tmp_path, longest=60.0)
    bench.films.begin_film("ada", "to look at", 60.0, CAMERA)
    times = []
    for step_ms in (50, 33.333, 120.5, 10, 700):
        times += bench.send(8, round(step_ms * 1e6))
    bench.films.end_film("ben", CAMERA)
    bench.wait()
    (kept,) = bench.shelf.list_waiting()
    film = shown(bench.shelf.whole_path(kept.id))
    assert [kept.begin_us + at for at, _ in film] == times
    assert [number_in(picture) for _, picture in film] == list(range(40))
    assert psnr(film[-1][1][80:], numbered(39)[80:]) > 30
    assert (kept.stream, kept.messages, kept.end_us) == (CAMERA, 40, times[-1])
    assert (kept.why, kept.who, kept.note) == ("to look at", "ada", "ended by ben")
    body = bench.shelf.whole_path(kept.id).read_bytes()
    assert kept.digest == hashlib.sha256(body).hexdigest()
    # A browser finds each picture without reading all of it.
    assert body.index(b"moov") < body.index(b"mdat")
    assert b"moof" not in body
    with av.open(str(bench.shelf.whole_path(kept.id))) as opened:
        assert opened.metadata["comment"].endswith(f": {times[0]}")
    bench.films.close()


def test_a_cause_films_what_was_before_it_of_the_cameras_that_are_named(tmp_path) -> None:
    bench = Bench(tmp_path, (CAMERA,), before=2.0, after=1.0)
    assert bench.films.wanted_cameras() == {CAMERA}
    bench.send(100)
    assert bench.films.rolling_cameras() == []
    bench.films.begin_film("ada", "STOP (software)", 1.0)
    assert bench.films.rolling_cameras() == [CAMERA]
    bench.send(21)
    bench.wait()
    (path,) = bench.paths()
    numbers = numbers_in(path)
    # 2 s before the cause, and as far as the picture before that is needed for the first.
    assert 20 <= numbers[0] <= 60
    assert numbers == list(range(numbers[0], numbers[-1] + 1))
    assert 118 <= numbers[-1] <= 121
    # Nothing is held of a camera that is not named, and it can be filmed all the same.
    bench.films.close()
    bare = Bench(tmp_path / "bare", before=2.0)
    assert bare.films.wanted_cameras() == frozenset()
    assert bare.films.filming(CAMERA, 1) is Filming.NO
    bare.films.begin_film("ada", "STOP", 1.0)
    assert bare.films.rolling_cameras() == []
    bare.films.close()


def test_a_film_is_cut_where_it_would_not_tell_the_truth(tmp_path) -> None:
    """Silence, a clock that was put back, another size: none is bridged."""
    bench = Bench(tmp_path, longest=600.0)
    bench.films.begin_film("ada", "a test", 600.0, CAMERA)
    bench.send(10)
    bench.clock.advance(10 * SECOND)
    bench.send(10)
    bench.wait()
    back = bench.clock.wall_ns
    bench.clock.wall_ns = lambda: back() - 3600 * SECOND
    bench.send(10)
    bench.wait()
    bench.send(10, size=(160, 120))
    bench.wait()
    bench.films.close()
    found = sorted(numbers_in(path) for path in bench.paths())
    assert found == [list(range(first, first + 10)) for first in (0, 10, 20, 30)]
    assert {kind for kind, _ in bench.events} == {"recording_started", "recording_ended"}


def test_a_slow_camera_makes_one_film_and_not_one_of_each_picture(tmp_path) -> None:
    bench = Bench(tmp_path, longest=3600.0)
    bench.films.begin_film("ada", "a night", 3600.0, CAMERA)
    bench.send(12, 10 * SECOND)
    bench.films.end_film("ada", CAMERA)
    bench.wait()
    bench.films.close()
    lengths = [len(numbers_in(path)) for path in bench.paths()]
    assert sum(lengths) == 12
    assert max(lengths) >= 10


def test_a_film_that_cannot_be_written_says_so_once_and_the_next_goes_well(tmp_path) -> None:
    folder = tmp_path / "films"
    bench = Bench(folder)
    folder.rmdir()
    bench.films.begin_film("ada", "", 60.0, CAMERA)
    bench.send(5)
    bench.wait()
    assert [kind for kind, _ in bench.events].count("recording_failed") == 1
    assert "No such file" in bench.films.problem
    assert bench.films.rolling_cameras() == []
    folder.mkdir()
    bench.films.begin_film("ada", "", 60.0, CAMERA)
    bench.send(5)
    bench.films.end_film("ada", CAMERA)
    bench.wait()
    assert numbers_in(bench.paths()[0]) == [5, 6, 7, 8, 9]
    assert bench.films.problem == ""
    bench.films.close()


def test_a_large_film_goes_on_in_another_file(tmp_path) -> None:
    bench = Bench(tmp_path, file_mb=0.05)
    bench.films.begin_film("ada", "", 600.0, CAMERA)
    bench.send(120)
    bench.films.close()
    assert len(bench.paths()) > 1
    assert [number for path in bench.paths() for number in numbers_in(path)] == list(range(120))


def test_viewers_and_film_share_one_encoding_while_the_line_is_good() -> None:
    hall, (taker, _) = Hall(PictureForm.H264), stream()
    hall.wish = Filming.ANEW

    def take(first: int, count: int) -> None:
        for at in range(first, first + count):
            taker.process_picture(packed(numbered(at), "rgb8"), at * 33_333, at * 33_333, hall)

    take(0, 30)
    shared = {id(each) for each in hall.got}
    assert [id(each) in shared for each in hall.filmed] == [True] * 30
    # A bad line makes the viewers' picture worse, and leaves some of it out; not so the film's.
    hall.share = 0.3
    take(30, 30)
    hall.share = 0.0
    take(60, 30)
    shared |= {id(each) for each in hall.got}
    assert [id(each) in shared for each in hall.filmed[30:]] == [False] * 60
    assert hall.filmed[30].key
    # Good again: with the viewers' next picture that needs none before it, it is one again.
    hall.share = 1.0
    hall.keys.add(PictureForm.H264)
    take(90, 30)
    assert hall.filmed[-1] is hall.got[-1]
    # Nobody looks on any more.
    hall.forms = ()
    take(120, 10)
    decoder = av.CodecContext.create("h264", "r")
    frames = [each for one in hall.filmed for each in decoder.decode(av.Packet(one.data))]
    frames += decoder.decode(None)
    numbers = [number_in(each.to_ndarray(format="rgb24")) for each in frames]
    assert numbers == list(range(130))
    # Once nobody films, its encoder is let go of.
    hall.wish = Filming.NO
    take(130, 2)
    assert len(hall.filmed) == 130


def test_a_film_with_two_encoders_in_it_plays_from_any_of_its_pictures(tmp_path) -> None:
    bench = Bench(tmp_path)
    bench.hall.forms = (PictureForm.H264,)
    bench.films.begin_film("ada", "", 600.0, CAMERA)
    bench.send(30)
    bench.hall.share = 0.2
    bench.send(30)
    bench.hall.share = 1.0
    bench.hall.keys.add(PictureForm.H264)
    bench.send(30)
    bench.films.close()
    (path,) = bench.paths()
    assert numbers_in(path) == list(range(90))
    with av.open(str(path)) as film:
        for wanted in (75, 15, 45):
            film.seek(wanted * 50_000, stream=film.streams.video[0])
            seen = next(each for each in film.decode(video=0) if each.pts >= wanted * 50_000)
            assert number_in(seen.to_ndarray(format="rgb24")) == wanted


def test_a_film_that_was_cut_anywhere_is_made_whole_up_to_there(tmp_path) -> None:
    bench = Bench(tmp_path)
    bench.films.begin_film("ada", "a long one", 600.0, CAMERA)
    bench.send(100)
    # The file as it lies on the disk while it is written.
    deadline = time.monotonic() + PATIENCE_S
    (part,) = (part for part in [*tmp_path.glob("*.mp4.part")])
    while bench.films._reels[CAMERA].file.pictures < 100:
        assert time.monotonic() < deadline
    body = part.read_bytes()
    about = part.with_name(part.name.replace(".mp4.part", ".json")).read_bytes()
    bench.films.close()
    lengths = []
    for cut in (len(body) // 3, len(body) * 2 // 3, len(body) - 9, len(body)):
        folder = tmp_path / str(cut)
        folder.mkdir()
        (folder / part.name).write_bytes(body[:cut])
        (folder / part.name.replace(".mp4.part", ".json")).write_bytes(about)
        shelf = RecordingStore(folder, 10**9, 0, FILM)
        shelf.open(recover_film)
        (kept,) = shelf.list_waiting()
        film = shown(shelf.whole_path(kept.id))
        assert [number_in(picture) for _, picture in film] == list(range(len(film)))
        assert (kept.messages, kept.stream) == (len(film), CAMERA)
        assert kept.end_us == kept.begin_us + film[-1][0]
        assert "in the middle" in kept.note
        lengths.append(len(film))
    # Half a second is lost at the most.
    assert 0 < lengths[0] < lengths[1] <= lengths[2]
    assert lengths[-1] >= 88
    (tmp_path / "x.mp4.part").write_bytes(b"noise")
    RecordingStore(tmp_path, 10**9, 0, FILM).open(recover_film)
    assert not (tmp_path / "x.mp4.part").exists()


FILMING = """
import sys, time
sys.path.insert(0, {tests!r})
from pathlib import Path
from talaia.clock import SystemClock
from talaia.gateway.recording.film_file import recover_film
from talaia.gateway.recording.film_recorder import FilmRecorder
from talaia.gateway.recording.recording_store import FILM, RecordingStore
from talaia.model.recording import Recording
from gateway.video.scenes import numbered, packed
from gateway.video.test_camera import Hall, stream

class Events:
    def report_event(self, *_, **__): pass

shelf = RecordingStore(Path({folder!r}), 10**9, 0, FILM)
shelf.open(recover_film)
films = FilmRecorder(
    plan=Recording(), cameras=(), clips={{}}, shelf=shelf, clock=SystemClock(), events=Events(),
    finished=lambda: None, changed=lambda: None,
)
films.start()
films.begin_film("ada", "", 600.0, "cam/front")
hall = Hall()
hall.filming, hall.film = films.filming, films.add_picture
taker, _ = stream()
clock = SystemClock()
for at in range(10_000):
    stamp = (clock.wall_ns() // 1000, clock.monotonic_ns() // 1000)
    taker.process_picture(packed(numbered(at), "rgb8"), *stamp, hall)
    print(at, flush=True)
    time.sleep(0.02)
"""


def test_a_killed_gateway_leaves_what_it_has_filmed(tmp_path) -> None:
    program = FILMING.format(tests=str(Path(__file__).parents[2]), folder=str(tmp_path / "films"))
    with subprocess.Popen(
        [sys.executable, "-c", program], stdout=subprocess.PIPE, text=True
    ) as filming:
        assert filming.stdout is not None
        for line in filming.stdout:
            if int(line) == 120:
                filming.send_signal(signal.SIGKILL)
                break
    shelf = RecordingStore(tmp_path / "films", 10**9, 0, FILM)
    shelf.open(recover_film)
    (kept,) = shelf.list_waiting()
    numbers = numbers_in(shelf.whole_path(kept.id))
    assert numbers == list(range(len(numbers)))
    # Half a second at 50 Hz, and what the writer has not come to.
    assert len(numbers) > 120 - 25 - 15


async def test_a_network_camera_is_filmed_though_nobody_looks(tmp_path: Path) -> None:
    sent = [numbered(at) for at in range(40)]
    camera = RtspCamera(sent)
    bench = Bench(tmp_path / "films")
    async with watched(f"url: 'rtsp://127.0.0.1:{camera.port}/x'", tmp_path) as (hall, _, video):
        hall.forms = ()
        hall.filming, hall.film = bench.films.filming, bench.films.add_picture
        bench.films.begin_film("ada", "", 600.0, "gate/front")
        video.watch(bench.films.wanted_cameras())
        await until(lambda: (r := bench.films._reels["gate/front"]).file and r.file.pictures > 30)
        bench.films.end_film("ada", "gate/front")
        await asyncio.to_thread(bench.wait)
        assert bench.films.wanted_cameras() == frozenset()
    bench.films.close()
    camera.close()
    (kept,) = bench.shelf.list_waiting()
    film = shown(bench.shelf.whole_path(kept.id))
    assert kept.stream == "gate/front"
    assert kept.end_us - kept.begin_us == film[-1][0]
    for _, picture in film:
        assert psnr(picture[70:], sent[number_in(picture)][70:]) > 28


FILMED = SITE + "\nrecording: {before: 5, after: 1, upload: 5000, topics: [/number], cameras: %s}\n"


@pytest.mark.robot
async def test_a_robot_s_camera_is_filmed_around_stop_and_alone_when_a_person_asks(
    tmp_path: Path, peer: Peer
) -> None:
    async with (
        fake_hub(addresses_of) as hub,
        running(hub.url, tmp_path / "gateway", FILMED % "[base/front]") as gateway,
    ):
        await hub.until(lambda: hub.hellos, "a hello")
        assert (await hub.next(RecorderState)).can_film
        films = gateway.recording.films
        # Nobody looks, and the last seconds are held all the same.
        async with asyncio.timeout(PATIENCE_S):
            while not (films._reels and len(films._reels["base/front"].ring) > 5):
                await peer.do("image", encoding="rgb8")
                await asyncio.sleep(0.05)
        before = time.time_ns() // 1000
        await hub.send(StopRequest(device="base", id="s1", who="ada"))
        await hub.next(RecorderState, lambda state: state.films == ["base/front"])
        await peer.do("image", encoding="rgb8")

        def whole(kind: type) -> list:
            return [
                each
                for each in hub.offers
                if isinstance(each, kind) and len(hub.files[each.id]) == each.size
            ]

        await hub.until(lambda: whole(FilmOffer) and whole(FileOffer), "a film and a recording")
        film = whole(FilmOffer)[0]
        assert film.begin_us < before < film.end_us
        assert "STOP (software) (base)" in film.why
        assert hashlib.sha256(hub.files[film.id]).hexdigest() == film.digest
        path = tmp_path / "film.mp4"
        path.write_bytes(hub.files[film.id])
        assert len(shown(path)) == film.pictures > 5
        # Alone, by a person: nothing else is recorded.
        await hub.send(RecordingRequest(on=True, who="ben", stream="base/front"))
        await hub.next(RecorderState, lambda state: state.films and not state.on)
        async with asyncio.timeout(PATIENCE_S):
            while films._reels["base/front"].file is None:
                await peer.do("image", encoding="rgb8")
        await hub.send(RecordingRequest(on=False, who="ben", stream="base/front"))
        await hub.until(lambda: whole(FilmOffer)[-1].who == "ben", "ben's film")
        assert len(whole(FileOffer)) == 1


def test_a_description_names_cameras_that_are_there() -> None:
    said = [str(each) for each in check_site(load_site(FILMED % "[base/front, base/rear]"))]
    assert said == ["$.recording.cameras[1]: there is no camera 'base/rear'; one of: base/front"]
    assert load_site(FILMED % "[base/front]").filmed_cameras() == ("base/front",)
    # A camera whose topic is recorded is filmed beside it: a browser plays no MCAP.
    by_topic = (FILMED % "[]").replace("[/number]", "[/images]")
    assert load_site(by_topic).filmed_cameras() == ("base/front",)
    assert load_site(SITE).filmed_cameras() == ()


def test_the_scene_s_number_can_be_read() -> None:
    assert [number_in(numbered(each)) for each in (0, 1, 40_000, 65_535)] == [0, 1, 40_000, 65_535]
    assert scene().shape == (48, 64, 3)
    assert Trigger.STOP in Recording().triggers
