"""A scene of the past in a real Chromium: a camera's film stands in its frustum."""

from __future__ import annotations

import hashlib
from fractions import Fraction

import av
import numpy as np
import pytest
from patience import until_answered
from playwright.async_api import expect
from rosbags.rosbag2 import StoragePlugin, Writer

from talaia.gateway.recording.film_file import FilmFile
from talaia.sim.vehicle.world import World
from talaia.wire.frames import FilmOffer, PictureFrame

from ..chromium import sign_in
from ..conftest import DESCRIPTION
from .test_recorded_topics import BEGIN_US, SECOND_US
from .test_recordings import files, piece
from .test_scene_in_browser import (
    BASE,
    CAMERA,
    DRAWN,
    HEIGHT,
    KINDS,
    QUARTERS,
    STORE,
    WIDTH,
    YAW,
    house_messages,
    until_quarters_are,
)

pytestmark = [pytest.mark.browser, pytest.mark.timeout(300)]
SITE = (
    DESCRIPTION.replace("topic: /images", "topic: /front/images")
    + '\nrecording: {}\ntopics:\n  - {pattern: "/**", right: view}\n'
)
INFO = next(iter(CAMERA))
LENGTH_S, FILM_S = 40, (10, 30)
# Of the film's second half.
OTHERS = QUARTERS[::-1]
NAME = "20260101T120010Z-f00001"


def drive(tmp_path) -> bytes:
    """Record where a robot's camera stands, and none of its pictures."""
    world = World(1)
    world.place_vehicle(*BASE, YAW)
    house = house_messages(world, world.scan_lidar())
    kinds = {topic: KINDS[topic] for topic in ("/tf", "/tf_static")} | {INFO: CAMERA[INFO]}
    with Writer(tmp_path / "drive", version=9, storage_plugin=StoragePlugin.MCAP) as bag:
        of = {name: bag.add_connection(name, kind, typestore=STORE) for name, kind in kinds.items()}
        for second in range(LENGTH_S):
            for topic, kind in kinds.items():
                data = bytes(STORE.serialize_cdr(house[topic], kind))
                bag.write(of[topic], (BEGIN_US + second * SECOND_US) * 1000, data)
    return next((tmp_path / "drive").glob("*.mcap")).read_bytes()


def film(tmp_path) -> tuple[bytes, FilmOffer]:
    """Write a film as a gateway does: a colour in each quarter, others in its second half."""
    encoder = av.CodecContext.create("libx264", "w")
    encoder.width, encoder.height = WIDTH, HEIGHT
    encoder.pix_fmt, encoder.time_base = "yuv420p", Fraction(1, 1_000_000)
    encoder.options = {"tune": "zerolatency", "profile": "baseline", "x264-params": "keyint=10"}
    begin_us = BEGIN_US + FILM_S[0] * SECOND_US
    file = None
    part, whole = tmp_path / "film.part", tmp_path / "film.mp4"
    for number in range(5 * (FILM_S[1] - FILM_S[0])):
        pixels = np.zeros((HEIGHT, WIDTH, 3), np.uint8)
        half = number // (5 * (FILM_S[1] - FILM_S[0]) // 2)
        for at, colour in enumerate((QUARTERS, OTHERS)[half]):
            down, right = HEIGHT // 2 * (at // 2), WIDTH // 2 * (at % 2)
            pixels[down : down + HEIGHT // 2, right : right + WIDTH // 2] = colour
        frame = av.VideoFrame.from_ndarray(pixels, format="rgb24")
        frame.pts = number * 200_000
        (packet,) = encoder.encode(frame)
        picture = PictureFrame(
            stream="camera/front", seq=number, time_us=begin_us + frame.pts, mono_us=number,
            width=WIDTH, height=HEIGHT, format="h264", key=packet.is_keyframe, data=bytes(packet),
        )  # fmt: skip
        file = file or FilmFile(part, picture)
        if number:
            file.add_picture(picture)
    file.finish_file(part, whole)
    body = whole.read_bytes()
    return body, FilmOffer(
        id=NAME, stream="camera/front", size=len(body), digest=hashlib.sha256(body).hexdigest(),
        why="somebody", begin_us=begin_us, end_us=file.end_us, pictures=file.pictures,
    )  # fmt: skip


async def test_the_film_of_the_moment_stands_in_its_cameras_frustum(space, hub, tmp_path) -> None:
    gateway = await hub.gateway()
    await gateway.hello(SITE)
    link = await files(hub)
    end_us = BEGIN_US + LENGTH_S * SECOND_US
    assert (await link.bring(drive(tmp_path), begin_us=BEGIN_US, end_us=end_us)).done
    body, offer = film(tmp_path)
    assert (await link.ask(offer)).have == 0
    assert (await link.ask(piece(0, body, NAME))).done
    # What the hub knows of it does not need the robot.
    await gateway.close()
    operator = await hub.client("operator")
    kinds = {"scene": {"lists": True}, "camera": {"stream": "camera/front"}}
    tiles = [
        {
            "id": kind,
            "type": kind,
            "title": "",
            "settings": settings,
            "desktop": None,
            "phone": None,
        }
        for kind, settings in kinds.items()
    ]
    board = {"name": "Past", "note": "", "site": "agv", "kind": "", "device": "", "tiles": tiles}
    key = (await operator.post("/api/boards", json={"board": board})).json()["key"]
    page = await sign_in(space, hub, "operator", to=f"/boards/{key}?at=2026-01-01T12:00:15Z")
    await page.locator(f"[data-topic='{INFO}']").check()
    await until_answered(lambda: page.evaluate(f"{DRAWN}('{INFO}').points.length === 4"))
    await until_quarters_are(page, INFO, QUARTERS)
    beside = page.locator("t-film-view")
    await expect(beside).to_contain_text("13:00:15")

    # Ten seconds later by the same bar as all of the board, in the film's second half.
    slider = page.locator("t-time-bar").get_by_role("slider", name="Moment")
    for _ in range(10):
        await slider.press("ArrowRight")
    await until_quarters_are(page, INFO, OTHERS)
    await expect(beside).to_contain_text("13:00:25")

    # Beyond the film it is taken away, and the list says why.
    for _ in range(10):
        await slider.press("ArrowRight")
    row = page.locator("label", has=page.locator(f"[data-topic='{INFO}']"))
    await expect(row).to_contain_text("No film of this moment")
    await expect(beside).to_contain_text("No film of this moment")
    for _ in range(10):
        await slider.press("ArrowLeft")
    await expect(row).not_to_contain_text("No film of this moment")
    await until_quarters_are(page, INFO, OTHERS)
    assert page.errors == []
