"""Changes of seeds, the same in each run: for where no coverage guides."""

from __future__ import annotations

import random
from typing import TYPE_CHECKING

if TYPE_CHECKING:
    from collections.abc import Iterator, Sequence

# What readers of lengths, numbers and texts stumble on.
_WORDS = (
    b"\0", b"\xff", b"\x7f", b"\x80", b"\xff\xff\xff\xff", b"\x80\0\0\0", b"\xff\xff\xff\x7f",
    b"\xff" * 8, b"\x80" + b"\0" * 7, b"-1", b"0", b"1e999", b"NaN", b"nan", b"inf", b"9" * 400,
    b"1e-999", b"\xf0\x9f\x98\x80", b"\xed\xa0\x80", b"\\ud800", b"\"", b"'", b"{", b"}", b"[",
    b"]", b"<", b">", b"&", b"%s", b"../", b"\r\n", b":", b",", b"null", b"true", b"[[[[", b"((((",
)  # fmt: skip
# One of so many is blown up: some readers are slow only with much of the same.
_AMPLIFIED = 25
_MOST_AMPLIFIED = 256 * 1024


def mutations(seeds: Sequence[bytes], count: int, name: str) -> Iterator[bytes]:
    """Give so many changes of seeds; ``name`` says which of all that there are."""
    # Not for secrets: a run that failed can be run again.
    chance = random.Random(name)  # noqa: S311
    for number in range(count):
        data = bytearray(chance.choice(seeds))
        for _ in range(chance.choice((1, 1, 2, 3, 8))):
            _change(data, seeds, chance)
        yield _amplify(data, chance) if number % _AMPLIFIED == 0 else bytes(data)


def _change(data: bytearray, seeds: Sequence[bytes], chance: random.Random) -> None:
    at = chance.randrange(len(data) + 1)
    end = min(len(data), at + chance.choice((1, 1, 2, 4, 8, 30)))
    match chance.randrange(6):
        case 0 if data:
            data[at % len(data)] ^= 1 << chance.randrange(8)
        case 1 if data:
            data[at % len(data)] = chance.randrange(256)
        case 2:
            del data[at:end]
        case 3:
            # A part once more.
            data[at:at] = data[at:end]
        case 4:
            data[at:end] = chance.choice(_WORDS)
        case _:
            # A part of another seed, in place of one of this.
            other = chance.choice(seeds)
            begin = chance.randrange(len(other) + 1)
            data[at:end] = other[begin : begin + chance.choice((4, 16, 64))]


def _amplify(data: bytearray, chance: random.Random) -> bytes:
    at = chance.randrange(len(data) + 1)
    part = bytes(data[at : at + chance.choice((1, 1, 2, 5, 20))]) or b"["
    times = chance.choice((100, 5_000, _MOST_AMPLIFIED)) // len(part)
    return bytes(data[:at]) + part * times + bytes(data[at:])
