"""A gateway whose camera is looked at by models that tell no boxes, with a real ROS 2 robot."""

from __future__ import annotations

from contextlib import asynccontextmanager
from typing import TYPE_CHECKING

import numpy as np
import pytest
from detector_files import require_runtime
from fake_hub import FakeHub, fake_hub
from gateway_bench import Peer, addresses_of, filled, running
from picture_model_files import bright_depth, colour_classifier, colour_segmenter, red_pose

from talaia.wire.frames import DescriptionUpdate, Event, InterlockState, StreamSubscription

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
  ground: {file: FOLDER/ground.onnx, kind: segmentation, classes: [red, green, blue], side: 64}
  room: {file: FOLDER/room.onnx, kind: classification, classes: [red, green, blue], side: 32}
  pose: {file: FOLDER/pose.onnx, kind: keypoints, classes: [person], points: [hand], side: 32}
  far: {file: FOLDER/far.onnx, kind: depth, scale: metres, side: 70}
devices:
  base:
    name: Base
    signals:
      <number, speed>
      red: {name: Red, unit: "%", max_age: 2, source: {stream: front, model: ground, sees: red, measure: share, zone: path}}
      ahead: {name: Red ahead, unit: "%", source: {stream: front, model: ground, sees: red, measure: ahead}}
      green_edge: {name: Edge, unit: "%", source: {stream: front, model: ground, sees: green, measure: left_edge}}
      likely: {name: How red, unit: "%", source: {stream: front, model: room, sees: red, measure: probability}}
      room: {name: Room, type: text, source: {stream: front, model: room, measure: surest}}
      room_state: {name: Room, type: state, states: [red, green, blue], source: {stream: front, model: room, measure: surest}}
      people: {name: People, source: {stream: front, model: pose, sees: person}}
      hands: {name: Hands up, source: {stream: front, model: pose, sees: hand, within: [0, 0, 1, 0.5]}}
      near: {name: Nearest, unit: m, source: {stream: front, model: far, measure: nearest}}
    streams:
      front:
        name: Front
        source: {topic: /images, type: sensor_msgs/msg/Image}
        models:
          ground: {max_rate: 20, zones: {path: {name: Path, points: [[0.2, 0.5], [0.8, 0.5], [0.8, 1], [0.2, 1]]}}}
          room: {max_rate: 20}
          pose: {max_rate: 20, hold: 0.2}
          far: {max_rate: 20}
interlocks:
  path:
    name: No red ground
    when: [{signal: base/red, below: 50}]
    refuse: [base/*]
    dwell: 0.2
""")  # noqa: E501 - a row for each signal
NEAR = next(line + "\n" for line in SITE.splitlines() if line.startswith("      near:"))


@pytest.fixture
def site(tmp_path: Path) -> str:
    require_runtime()
    colour_segmenter(tmp_path / "ground.onnx", 64)
    colour_classifier(tmp_path / "room.onnx", 32)
    red_pose(tmp_path / "pose.onnx", 32, [(0.5, 0.3)])
    bright_depth(tmp_path / "far.onnx", 70)
    for name, colour in (("red", (255, 0, 0)), ("blue", (30, 30, 240))):
        picture = np.full((HEIGHT, WIDTH, 3), colour, np.uint8)
        (tmp_path / name).write_bytes(picture.tobytes())
    return SITE.replace("FOLDER", str(tmp_path))


@asynccontextmanager
async def looked_at(tmp_path: Path, text: str, file: Path | None = None) -> AsyncIterator[FakeHub]:
    async with fake_hub(addresses_of) as hub, running(hub.url, tmp_path / "data", text, file=file):
        await hub.until(lambda: hub.hellos, "a hello")
        yield hub


async def test_what_each_kind_tells_becomes_signals_and_an_overlay_for_who_looks(
    peer: Peer, tmp_path: Path, site: str
) -> None:
    async with looked_at(tmp_path, site) as hub, showing(peer, tmp_path, "blue") as show:
        await hub.until(
            lambda: all(hub.values(f"base/{name}") for name in ("red", "room", "people", "near")),
            "a value of each model",
        )
        assert hub.values("base/red")[-1] == 0
        assert hub.values("base/room")[-1] == "blue"
        assert hub.values("base/room_state")[-1] == 2
        # Thirty, thirty and 240 of 255, ten times the mean.
        assert hub.values("base/near")[-1] == pytest.approx(10 * 100 / 255, abs=0.1)
        assert hub.overlays == []
        await hub.send(StreamSubscription(streams=["base/front"], overlays=["base/front"]))
        show("red")
        await hub.until(lambda: hub.values("base/red")[-1] == 100, "red ground")
        await hub.until(lambda: hub.values("base/people")[-1] == 1, "a person")
        await hub.until(lambda: hub.values("base/room")[-1] == "red", "another room")
        assert hub.values("base/ahead")[-1] == 100
        assert hub.values("base/hands")[-1] == 1
        await hub.until(lambda: hub.values("base/likely")[-1] > 99, "surely red")
        # Where there is no green it has no edge, and nothing is said.
        assert hub.values("base/green_edge") == []
        await hub.until(
            lambda: {one.model for one in hub.overlays} == {"ground", "room", "pose", "far"},
            "an overlay of each",
        )
        newest = {one.model: one for one in hub.overlays}
        ground = newest["ground"].layer
        assert (ground.rows, ground.columns) == (120, 160)
        assert newest["room"].layer.likely[0].label == "red"
        (pose,) = newest["pose"].layer.poses
        assert len(pose.points) == 1
        # It is known of which picture they are.
        seqs = {one.seq for one in hub.overlays}
        await hub.until(lambda: seqs & {one.seq for one in hub.pictures}, "its picture")
        # What stays the same is said once a second, not with every picture.
        before, told = len(hub.overlays), len(hub.values("base/ahead"))
        await hub.until(lambda: len(hub.overlays) > before + 100, "more overlays")
        assert len(hub.values("base/ahead")) - told < 12


async def test_model_that_is_dead_is_told_once_and_its_signals_are_unknown_and_unsafe(
    peer: Peer, tmp_path: Path, site: str
) -> None:
    async with looked_at(tmp_path, site) as hub, showing(peer, tmp_path, "red"):
        await hub.next(InterlockState, lambda state: not state.locked)
        for process in children():
            process.suspend()
        state = await hub.next(InterlockState, lambda state: state.locked)
        assert state.why == "Red: no value newer than 2 s"
        for process in children():
            process.kill()
        lost = await hub.next(Event, lambda event: event.kind == "detection lost")
        assert "tells nothing of Front" in lost.message
        # It begins anew by itself.
        await hub.next(InterlockState, lambda state: not state.locked)


async def test_file_of_another_kind_is_told_with_what_it_gives(
    peer: Peer, tmp_path: Path, site: str
) -> None:
    colour_segmenter(tmp_path / "far.onnx", 70)
    async with looked_at(tmp_path, site) as hub, showing(peer, tmp_path, "red"):
        lost = await hub.next(Event, lambda event: event.kind == "detection lost")
        assert lost.message.startswith(
            "far tells nothing of Front: a model of the kind depth gives"
        )
        assert "this file gives 1 × 3 × 70 × 70" in lost.message
        # The others go on.
        await hub.until(lambda: hub.values("base/red"), "red ground")
        assert hub.values("base/near") == []


async def test_change_of_the_description_leaves_what_is_the_same_known_and_running(
    peer: Peer, tmp_path: Path, site: str
) -> None:
    file = tmp_path / "site.yaml"
    async with looked_at(tmp_path, site, file) as hub, showing(peer, tmp_path, "red"):
        await hub.next(InterlockState, lambda state: not state.locked)
        await hub.until(lambda: len(children()) == 4, "a process for each model")
        before = {process.pid for process in children()}
        file.write_text(site.replace("name: People,", "name: Persons,"))
        await hub.next(DescriptionUpdate)
        await hub.until(lambda: hub.values("base/people"), "people")
        assert {process.pid for process in children()} == before
        assert not any(state.locked for state in hub.of(InterlockState))
        # Another zone: its share is of other cells from here on.
        path = "[[0.2, 0.5], [0.8, 0.5], [0.8, 1], [0.2, 1]]"
        other = site.replace(path, "[[0, 0], [1, 0], [1, 1]]")
        file.write_text(other.replace("          far: {max_rate: 20}\n", "").replace(NEAR, ""))
        told = await hub.next(DescriptionUpdate)
        assert "base/near" not in told.addresses
        # Nobody needs that model any more; the others go on.
        await hub.until(lambda: len(children()) == 3, "the end of one")
        assert {process.pid for process in children()} < before
