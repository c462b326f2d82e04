"""What models tell of pictures reaches the pages that asked, newest first, and no other."""

from __future__ import annotations

import asyncio

import pytest
from msgspec import structs
from patience import PATIENCE_S

from talaia.wire import browser as page_wire, frames

from ..modelled import modelled

FRONT = "camera/front"
LAYER = frames.OverlayLayer(
    rows=2, columns=3, runs=bytes([4, 1, 2, 2]), near=None, far=None, poses=[], likely=[]
)


@pytest.fixture
async def gateway(hub):
    """The connected gateway of a vehicle whose camera is looked at by models."""
    gateway = await hub.gateway()
    await gateway.hello(modelled())
    return gateway


def overlay(seq: int, model: str = "ground", stream: str = FRONT) -> frames.ModelOverlay:
    layer = structs.replace(LAYER, near=float(seq))
    return frames.ModelOverlay(stream=stream, seq=seq, time_us=seq * 10, model=model, layer=layer)


async def test_page_is_told_which_models_look_and_what_their_zones_count(hub, gateway):
    answer = await (await hub.client("operator")).get("/api/sites/agv")
    devices = {device["id"]: device for device in answer.json()["devices"]}
    (stream,) = devices["camera"]["streams"]
    models = {model["id"]: model for model in stream["models"]}
    assert {name: model["kind"] for name, model in models.items()} == {
        "ground": "segmentation", "room": "classification", "pose": "keypoints", "far": "depth",
    }  # fmt: skip
    assert models["ground"]["classes"] == ["other", "floor", "wall"]
    (path,) = models["ground"]["zones"]
    assert [(count["signal"], count["measure"]) for count in path["counts"]] == [
        ("camera/free", "share")
    ]
    assert models["pose"]["points"][9] == "left wrist"
    assert {"start": 7, "end": 9} in models["pose"]["bones"]
    assert models["ground"]["bones"] == []


async def test_overlays_are_asked_for_while_a_page_wants_them_and_reach_no_other(hub, gateway):
    asks, other = [await hub.viewer("operator", FRONT) for _ in range(2)]
    await gateway.hear(frames.StreamSubscription, lambda watch: watch.streams == [FRONT])
    camera = await hub.camera()
    # On its way when nobody wanted it.
    await camera.say(overlay(1))
    await other.say(page_wire.BoxesRequest(on=True))
    await asks.say(page_wire.BoxesRequest(on=False, overlays=True))
    watch = await gateway.hear(frames.StreamSubscription, lambda watch: watch.overlays)
    assert (watch.overlays, watch.streams) == ([FRONT], [FRONT])
    await camera.say(overlay(2, stream="camera/rear"))
    await camera.say(overlay(3))
    told = await asks.hear(page_wire.CameraPictureOverlay)
    assert (told.seq, told.time_us, told.model) == (3, 30, "ground")
    assert told.layer == structs.replace(LAYER, near=3.0)
    gateway.heard.clear()
    await asks.say(page_wire.BoxesRequest(on=False))
    await gateway.hear(frames.StreamSubscription, lambda watch: not watch.overlays)
    assert not any(isinstance(one, page_wire.CameraPictureOverlay) for one in other.heard)


async def test_a_page_that_is_slow_gets_the_newest_of_each_model_behind_its_picture(hub, gateway):
    asks = await hub.viewer("operator", FRONT)
    await asks.say(page_wire.BoxesRequest(on=False, overlays=True))
    await gateway.hear(frames.StreamSubscription, lambda watch: watch.overlays)
    camera = await hub.camera()
    # Two pictures are under way, so that the next one waits, and with it what is told of it.
    for seq in range(1, 4):
        picture = frames.PictureFrame(
            stream=FRONT, seq=seq, time_us=1, mono_us=seq, width=2, height=2, data=b"x"
        )
        await camera.say(picture)
        if seq <= 2:
            await asks.hear(page_wire.CameraPicture, lambda shot, seq=seq: shot.seq == seq)
    for seq in range(3, 9):
        await camera.say(overlay(seq, "ground"))
        await camera.say(overlay(seq, "far"))
    await camera.say(frames.Beat(n=1, mono_us=1))
    await camera.hear(frames.BeatReply)
    await asks.say(page_wire.PictureShown(seq=2))
    async with asyncio.timeout(PATIENCE_S), asks._news:
        await asks._news.wait_for(lambda: len(asks.heard) >= 3)
    assert [(type(one).__name__, one.seq) for one in asks.heard] == [
        ("CameraPicture", 3), ("CameraPictureOverlay", 8), ("CameraPictureOverlay", 8),
    ]  # fmt: skip
    assert {one.model for one in asks.heard[1:]} == {"ground", "far"}


async def test_a_gateway_that_invents_models_fills_no_memory(hub, gateway):
    asks = await hub.viewer("operator", FRONT)
    await asks.say(page_wire.BoxesRequest(on=False, overlays=True))
    await gateway.hear(frames.StreamSubscription, lambda watch: watch.overlays)
    camera = await hub.camera()
    for seq in range(1, 4):
        await camera.say(
            frames.PictureFrame(
                stream=FRONT, seq=seq, time_us=1, mono_us=seq, width=2, height=2, data=b"x"
            )
        )
        if seq <= 2:
            await asks.hear(page_wire.CameraPicture, lambda shot, seq=seq: shot.seq == seq)
    for number in range(100):
        await camera.say(overlay(number, f"model{number}"))
    await camera.say(frames.Beat(n=1, mono_us=1))
    await camera.hear(frames.BeatReply)
    asks.heard.clear()
    await asks.say(page_wire.PictureShown(seq=2))
    last = await asks.hear(page_wire.CameraPictureOverlay, lambda one: one.seq == 99)
    assert last.model == "model99"
    told = [one for one in asks.heard if isinstance(one, page_wire.CameraPictureOverlay)]
    assert len(told) < 8
