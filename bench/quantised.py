"""The object detector in eight bits beside the one that ships: how fast, and how right.

    MUJOCO_GL=egl PYTHONPATH=src:bench python bench/quantised.py --kept FOLDER

(`pip install --no-deps -r requirements/bench.txt` first.) Its file is written into ``FOLDER``:
ONNX Runtime's static quantisation, weights by channel, with what is between the layers learned from
pictures of the scenes 0 to 9. It is judged on the scenes 100 to 109 (see `identity`): IDF1, people
found (a box that is half sure and overlaps the true one by half), false boxes a picture; and by
turns with the other for the time of a run.
"""

from __future__ import annotations

import argparse
import sys
import time
from pathlib import Path
from typing import TYPE_CHECKING, Any

import identity
import identity_scenes as scenes
import motmetrics
import numpy as np
import onnx
import onnxruntime
from onnx import numpy_helper
from onnxruntime import quantization

from talaia.model.coco_classes import COCO
from talaia.objects.detector import NANODET, Detector
from talaia.objects.network import open_network
from talaia.objects.providers import CPU, parse_provider
from talaia.objects.worker import OWN_FILE

if TYPE_CHECKING:
    from collections.abc import Callable, Iterator

KINDS = ["Conv", "LeakyRelu", "Add", "Concat", "Resize"]
# Of the scenes for learning every so many pictures.
EVERY = 24


class Inputs(quantization.CalibrationDataReader):
    """What the network is shown of the pictures that are learned from."""

    def __init__(self, name: str) -> None:
        """Begin with the first."""
        self._name, self._inputs = name, self._all()

    def _all(self) -> Iterator[np.ndarray]:
        shown: list[np.ndarray] = []

        def keep(given: np.ndarray) -> list[np.ndarray]:
            shown.append(given)
            return list(run(given))

        run = open_network(str(OWN_FILE), parse_provider(CPU))
        detector = Detector(NANODET, COCO, keep)
        for seed in range(10):
            for at, moment in enumerate(scenes.play(seed)):
                if at % EVERY == 0:
                    detector.detect_objects(moment.picture, 0.3)
                    yield shown.pop()

    def get_next(self) -> dict[str, np.ndarray] | None:
        """Give the next one."""
        given = next(self._inputs, None)
        return None if given is None else {self._name: given}


def simplified(path: Path) -> None:
    """Write the file as ONNX Runtime simplifies it, sizes of pictures told as scales."""
    options = onnxruntime.SessionOptions()
    options.graph_optimization_level = onnxruntime.GraphOptimizationLevel.ORT_ENABLE_BASIC
    options.optimized_model_filepath = str(path)
    onnxruntime.InferenceSession(str(OWN_FILE), options)
    model = onnx.load(path)
    values = onnx.shape_inference.infer_shapes(model).graph.value_info
    shapes = {
        one.name: [side.dim_value for side in one.type.tensor_type.shape.dim] for one in values
    }
    constants = {one.name: one for one in model.graph.initializer}
    for node in model.graph.node:
        if node.op_type != "Resize":
            continue
        # With sizes of two axes ONNX Runtime 1.31 cannot move its transpositions past them.
        sizes = [*shapes[node.input[0]][:2], *numpy_helper.to_array(constants[node.input[3]])]
        scales = (np.array(sizes) / shapes[node.input[0]]).astype(np.float32)
        model.graph.initializer.append(numpy_helper.from_array(scales, f"{node.name}/scales"))
        node.input[2] = f"{node.name}/scales"
        del node.input[3]
        node.attribute.remove(next(one for one in node.attribute if one.name == "axes"))
    onnx.save(model, path)


def quantise(folder: Path) -> Path:
    """Write the file in eight bits."""
    plain, path = folder / "nanodet-simplified.onnx", folder / "nanodet-int8.onnx"
    if path.exists():
        return path
    simplified(plain)
    name = onnx.load(plain).graph.input[0].name
    quantization.quantize_static(
        plain, path, Inputs(name), per_channel=True, op_types_to_quantize=KINDS,
        activation_type=quantization.QuantType.QUInt8, weight_type=quantization.QuantType.QInt8,
    )  # fmt: skip
    return path


def print_times(runs: dict[str, Callable[[Any], Any]]) -> None:
    """Print what a run takes, by turns."""
    given = np.random.default_rng(1).random((1, 3, NANODET.side, NANODET.side), np.float32)
    times: dict[str, list[float]] = {name: [] for name in runs}
    for _ in range(40):
        for name, run in runs.items():
            began = time.thread_time()
            run(given)
            times[name].append(1000 * (time.thread_time() - began))
    for name, each in times.items():
        print(f"{name}: a run {np.median(each):.1f} ms (the least {min(each):.1f})")


def print_judged(name: str, file: str, folder: Path) -> None:
    """Print how right a file is."""
    kept = folder / name
    kept.mkdir(exist_ok=True)
    judged, found, people, false = [], 0, 0, 0
    for seed in range(100, 110):
        scene = identity.kept_scene(seed, kept, file)
        for truth, boxes in zip(scene.truth, scene.found, strict=True):
            sure = [box[1:] for box in boxes if box[0] >= 0.5]
            hit = sum(any(identity.overlap_of(one, box) >= 0.5 for box in sure)
                      for one in truth.values())  # fmt: skip
            found, people, false = found + hit, people + len(truth), false + len(sure) - hit
        judged.append(identity.judge(scene, identity.own(), seed))
    told = motmetrics.metrics.create().compute_many(
        [one.account for one in judged], metrics=["idf1"], generate_overall=True
    )["idf1"]
    print(
        f"{name}: IDF1 {told['OVERALL']:.3f}, people found {found / people:.1%}, false boxes"
        f" {false / 2400:.4f} a picture; line crossings right {sum(one.right for one in judged)} of"
        f" {sum(one.crossings for one in judged)}"
    )


def main() -> int:
    """Print both."""
    parser = argparse.ArgumentParser(description=__doc__.split("\n", 1)[0])
    parser.add_argument("--kept", type=Path, required=True, help="folder for files and scenes")
    asked = parser.parse_args()
    asked.kept.mkdir(parents=True, exist_ok=True)
    np.asfarray = lambda some, dtype=float: np.asarray(some, dtype)  # type: ignore[attr-defined]
    files = {"float": OWN_FILE, "int8": quantise(asked.kept)}
    for name, path in files.items():
        print(f"{name}: {Path(path).stat().st_size / 1e6:.1f} MB")
    print_times(
        {name: open_network(str(path), parse_provider(CPU)) for name, path in files.items()}
    )
    for name, path in files.items():
        print_judged(name, str(path), asked.kept)
    return 0


if __name__ == "__main__":
    sys.exit(main())
