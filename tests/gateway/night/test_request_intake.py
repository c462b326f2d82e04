"""Pieces of what is asked make a whole, or nothing."""

from __future__ import annotations

import pytest
from hypothesis import given, strategies as st
from night_observatory import request

from talaia.gateway.night.request_intake import RequestIntake
from talaia.wire.frames import RequestSync

pytestmark = pytest.mark.pure


def pieces(revision: int, count: int) -> list[RequestSync]:
    return [
        RequestSync(
            revision=revision,
            piece=index,
            pieces=count,
            groups=[request(f"r{revision}-{index}")],
        )
        for index in range(count)
    ]


def test_the_last_missing_piece_makes_the_set_in_order() -> None:
    intake, parts = RequestIntake(), pieces(4, 3)
    assert [intake.take_piece(parts[index]) for index in (2, 0)] == [None, None]
    whole = intake.take_piece(parts[1])
    assert whole is not None
    assert whole.revision == 4
    assert [group.id for group in whole.groups] == ["g-r4-0", "g-r4-1", "g-r4-2"]


def test_pieces_of_another_revision_are_forgotten() -> None:
    intake = RequestIntake()
    intake.take_piece(pieces(4, 2)[0])
    assert intake.take_piece(pieces(5, 2)[1]) is None
    assert intake.take_piece(pieces(4, 2)[1]) is None
    assert intake.take_piece(pieces(4, 2)[0]) is not None


def test_a_piece_that_cannot_be_is_passed_over() -> None:
    assert RequestIntake().take_piece(RequestSync(revision=1, piece=3, pieces=2)) is None
    assert RequestIntake().take_piece(RequestSync(revision=1, piece=0, pieces=0)) is None


@given(st.lists(st.tuples(st.integers(1, 2), st.integers(0, 2)), max_size=20))
def test_a_set_is_never_mixed_of_two_revisions(order: list[tuple[int, int]]) -> None:
    intake, parts = RequestIntake(), {1: pieces(1, 3), 2: pieces(2, 3)}
    for revision, index in order:
        whole = intake.take_piece(parts[revision][index])
        if whole is not None:
            assert whole.revision == revision
            assert {group.id[:4] for group in whole.groups} == {f"g-r{revision}"}
