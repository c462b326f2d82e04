"""Figures for Prometheus, put together of what each shard answers for its own sites. Pure."""

from __future__ import annotations

import re
from itertools import zip_longest
from typing import TYPE_CHECKING

from talaia.wire.errors import PeerError
from talaia.wire.protobuf import bytes_field, read_bytes, read_fields

if TYPE_CHECKING:
    from collections.abc import Mapping, Sequence

    import pyarrow as pa

__all__ = ["join_metrics", "join_past_series"]

_EOF = "# EOF"
_META = re.compile(r"# (?:HELP|TYPE|UNIT) (\S+)")
_SAMPLE = re.compile(r"([a-zA-Z_:][a-zA-Z0-9_:]*)(\{)?")
# Of an answer to a remote read: the results of its queries.
_RESULTS = 1
# Of a block of Snappy, unpacked (bytes): what a shard answers at most is some ten million.
_MOST_UNPACKED = 64 * 1024 * 1024


def join_metrics(bodies: Mapping[str, bytes], main: str) -> bytes:
    """Join scrapes by shard: each family once, with the samples of all.

    What a shard other than ``main`` tells of itself, and not of a site, gets the label ``shard``:
    the main one tells the same of itself, under the same names.
    """
    heads: dict[str, list[str]] = {}
    samples: dict[str, list[str]] = {}
    ends = ""
    for shard, body in bodies.items():
        family, new = "", False
        for line in body.decode().splitlines():
            if line == _EOF:
                ends = _EOF + "\n"
            elif (meta := _META.match(line)) is not None:
                if meta[1] != family:
                    family, new = meta[1], meta[1] not in heads
                if new:
                    heads.setdefault(family, []).append(line)
            elif line:
                own = line if shard == main else _with_shard(line, shard)
                samples.setdefault(family, []).append(own)
    lines = [line for family, head in heads.items() for line in (*head, *samples.get(family, ()))]
    return ("".join(f"{line}\n" for line in lines) + ends).encode()


def _with_shard(line: str, shard: str) -> str:
    """Say whose figure it is, if it is not a site's."""
    # Quotes within a label's value are escaped, so this is the label itself.
    if '{site="' in line or ',site="' in line:
        return line
    found = _SAMPLE.match(line)
    if found is None:
        return line
    label = f'{{shard="{shard}"'
    rest = line[found.end() :]
    return f"{found[1]}{label},{rest}" if found[2] else f"{found[1]}{label}}}{rest}"


def join_past_series(bodies: Sequence[bytes]) -> bytes:
    """Join answers to a remote read: of each query the series of all.

    It takes a moment: call it in a thread.
    """
    import pyarrow as pa

    results: list[bytes] = []
    for body in bodies:
        unpacked = _unpack(pa.Codec("snappy"), body)
        own = [read_bytes(value) for number, value in read_fields(unpacked) if number == _RESULTS]
        # A message of Protocol Buffers behind another of its kind is both of them: lists go on.
        results = [before + more for before, more in zip_longest(results, own, fillvalue=b"")]
    packed: bytes = pa.compress(
        b"".join(bytes_field(_RESULTS, result) for result in results), codec="snappy", asbytes=True
    )
    return packed


def _unpack(codec: pa.Codec, body: bytes) -> bytes:
    """Unpack a block of Snappy, which begins with its size as a varint."""
    size = 0
    for place, byte in enumerate(body[:5]):
        size |= (byte & 0x7F) << (7 * place)
        if byte < 0x80:
            break
    if size > _MOST_UNPACKED:
        raise PeerError(f"an answer of {size} bytes is over {_MOST_UNPACKED}")
    unpacked: bytes = codec.decompress(body, size, asbytes=True) if size else b""
    return unpacked
