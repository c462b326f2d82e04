"""Samples as columns: what is packed is unpacked, and unequal columns are refused."""

from __future__ import annotations

from contextlib import suppress

import numpy as np
import pytest
from hypothesis import given, strategies as st

from talaia.wire.columns import MAX_SAMPLES, Columns, PackedColumns, pack_columns, unpack_columns
from talaia.wire.errors import PeerError

NOON_US = 1_700_000_000_000_000
sample = st.tuples(st.integers(0, 65_535), st.integers(-(2**29), 2**29), st.floats(width=64))


def columns_of(rows: list[tuple[int, int, float]], texts: dict[int, str] | None = None) -> Columns:
    return Columns(
        np.array([row[0] for row in rows], np.uint16),
        np.array([NOON_US + row[1] for row in rows], np.int64),
        np.array([row[2] for row in rows], np.float64),
        texts or {},
    )


@given(st.lists(sample, max_size=50))
def test_what_is_packed_is_unpacked_to_the_bit(rows: list[tuple[int, int, float]]) -> None:
    columns = columns_of(rows)
    again = unpack_columns(pack_columns(columns))
    assert again.channel.tolist() == columns.channel.tolist()
    assert again.time_us.tolist() == columns.time_us.tolist()
    assert again.value.tobytes() == columns.value.tobytes()
    assert len(again) == len(rows)


@given(st.binary(max_size=60), st.binary(max_size=60), st.binary(max_size=60))
def test_any_three_columns_are_a_batch_or_a_peer_error(a: bytes, b: bytes, c: bytes) -> None:
    with suppress(PeerError):
        assert len(unpack_columns(PackedColumns(NOON_US, a, b, c, {}))) * 2 == len(a)


def test_a_batch_that_spans_more_than_its_offsets_hold_is_the_callers_to_cut() -> None:
    with pytest.raises(ValueError, match="spans more time"):
        pack_columns(columns_of([(0, 0, 1.0), (0, 2**31, 2.0)]))


def test_a_batch_that_is_too_long_is_refused_on_both_sides() -> None:
    count = MAX_SAMPLES + 1
    zeros = np.zeros(count)
    columns = Columns(zeros.astype(np.uint16), zeros.astype(np.int64), zeros, {})
    with pytest.raises(ValueError, match="do not fit"):
        pack_columns(columns)
    with pytest.raises(PeerError) as caught:
        unpack_columns(PackedColumns(0, bytes(2 * count), bytes(4 * count), bytes(8 * count), {}))
    assert caught.value.code == 1009


def test_a_text_outside_its_batch_is_refused() -> None:
    packed = pack_columns(columns_of([(0, 0, float("nan"))], {0: "on"}))
    assert unpack_columns(packed).texts == {0: "on"}
    with pytest.raises(PeerError, match="outside"):
        unpack_columns(packed._replace(texts={1: "on"}))
