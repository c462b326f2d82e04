"""What is fuzzed, how it is held, and its seeds."""

from __future__ import annotations

import ast
import base64
import contextlib
import time
import zlib
from pathlib import Path
from typing import TYPE_CHECKING, NamedTuple

if TYPE_CHECKING:
    from collections.abc import Callable, Iterable

SEEDS = Path(__file__).parent / "seeds"
# Of processor time for one input, whatever else the machine does (s).
MOST_S = 1.0
# A longer seed is kept packed, so that no line is of thousands of letters.
_LONGEST_PLAIN = 400
_PACKED = "packed "


class FuzzTarget(NamedTuple):
    """One reader.

    Attributes:
        name: of it and of its file of seeds.
        read: what is given the bytes.
        errors: what it may raise; anything else is a fault.
        longest: no input is longer (bytes).
        share: how often it is tried in `make test`, beside one that takes microseconds.

    """

    name: str
    read: Callable[[bytes], object]
    errors: tuple[type[BaseException], ...]
    longest: int = 64 * 1024
    share: float = 1.0


class TooSlow(AssertionError):
    """An input that kept a reader busy for longer than `MOST_S`."""


def try_input(target: FuzzTarget, data: bytes, most_s: float = MOST_S) -> None:
    """Give one input to a reader.

    Raises:
        TooSlow: it took too long; other than that, whatever it raises and has not declared.

    """
    began = time.thread_time()
    with contextlib.suppress(*target.errors):
        target.read(data[: target.longest])
    took = time.thread_time() - began
    if took > most_s:
        raise TooSlow(f"{target.name}: {took:.1f} s for {len(data)} bytes: {data[:200]!r}")


def load_seeds(name: str) -> list[bytes]:
    """Read a target's seeds; the empty input is always one."""
    found = [b""]
    for line in (SEEDS / f"{name}.txt").read_text("ascii").splitlines():
        if line.startswith(_PACKED):
            found.append(zlib.decompress(base64.b64decode(line.removeprefix(_PACKED))))
        elif line and not line.startswith("#"):
            found.append(ast.literal_eval(line))
    return found


def save_seeds(name: str, seeds: Iterable[bytes]) -> None:
    """Write a target's seeds, the shortest first, each once."""
    lines = []
    for seed in sorted(set(seeds) - {b""}, key=lambda data: (len(data), data)):
        if len(seed) <= _LONGEST_PLAIN:
            lines.append(repr(seed))
        else:
            lines.append(_PACKED + base64.b64encode(zlib.compress(seed, 9)).decode())
    (SEEDS / f"{name}.txt").write_text("\n".join(lines) + "\n", "ascii")
