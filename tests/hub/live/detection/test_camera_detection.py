"""The hub looks at a camera itself, with a real detector in a process of its own."""

from __future__ import annotations

import asyncio
import sys
import time
from pathlib import Path

import numpy as np
import pytest
import simplejpeg
from msgspec import structs
from patience import PATIENCE_S

from talaia.model.derived_signals import with_counts
from talaia.model.detection import Detect, DetectAt, ModelKind, ObjectModel
from talaia.model.yaml_text.load import dump_site, load_site
from talaia.wire import frames
from talaia.wire.browser import (
    BoxesRequest,
    CameraPictureBoxes,
    EventUpdate,
    SightingUpdate,
    Subscribe,
    Values,
)
from talaia.wire.columns import unpack_columns

from ...conftest import DESCRIPTION

sys.path.insert(0, str(Path(__file__).resolve().parents[3] / "gateway"))
from detector_files import red_detector, require_runtime

FRONT = "camera/front"
DETECT = Detect(at=DetectAt.HUB, model="red", classes=("red thing",), max_rate=60)
MODEL = ObjectModel(
    file="/etc/secrets/red.onnx", kind=ModelKind.YOLO, classes=("red thing",), side=32
)


def looked_at() -> str:
    """Describe the vehicle as its gateway tells it: with the signals that its camera implies."""
    site = load_site(DESCRIPTION)
    camera = site.devices["camera"]
    front = structs.replace(camera.streams["front"], detect=DETECT)
    camera = structs.replace(camera, streams={"front": front}, signals={})
    devices = {**site.devices, "camera": camera}
    models = {"red": MODEL}
    # What it counts for an interlock of its own, it would count beside itself.
    site = structs.replace(site, devices=devices, object_models=models, interlocks={})
    return dump_site(with_counts(site))


LOOKED_AT = looked_at()
RED = simplejpeg.encode_jpeg(np.full((48, 64, 3), (255, 0, 0), np.uint8), colorspace="RGB")
GREY = simplejpeg.encode_jpeg(np.full((48, 64, 3), 30, np.uint8), colorspace="RGB")


@pytest.fixture
def models(settings):
    require_runtime()
    folder = settings.data / "models"
    folder.mkdir()
    return folder


class Eye:
    """The gateway's end of a camera: a picture each tenth of a second, by its own clock."""

    def __init__(self, camera) -> None:  # noqa: D107
        self.camera = camera
        self.seq = 0
        self.time_us = time.time_ns() // 1000

    async def show(self, data: bytes) -> int:
        self.seq, self.time_us = self.seq + 1, self.time_us + 100_000
        await self.camera.say(
            frames.PictureFrame(
                stream=FRONT, seq=self.seq, time_us=self.time_us, mono_us=self.seq, width=64,
                height=48, forms=["jpeg_small"], data=data,
            )
        )  # fmt: skip
        return self.seq


@pytest.fixture
async def eye(hub, models):
    gateway = await hub.gateway()
    await gateway.hello(LOOKED_AT)
    watch = await gateway.hear(frames.StreamSubscription, lambda watch: watch.streams)
    # Nobody else looks, and small pictures do.
    assert watch.forms == {FRONT: ["jpeg_small"]}
    eye = Eye(await hub.camera())
    eye.gateway = gateway
    return eye


async def test_the_hub_sees_frames_counts_and_keeps_what_comes_into_sight(
    hub, eye, models, history
):
    red_detector(models / "red.onnx")
    page, viewer = await hub.page("operator"), await hub.viewer("operator", FRONT)
    await page.say(Subscribe(sub=1, site="agv", channels=["camera/front_red_thing"], every_ms=0))
    await viewer.say(BoxesRequest(on=True))
    await eye.gateway.hear(frames.StreamSubscription, lambda watch: watch.boxes)
    began = eye.time_us + 100_000
    for _ in range(4):
        seq = await eye.show(RED)
        boxes = await viewer.hear(CameraPictureBoxes, lambda boxes, seq=seq: boxes.seq == seq)
    assert boxes.time_us == eye.time_us
    (thing,) = boxes.things
    assert thing.label == "red thing"
    assert [thing.left, thing.top, thing.right, thing.bottom] == pytest.approx(
        [0.25, 1 / 6, 0.75, 5 / 6], abs=0.01
    )
    news = await page.hear(SightingUpdate)
    assert (news.camera, news.label, news.began_us) == (FRONT, "red thing", began)
    values = await page.hear(Values, lambda values: values.value)
    columns = unpack_columns(values)
    assert (columns.value[0], columns.time_us[0]) == (1.0, began)
    seq = await eye.show(GREY)
    assert not (await viewer.hear(CameraPictureBoxes, lambda boxes: boxes.seq == seq)).things
    client = await hub.client("operator")
    found = (await client.get("/api/sites/agv/sightings")).json()["sightings"]
    assert (found[0]["id"], found[0]["picture"]) == (str(news.id), True)
    async with asyncio.timeout(PATIENCE_S):
        while len(stored := kept_by_the_hub(history)) < 2:
            history.appended.clear()
            await history.appended.wait()
    assert [row[2] for row in stored] == [1.0, 0.0]
    # It is looked for no more, and the pages go on.
    await eye.gateway.close()
    other = await hub.gateway()
    await other.hello(DESCRIPTION)
    assert (await page.hear(SightingUpdate, lambda news: news.ended_us)).id == news.id
    await other.hear(frames.StreamSubscription, lambda watch: watch.forms == {FRONT: ["jpeg"]})


def kept_by_the_hub(history) -> list[tuple]:
    return [
        row
        for (_, boot), rows in history.samples.items()
        if boot.startswith("hub ")
        for row in rows.values()
    ]


async def test_a_file_that_is_missing_at_the_hub_is_said_once_and_names_no_other_folder(
    hub, eye, models
):
    page = await hub.page("operator")
    await eye.show(RED)
    said = await page.hear(EventUpdate, lambda news: news.kind == "detection lost")
    assert said.device == "camera"
    assert f"{models}/red.onnx: there is no such file" in said.message
    assert "/etc/secrets" not in said.message


@pytest.mark.parametrize("data", [b"no picture", RED[:200]])
async def test_a_picture_that_cannot_be_read_is_said_once_and_so_is_the_recovery(
    hub, eye, models, data
):
    red_detector(models / "red.onnx")
    page = await hub.page("operator")
    await eye.show(data)
    said = await page.hear(EventUpdate, lambda news: news.kind == "detection lost")
    assert "a picture cannot be read" in said.message
    # It asks for pictures again after a while.
    await eye.gateway.hear(frames.StreamSubscription, lambda watch: not watch.streams)
    await eye.gateway.hear(frames.StreamSubscription, lambda watch: watch.streams)
    await eye.show(RED)
    await page.hear(EventUpdate, lambda news: news.kind == "detection back")
