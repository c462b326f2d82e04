"""A gateway whose camera detects, with a real ROS 2 robot: counts, boxes, sightings, interlocks."""

from __future__ import annotations

import asyncio
from contextlib import asynccontextmanager
from typing import TYPE_CHECKING

import numpy as np
import pytest
from detector_files import red_detector, require_runtime
from fake_hub import FakeHub, fake_hub
from gateway_bench import Peer, addresses_of, drive, filled, running, take_lease

from talaia.model.yaml_text.load import load_site
from talaia.wire.frames import (
    DescriptionUpdate,
    DriveState,
    Event,
    InterlockState,
    SightingReport,
    StreamSubscription,
)

from .shown_pictures import HEIGHT, WIDTH, children, showing

if TYPE_CHECKING:
    from collections.abc import AsyncIterator
    from pathlib import Path

pytestmark = pytest.mark.robot
SITE = filled("""
talaia: 1
site: test
name: Test robot
ros2: {node: gateway_under_test}
object_models:
  red:
    file: FOLDER/red.onnx
    kind: yolo
    classes: [person]
    side: 32
devices:
  base:
    name: Base
    signals:
      <number, speed>
      in_path:
        name: Persons in the drive path
        max_age: 2
        source: {stream: front, sees: person, within: [0.3, 0.6, 0.7, 1]}
      aside:
        name: Persons beside it
        source: {stream: front, sees: person, within: [0, 0, 0.3, 1]}
      mat_dwell:
        name: Longest on the mat (s)
        source: {stream: front, sees: person, zone: mat, measure: dwell}
    streams:
      front:
        name: Front
        source: {topic: /images, type: sensor_msgs/msg/Image}
        detect: {classes: [person], model: red, max_rate: 20, hold: 0.2, zones: {mat: MAT}}
    drive:
      topic: /cmd_vel
      max_speed: 0.2
      max_turn: 2
interlocks:
  path:
    name: Person in the drive path
    when: [{signal: base/in_path, above: 0}]
    refuse: [base/drive]
    dwell: 0.5
""")
SITE = SITE.replace("MAT", "{name: Mat, points: [[0.3, 0.6], [0.7, 0.6], [0.7, 1], [0.3, 1]]}")


@pytest.fixture
def site(tmp_path: Path) -> str:
    require_runtime()
    red_detector(tmp_path / "red.onnx")
    for name, colour in (("person", (255, 0, 0)), ("nobody", (30, 30, 30))):
        picture = np.full((HEIGHT, WIDTH, 3), colour, np.uint8)
        (tmp_path / name).write_bytes(picture.tobytes())
    return SITE.replace("FOLDER", str(tmp_path))


@asynccontextmanager
async def seeing(
    tmp_path: Path, text: str, file: Path | None = None, *, takes: bool = True
) -> AsyncIterator[FakeHub]:
    async with fake_hub(addresses_of) as hub:
        hub.takes = ["seen"] if takes else []
        async with running(hub.url, tmp_path / "data", text, file=file):
            await hub.until(lambda: hub.hellos, "a hello")
            yield hub


def boxed_pictures(hub) -> list[tuple]:
    """Pair boxes of something with the picture that they are of, where it has come."""
    pictures = {each.seq: each for each in hub.pictures}
    return [
        (each, pictures[each.seq]) for each in hub.boxes if each.things and each.seq in pictures
    ]


async def test_what_is_seen_becomes_samples_boxes_and_sightings(
    peer: Peer, tmp_path: Path, site: str
) -> None:
    async with seeing(tmp_path, site) as hub, showing(peer, tmp_path, "nobody") as show:
        signals = load_site(hub.hellos[0].description).devices["base"].signals
        assert signals["front_person"].source.sees == "person"
        await hub.until(lambda: hub.values("base/front_person"), "a count")
        await hub.send(StreamSubscription(streams=["base/front"], boxes=["base/front"]))
        await hub.until(lambda: hub.boxes and not hub.boxes[-1].things, "boxes of nobody")
        show("person")
        began = await hub.next(SightingReport)
        assert (began.stream, began.label, began.many) == ("base/front", "person", 1)
        assert began.confidence > 0.8
        assert began.ended_us == 0
        assert began.thumbnail[:2] == b"\xff\xd8"
        assert len(began.thumbnail) < 64 * 1024
        # It is known of which picture they are; a busy line leaves single pictures out.
        await hub.until(lambda: boxed_pictures(hub), "a box and its picture")
        boxes, picture = boxed_pictures(hub)[0]
        (thing,) = boxes.things
        assert (thing.label, round(thing.left, 1), round(thing.right, 1)) == ("person", 0.2, 0.8)
        assert picture.time_us == boxes.time_us
        show("nobody")
        over = await hub.next(SightingReport, lambda each: each.ended_us > 0)
        assert over.began_us == began.began_us < over.ended_us
        assert over.thumbnail == b""
        # It stood on the mat for as long as it was there.
        assert [(stay.zone, stay.entries) for stay in over.stays] == [("Mat", 1)]
        assert 0 < over.stays[0].dwell_s == pytest.approx(max(hub.values("base/mat_dwell")), abs=1)
        assert over.path[0][0] >= over.began_us
        await hub.until(lambda: hub.values("base/front_person")[-1] == 0, "nobody")
        assert set(hub.values("base/front_person")) == {0.0, 1.0}
        assert set(hub.values("base/in_path")) == {0.0, 1.0}
        assert set(hub.values("base/aside")) == {0.0}
        # What stays the same is said once a second, not with every picture.
        assert len(hub.values("base/front_person")) < len(hub.boxes) / 2


async def test_cameras_of_one_detector_take_turns(peer: Peer, tmp_path: Path, site: str) -> None:
    front = site[site.index("      front:") : site.index("    drive:")]
    both = site.replace(front, front + front.replace("      front:", "      rear:"))
    async with seeing(tmp_path, both) as hub, showing(peer, tmp_path, "person"):
        await hub.send(StreamSubscription(streams=[], boxes=["base/front", "base/rear"]))
        await hub.until(lambda: len(hub.boxes) > 40, "boxes")
        shown = [each.stream for each in hub.boxes]
        assert min(shown.count("base/front"), shown.count("base/rear")) >= 12
        assert len(children()) == 1
        assert hub.values("base/rear_person")[-1] == 1.0


async def test_boxes_that_nobody_wants_stay_at_the_gateway(
    peer: Peer, tmp_path: Path, site: str
) -> None:
    async with seeing(tmp_path, site) as hub, showing(peer, tmp_path, "person"):
        await hub.send(StreamSubscription(streams=["base/front"]))
        await hub.until(lambda: len(hub.pictures) > 10, "pictures")
        await hub.until(lambda: hub.values("base/front_person"), "a count")
        assert hub.boxes == []


async def test_person_in_the_drive_path_stops_a_driven_vehicle(
    peer: Peer, tmp_path: Path, site: str
) -> None:
    async with seeing(tmp_path, site) as hub, showing(peer, tmp_path, "nobody") as show:
        await hub.next(InterlockState, lambda each: not each.locked)
        epoch = await take_lease(hub)
        asked = [0.2]

        async def driven() -> None:
            while True:
                await drive(hub, epoch, asked[0])
                await asyncio.sleep(0.05)

        driving = asyncio.ensure_future(driven())
        try:
            await peer.until(lambda: peer.heard("cmd") and peer.heard("cmd")[-1][0] > 0.1)
            show("person")
            state = await hub.next(InterlockState, lambda each: each.locked)
            assert state.why == "Persons in the drive path is above 0"
            await peer.until(lambda: peer.heard("cmd")[-1] == [0.0, 0.0])
            refused = await hub.next(DriveState, lambda each: "drive path" in each.why)
            assert refused.refused > 0
            show("nobody")
            await hub.next(InterlockState, lambda each: not each.locked)
            # Whoever drives has to let go first.
            asked[0] = 0.0
            await drive(hub, epoch, 0.0)
            asked[0] = 0.2
            await peer.until(lambda: peer.heard("cmd")[-1][0] > 0.1)
        finally:
            driving.cancel()


async def test_person_in_the_drive_path_caps_the_speed_of_a_driven_vehicle(
    peer: Peer, tmp_path: Path, site: str
) -> None:
    site = site.replace("refuse: [base/drive]", "slow: {base/drive: 0.25}")
    async with seeing(tmp_path, site) as hub, showing(peer, tmp_path, "nobody") as show:
        await hub.next(InterlockState, lambda each: not each.locked)
        epoch = await take_lease(hub)

        async def driven() -> None:
            while True:
                await drive(hub, epoch, 0.2)
                await asyncio.sleep(0.05)

        driving = asyncio.ensure_future(driven())
        try:
            await peer.until(lambda: peer.heard("cmd") and peer.heard("cmd")[-1][0] == 0.2)
            show("person")
            await hub.next(DriveState, lambda each: each.cap == 0.25)
            await peer.until(lambda: peer.heard("cmd")[-1][0] == 0.05)
            show("nobody")
            # The same press goes on: nobody was stopped.
            await peer.until(lambda: peer.heard("cmd")[-1][0] == 0.2)
        finally:
            driving.cancel()


async def test_detector_or_camera_that_is_dead_locks_as_a_person_would(
    peer: Peer, tmp_path: Path, site: str
) -> None:
    async with seeing(tmp_path, site) as hub:
        async with showing(peer, tmp_path, "nobody"):
            await hub.next(InterlockState, lambda each: not each.locked)
            (process,) = children()
            process.suspend()
            state = await hub.next(InterlockState, lambda each: each.locked)
            assert state.why == "Persons in the drive path: no value newer than 2 s"
            process.kill()
            lost = await hub.next(Event, lambda each: each.kind == "detection lost")
            assert lost.device == "base"
            assert "Front" in lost.message
            assert "signal 9" in lost.message
            await hub.next(InterlockState, lambda each: not each.locked)
        await hub.next(InterlockState, lambda each: each.locked)


async def test_runtime_that_is_missing_is_said_on_the_camera_and_the_rest_runs(
    peer: Peer, tmp_path: Path, site: str
) -> None:
    (tmp_path / "red.onnx").unlink()
    async with seeing(tmp_path, site) as hub, showing(peer, tmp_path, "person"):
        lost = await hub.next(Event, lambda each: each.kind == "detection lost")
        assert "red.onnx: there is no such file" in lost.message
        await peer.do("odom", speed=1)
        await hub.until(lambda: hub.values("base/speed"), "the speed")
        await hub.send(StreamSubscription(streams=["base/front"]))
        await hub.until(lambda: len(hub.pictures) > 3, "pictures")
        assert hub.values("base/front_person") == []


async def test_change_of_what_is_seen_takes_effect_at_once_and_no_sample_is_lost(
    peer: Peer, tmp_path: Path, site: str
) -> None:
    file = tmp_path / "site.yaml"
    async with seeing(tmp_path, site, file) as hub, showing(peer, tmp_path, "person"):
        await hub.until(lambda: 1.0 in hub.values("base/front_person"), "a person")
        (process,) = children()
        file.write_text(site.replace("max_rate: 20", "max_rate: 20, confidence: 1.0"))
        await hub.next(DescriptionUpdate)
        over = await hub.next(SightingReport, lambda each: each.ended_us > 0)
        assert over.label == "person"
        await hub.until(lambda: hub.values("base/front_person")[-1] == 0.0, "none is so sure")
        # The same detector, and the same link.
        assert children() == [process]
        for boot in hub.samples:
            assert hub.below(boot) == len(hub.samples[boot])
        blind = "\n".join(
            line for line in site.split("interlocks:")[0].splitlines() if "detect: " not in line
        )
        for name in ("in_path", "aside", "mat_dwell"):
            at = blind.index(f"      {name}:")
            blind = blind[:at] + blind[blind.index("}\n", at) + 2 :]
        file.write_text(blind)
        told = await hub.next(DescriptionUpdate)
        assert told.addresses == ["base/number", "base/speed"]
        await hub.until(lambda: not children(), "its end")
        assert len(hub.hellos) == 1


async def test_sighting_without_a_link_is_told_when_there_is_one_and_by_a_later_run_too(
    peer: Peer, tmp_path: Path, site: str
) -> None:
    async with seeing(tmp_path, site, takes=False) as old, showing(peer, tmp_path, "person"):
        await old.until(lambda: 1.0 in old.values("base/front_person"), "a person")
        await old.until(lambda: list((tmp_path / "data/sightings").glob("*.seen")), "a file")
        assert old.of(SightingReport) == []
    # That gateway has ended, and its hub takes no sightings.
    async with seeing(tmp_path, site) as hub:
        told = await hub.next(SightingReport)
        assert (told.label, told.many) == ("person", 1)
        assert told.ended_us > told.began_us
        assert told.thumbnail
        hub.cut()
        again = await hub.next(SightingReport)
        assert again == told
        await hub.until(
            lambda: not list((tmp_path / "data/sightings").glob("*.seen")), "it has been carried"
        )
