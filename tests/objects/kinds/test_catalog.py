"""Each kind in a process of its own: what it tells, and what becomes of one that cannot."""

from __future__ import annotations

import sys
from pathlib import Path
from typing import TYPE_CHECKING

import numpy as np
import psutil
import pytest
from picture_model_files import (
    ONNX,
    bright_depth,
    colour_classifier,
    colour_segmenter,
    constant_file,
    red_pose,
)

from talaia.model.detection import DepthScale, ModelKind, ObjectModel
from talaia.objects.errors import DetectorError
from talaia.objects.kinds.catalog import KINDS
from talaia.objects.kinds.classification import Likelihoods
from talaia.objects.kinds.depth import DepthMap
from talaia.objects.kinds.keypoints import Poses
from talaia.objects.kinds.segmentation import ClassMap
from talaia.objects.worker import Worker

if TYPE_CHECKING:
    from collections.abc import AsyncIterator

sys.path.insert(0, str(Path(__file__).resolve().parents[2] / "gateway"))
from detector_files import red_detector, require_runtime

COLOURS = ("red", "green", "blue")
RED = np.full((48, 64, 3), (255, 0, 0), np.uint8)
MODELS = {
    "ground": ObjectModel(file="g.onnx", kind=ModelKind.SEGMENTATION, classes=COLOURS, side=64),
    "room": ObjectModel(file="r.onnx", kind=ModelKind.CLASSIFICATION, classes=COLOURS, side=32),
    "pose": ObjectModel(
        file="p.onnx", kind=ModelKind.KEYPOINTS, classes=("person",), points=("hand",), side=32
    ),
    "far": ObjectModel(file="f.onnx", kind=ModelKind.DEPTH, scale=DepthScale.METRES, side=70),
    "red": ObjectModel(file="red.onnx", kind=ModelKind.YOLO, classes=("red thing",), side=32),
    "other": ObjectModel(file="o.onnx", kind=ModelKind.DEPTH, side=32),
    "huge": ObjectModel(file="h.onnx", kind=ModelKind.SEGMENTATION, classes=COLOURS, side=2048),
}


@pytest.fixture
async def worker(tmp_path: Path) -> AsyncIterator[tuple[Worker, list[tuple[str, str]]]]:
    require_runtime()
    colour_segmenter(tmp_path / "g.onnx", 64)
    colour_classifier(tmp_path / "r.onnx", 32)
    red_pose(tmp_path / "p.onnx", 32, [(0.5, 0.5)])
    bright_depth(tmp_path / "f.onnx", 70)
    red_detector(tmp_path / "red.onnx")
    constant_file(tmp_path / "o.onnx", {"out": np.zeros((1, 3), "<f4")})
    huge_segmenter(tmp_path / "h.onnx")
    said: list[tuple[str, str]] = []
    worker = Worker(MODELS, tmp_path, lambda model, why: said.append((model, why)))
    yield worker, said
    await worker.close()


def huge_segmenter(path: Path) -> None:
    """Write a file that wants more memory than a model's process may have."""
    graph = ONNX.Graph("huge")
    graph.input("picture", [1, 3, 2048, 2048])
    graph.constant("many", np.array([1, 200, 1, 1], "<i8"))
    graph.node("Tile", ["picture", "many"], ["scores"])
    graph.output("scores", [1, 600, 2048, 2048])
    path.write_bytes(graph.file())


async def test_each_kind_tells_of_a_picture_from_a_process_that_gives_way(worker) -> None:
    asked, said = worker
    ground = await asked.read_scene("ground", RED, 0.5)
    assert isinstance(ground, ClassMap)
    assert (ground.cells == 0).all()
    room = await asked.read_scene("room", RED, 0.5)
    assert isinstance(room, Likelihoods)
    assert room.likeliest() == 0
    pose = await asked.read_scene("pose", RED, 0.5)
    assert isinstance(pose, Poses)
    assert len(pose.things) == 1
    far = await asked.read_scene("far", RED, 0.5)
    assert isinstance(far, DepthMap)
    assert np.nanmedian(far.cells) == pytest.approx(10 / 3, abs=0.05)
    children = [
        child for child in psutil.Process().children() if "talaia.objects.child" in child.cmdline()
    ]
    assert {child.nice() for child in children} == {min(psutil.Process().nice() + 10, 19)}
    assert len(children) == 4
    assert said == []


async def test_file_of_another_kind_or_one_that_eats_memory_is_told_once_and_holds_up_no_other(
    worker,
) -> None:
    asked, said = worker
    for _ in range(2):
        with pytest.raises(DetectorError, match="kind depth gives 1 × rows × columns"):
            await asked.read_scene("other", RED, 0.5)
    with pytest.raises(DetectorError, match=r"cannot be run|ended"):
        await asked.read_scene("huge", RED, 0.5)
    with pytest.raises(DetectorError, match="tells anything but boxes"):
        await asked.read_scene("red", RED, 0.5)
    assert [model for model, _ in said] == ["other", "huge"]
    assert (await asked.read_scene("ground", RED, 0.5)).cells.size == 120 * 160


@pytest.mark.parametrize("kind", list(KINDS))
@pytest.mark.parametrize(
    "answer",
    [
        {},
        {"rows": 2, "columns": 2, "data": "AA=="},
        {"shares": ["a"], "poses": [[1, 2, 3]], "rows": -1, "columns": 1, "data": ""},
        {"shares": None, "poses": None, "rows": None, "columns": None, "data": None},
    ],
)
def test_answer_that_is_none_is_an_error_that_the_worker_knows(kind, answer) -> None:
    with pytest.raises((KeyError, ValueError, TypeError, IndexError)):
        KINDS[kind].read_answer(answer)


def test_there_is_a_contract_for_each_kind_that_tells_no_boxes() -> None:
    assert set(KINDS) == {kind for kind in ModelKind if not kind.tells_boxes}
