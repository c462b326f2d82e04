"""Tiny ONNX files of each kind that tells no boxes, made on the spot and run by ONNX Runtime.

What they tell follows from the picture by a sum that a test knows: the share of its colours, say.
"""

from __future__ import annotations

import importlib.util
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np

if TYPE_CHECKING:
    from collections.abc import Mapping, Sequence

    from numpy.typing import NDArray

_TOOL = Path(__file__).resolve().parents[1] / "tools/onnx_file.py"


def _load_tool() -> Any:
    """Load the project's own writer of ONNX."""
    spec = importlib.util.spec_from_file_location("onnx_file", _TOOL)
    assert spec is not None
    assert spec.loader is not None
    module = importlib.util.module_from_spec(spec)
    spec.loader.exec_module(module)
    return module


ONNX = _load_tool()


def constant_file(
    path: Path,
    outputs: Mapping[str, NDArray[Any]],
    shape: Sequence[int | str] = (1, 3, "rows", "columns"),
) -> Path:
    """Write a file that gives the same whatever it is shown: hostile ones, say."""
    graph = ONNX.Graph("constant")
    graph.input("picture", shape)
    for name, values in outputs.items():
        graph.constant(f"{name}_kept", values)
        graph.node("Identity", [f"{name}_kept"], [name])
        graph.output(name, values.shape, ONNX.TYPES[values.dtype])
    path.write_bytes(graph.file())
    return path


def colour_segmenter(path: Path, side: int) -> Path:
    """Write a segmentation: each cell is the class of its strongest colour: red, green, blue."""
    graph = ONNX.Graph("colours")
    graph.input("picture", [1, 3, side, side])
    graph.node("Identity", ["picture"], ["scores"])
    graph.output("scores", [1, 3, side, side])
    path.write_bytes(graph.file())
    return path


def colour_classifier(path: Path, side: int) -> Path:
    """Write a classification: ten times the mean of each colour are the scores of its class."""
    graph = ONNX.Graph("mean colour")
    graph.input("picture", [1, 3, side, side])
    graph.constant("places", np.array([2, 3], "<i8"))
    graph.constant("ten", np.array([10], "<f4"))
    graph.node("ReduceMean", ["picture", "places"], ["mean"], keepdims=0)
    graph.node("Mul", ["mean", "ten"], ["scores"])
    graph.output("scores", [1, 3])
    path.write_bytes(graph.file())
    return path


def red_pose(path: Path, side: int, points: Sequence[tuple[float, float]]) -> Path:
    """Write key points of a thing in the middle half, as sure as the picture is red.

    Its points are at these parts of the square, each as sure as the thing.
    """
    graph = ONNX.Graph("pose")
    graph.input("picture", [1, 3, side, side])
    for name, values in (("zero", [0]), ("one", [1]), ("two", [2]), ("places", [2, 3])):
        graph.constant(name, np.array(values, "<i8"))
    graph.node("ReduceMean", ["picture", "places"], ["mean"], keepdims=0)
    graph.node("Slice", ["mean", "zero", "one", "one"], ["red"])
    graph.constant("box", np.full((1, 4), side / 2, "<f4"))
    parts = ["box", "red"]
    for number, point in enumerate(points):
        graph.constant(f"point{number}", np.array([point], "<f4") * side)
        parts += [f"point{number}", "red"]
    graph.node("Concat", parts, ["row"], axis=1)
    graph.node("Unsqueeze", ["row", "two"], ["boxes"])
    graph.output("boxes", [1, 5 + 3 * len(points), 1])
    path.write_bytes(graph.file())
    return path


def bright_depth(path: Path, side: int) -> Path:
    """Write depth: ten times the mean of the colours, 0 to 10, as metres or as nearness."""
    graph = ONNX.Graph("depth")
    graph.input("picture", [1, 3, side, side])
    graph.constant("colours", np.array([1], "<i8"))
    graph.constant("ten", np.array([10], "<f4"))
    graph.node("ReduceMean", ["picture", "colours"], ["mean"], keepdims=0)
    graph.node("Mul", ["mean", "ten"], ["depth"])
    graph.output("depth", [1, side, side])
    path.write_bytes(graph.file())
    return path
