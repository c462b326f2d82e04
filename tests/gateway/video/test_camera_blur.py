"""Faces are gone from whatever leaves the gateway; where that cannot be, nothing leaves."""

from __future__ import annotations

import asyncio
import importlib.util
import io
import os
from pathlib import Path
from types import SimpleNamespace as Message
from typing import TYPE_CHECKING

import av
import numpy as np
import pytest
import simplejpeg
from detector_files import require_faces
from patience import PATIENCE_S
from PIL import Image

from talaia.clock import SystemClock
from talaia.gateway.ports import Filming
from talaia.gateway.video.blur_detectors import BlurDetectors
from talaia.gateway.video.camera import PictureStream
from talaia.gateway.video.camera_blur import CameraBlur
from talaia.gateway.video.frame_source import FrameSource
from talaia.gateway.video.pixels import rgb_of
from talaia.gateway.video.worker import PictureWorker
from talaia.model.connection import RosSource
from talaia.model.detection import Blur, Detect
from talaia.model.site import Stream
from talaia.objects.camera_objects import CameraObjects, cut_out
from talaia.objects.detection import Detection
from talaia.objects.errors import DetectorError
from talaia.objects.worker import Worker
from talaia.wire.frames import PictureForm, PictureFrame, unblurred_address

from .scenes import packed, psnr, scene

if TYPE_CHECKING:
    from collections.abc import Callable, Iterator

PHOTOGRAPH = Path(__file__).parents[3] / "src/talaia/sim/vehicle/pictures/astronaut.jpg"
CAMERA, UNBLURRED = "cam/front", unblurred_address("cam/front")
STEP_US = 100_000
EVERY_FORM = (PictureForm.H264, PictureForm.H264_SMALL, PictureForm.JPEG, PictureForm.STILL)


class Hall:
    """A `PictureSink` that keeps what it gets of each stream."""

    def __init__(
        self, find: Callable[[Blur, np.ndarray], list[Detection]], **forms: object
    ) -> None:
        """Find by ``find``; ``forms`` are those of the blurred stream, and of the other."""
        self.find_private = find
        self.forms = {CAMERA: forms.get("blurred", ()), UNBLURRED: forms.get("unblurred", ())}
        self.wish = Filming.NO
        self.got: list[PictureFrame] = []
        self.filmed: list[PictureFrame] = []
        self.troubles: list[tuple[str, str]] = []
        self.frames = FrameSource()
        self.offer_frame = self.frames.offer_frame

    def asked(self, stream: str) -> object:
        return self.forms[stream]

    def key_due(self, _stream: str, _form: str) -> bool:
        return False

    def room(self) -> float:
        return 1.0

    def offer(self, picture: PictureFrame) -> None:
        self.got.append(picture)

    def filming(self, _stream: str, _time_us: int) -> Filming:
        return self.wish

    def film(self, picture: PictureFrame) -> None:
        self.filmed.append(picture)

    def trouble(self, stream: str, why: str) -> None:
        self.troubles.append((stream, why))

    def of(self, stream: str) -> list[PictureFrame]:
        return [picture for picture in self.got if picture.stream == stream]


def camera(kind: str = "Image", **blur: object) -> PictureStream:
    source = RosSource(topic="/i", type=f"sensor_msgs/msg/{kind}")
    described = Stream(name="F", source=source, blur=Blur(**blur))  # type: ignore[arg-type]
    return PictureStream(CAMERA, described, lambda raw: raw, lambda *_: None)


def thing(left: float, top: float, right: float, bottom: float) -> Detection:
    return Detection("face", 0.9, left, top, right, bottom)


def pixels_of_frames(pictures: list[PictureFrame]) -> list[np.ndarray]:
    """Decode pictures of one form, whichever it is."""
    if pictures and pictures[0].format == "jpeg":
        return [simplejpeg.decode_jpeg(picture.data) for picture in pictures]
    decoder = av.CodecContext.create("h264", "r")
    frames = [frame for one in pictures for frame in decoder.decode(av.Packet(one.data))]
    return [one.to_ndarray(format="rgb24") for one in [*frames, *decoder.decode(None)]]


@pytest.fixture(scope="module")
def faces() -> Callable[[np.ndarray], list[dict[str, int]]]:
    """Judge by another detector than ours: local binary patterns, of scikit-image."""
    if importlib.util.find_spec("skimage") is None:
        if os.environ.get("TALAIA_REQUIRE_ALL") == "1":
            pytest.fail("needs scikit-image, and TALAIA_REQUIRE_ALL=1")
        pytest.skip("needs scikit-image: pip install --no-deps -r requirements/judges.txt")
    from skimage.data import lbp_frontal_face_cascade_filename
    from skimage.feature import Cascade

    judge = Cascade(lbp_frontal_face_cascade_filename())

    def find(rgb: np.ndarray) -> list[dict[str, int]]:
        # A small picture is judged as large as the others, by whole pixels.
        by = max(1, 448 // rgb.shape[1])
        large = np.ascontiguousarray(rgb.repeat(by, axis=0).repeat(by, axis=1))
        return judge.detect_multi_scale(
            large, scale_factor=1.2, step_ratio=1, min_size=(60, 60), max_size=(250, 250)
        )

    return find


@pytest.fixture
async def detectors() -> Iterator[BlurDetectors]:
    require_faces()
    # How long a look takes here is the machine's matter, and no part of what is held.
    found = BlurDetectors(lambda told: Worker({}, Path(), told), PATIENCE_S)
    found.start()
    yield found
    await found.close()


async def test_nobody_finds_a_face_in_what_leaves_of_a_photograph(detectors, faces) -> None:
    photograph = np.asarray(Image.open(PHOTOGRAPH).convert("RGB"))
    assert len(faces(photograph)) == 1
    assert len(faces(np.ascontiguousarray(photograph[::2, ::2]))) == 1
    hall = Hall(detectors.find_private, blurred=EVERY_FORM, unblurred=(PictureForm.JPEG,))
    hall.wish = Filming.ON
    release = hall.frames.hold(CAMERA)
    own = io.BytesIO()
    Image.open(PHOTOGRAPH).save(own, "JPEG", quality=90)
    # As the camera's own JPEG, which goes on untouched where nothing is blurred.
    taker, sent = camera("CompressedImage"), Message(data=own.getvalue(), format="jpeg")
    for at in range(2):
        await asyncio.to_thread(taker.process_picture, sent, at, (at + 1) * STEP_US, hall)
    assert hall.troubles == []
    left = {form: [p for p in hall.of(CAMERA) if form in p.forms] for form in EVERY_FORM}
    assert all(left.values())
    for pictures in (*left.values(), hall.filmed):
        shown = pixels_of_frames(pictures)
        assert shown
        assert [len(faces(one)) for one in shown] == [0] * len(shown)
    # The rest of the picture is what it was.
    (first, *_) = pixels_of_frames(left[PictureForm.JPEG])
    assert psnr(first[240:], photograph[240:]) > 32
    # Whoever has the right gets the camera's own bytes, on a stream of its own.
    assert [picture.data for picture in hall.of(UNBLURRED)] == [own.getvalue()] * 2
    # A detector sees what is there; a page is shown of it what leaves.
    look = await asyncio.to_thread(hall.frames.newest, CAMERA)
    assert look is not None
    assert psnr(look.rgb, photograph) > 30
    shown = await asyncio.to_thread(look.may_leave)
    eyes = CameraObjects(Detect(), {})
    head = Detection("person", 0.9, 0.3, 0.0, 0.6, 0.4)
    news = [one for at in range(15) for one in eyes.add_picture([head], shown, at * STEP_US)]
    news += eyes.end_sightings()
    (thumbnail,) = [simplejpeg.decode_jpeg(one.thumbnail) for one in news if one.thumbnail]
    assert len(faces(cut_out(photograph, head))) == 1
    assert len(faces(thumbnail)) == 0
    release()


def test_what_cannot_be_looked_at_stays_and_viewers_are_told_why() -> None:
    def fail(*_: object) -> list[Detection]:
        raise DetectorError("centerface.onnx: there is no such file")

    hall = Hall(fail, blurred=EVERY_FORM, unblurred=(PictureForm.JPEG,))
    hall.wish = Filming.ON
    release = hall.frames.hold(CAMERA)
    taker = camera()
    for at in range(3):
        taker.process_picture(packed(scene(64, 48, at), "rgb8"), at, (at + 1) * STEP_US, hall)
    assert (hall.of(CAMERA), hall.filmed) == ([], [])
    assert len(hall.of(UNBLURRED)) == 3
    (told,) = hall.troubles
    assert told == (
        CAMERA,
        "/i: no picture leaves, for it cannot be blurred: centerface.onnx: there is no such file",
    )
    look = hall.frames.newest(CAMERA)
    assert look is not None
    assert look.may_leave() is None
    news = CameraObjects(Detect(), {}).add_picture([thing(0, 0, 1, 1)], look.may_leave(), 1)
    assert all(one.thumbnail == b"" for one in news)
    release()


def test_without_detectors_no_picture_of_a_blurred_camera_leaves() -> None:
    blur = BlurDetectors(lambda told: Worker({}, Path(), told))
    with pytest.raises(DetectorError, match="do not run"):
        blur.find_private(Blur(), scene(64, 48))


async def test_a_picture_that_is_not_looked_at_in_time_stays() -> None:
    class Slow:
        async def detect_objects(self, *_: object) -> list[Detection]:
            await asyncio.Event().wait()
            raise AssertionError

    found = BlurDetectors(lambda _told: Slow(), 0.05)  # type: ignore[arg-type,return-value]
    found.start()
    with pytest.raises(DetectorError, match=r"not looked at within 0\.05 s"):
        await asyncio.to_thread(found.find_private, Blur(), scene(64, 48))


async def test_more_than_can_be_told_keeps_the_picture_here() -> None:
    class Crowd:
        async def detect_objects(self, model: str, *_: object) -> list[Detection]:
            return [] if model.startswith("faces:") else [thing(0, 0, 0.01, 0.01)] * 100

    found = BlurDetectors(lambda _told: Crowd())  # type: ignore[arg-type,return-value]
    found.start()
    with pytest.raises(DetectorError, match="100 or more"):
        await asyncio.to_thread(found.find_private, Blur(plates="ours"), scene(64, 48))


def test_what_was_found_stays_blurred_while_the_detector_misses_it_and_no_longer() -> None:
    told = {0: [thing(0.4, 0.4, 0.6, 0.6)]}
    blur, rgb = CameraBlur(Blur(hold=0.5)), scene(160, 120)
    at = [0]

    def find(*_: object) -> list[Detection]:
        return told.get(at[0], [])

    same = []
    for at_us in (0, 100_000, 400_000, 600_000):
        at[0] = at_us
        shown = rgb_of(blur.cover(rgb, at_us, find))
        same.append(np.array_equal(shown[50:70, 66:94], rgb[50:70, 66:94]))
        # Of the face no more than a few areas are left.
        if not same[-1]:
            assert len(np.unique(shown[50:70, 66:94].reshape(-1, 3), axis=0)) <= 16
    assert same == [False, False, False, True]


def test_between_looks_more_is_blurred_around_and_after_a_failed_look_nothing_leaves() -> None:
    looks: list[int] = []
    fails = [False]

    def find(*_: object) -> list[Detection]:
        if fails[0]:
            raise DetectorError("gone")
        looks.append(1)
        return [thing(0.4, 0.4, 0.6, 0.6)]

    blur, rgb = CameraBlur(Blur(looks=5, hold=1.0)), scene(160, 120)
    changed = []
    for at_us in (0, 50_000, 100_000, 150_000, 200_000):
        shown = rgb_of(blur.cover(rgb, at_us, find))
        changed.append(int((shown != rgb).any(axis=2).sum()))
    assert len(looks) == 2
    assert changed[0] < changed[1] < changed[2] < changed[3]
    fails[0] = True
    with pytest.raises(DetectorError, match="gone"):
        blur.cover(rgb, 400_000, find)
    # Not by what was found before it either.
    with pytest.raises(DetectorError, match="gone"):
        blur.cover(rgb, 410_000, find)


def test_several_who_want_a_picture_have_it_looked_at_once() -> None:
    looks: list[int] = []
    hall = Hall(lambda *_: looks.append(1) or [], blurred=EVERY_FORM)
    hall.wish = Filming.ON
    release = hall.frames.hold(CAMERA)
    camera().process_picture(packed(scene(64, 48, 1), "yuyv"), 1, 1, hall)
    look = hall.frames.newest(CAMERA)
    assert look is not None
    assert look.may_leave() is not None
    assert len(looks) == 1
    release()
    # And by nobody where only those look who may see it as it is.
    hall.forms, hall.wish = {CAMERA: (), UNBLURRED: (PictureForm.H264,)}, Filming.NO
    camera().process_picture(packed(scene(64, 48, 1), "yuyv"), 1, 1, hall)
    assert (len(hall.of(UNBLURRED)), len(looks)) == (1, 1)


def test_a_camera_that_waits_for_its_detector_holds_up_no_other(monkeypatch) -> None:
    import threading

    waits, came = threading.Event(), threading.Event()

    def find(*_: object) -> list[Detection]:
        assert waits.wait(30)
        return []

    class Lively(Hall):
        def offer(self, picture: PictureFrame) -> None:
            super().offer(picture)
            came.set()

    hall = Lively(find, blurred=(PictureForm.JPEG,))
    hall.forms["cam/plain"] = (PictureForm.JPEG,)
    source = RosSource(topic="/p", type="sensor_msgs/msg/Image")
    plain = PictureStream(
        "cam/plain", Stream(name="P", source=source), lambda raw: raw, lambda *_: None
    )
    worker = PictureWorker(hall, SystemClock())  # type: ignore[arg-type]
    worker.start()
    worker.offer_raw(camera(), packed(scene(64, 48), "rgb8"))
    worker.offer_raw(plain, packed(scene(64, 48), "rgb8"))
    assert came.wait(30)
    assert {picture.stream for picture in hall.got} == {"cam/plain"}
    came.clear()
    waits.set()
    assert came.wait(30)
    worker.close()
    assert {picture.stream for picture in hall.got} == {"cam/plain", CAMERA}
