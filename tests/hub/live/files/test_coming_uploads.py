"""What is on its way is counted by site, in the order in which it was offered."""

from __future__ import annotations

import pytest

from talaia.hub.live.files.coming_uploads import ComingUploads

pytestmark = pytest.mark.pure
MIB = 1024 * 1024


def test_the_one_offered_last_is_last_whatever_came_of_the_others() -> None:
    coming = ComingUploads()
    for name in ("a", "b", "c"):
        coming.begin_upload("agv", name, 0, 0.0)
    coming.update_upload("agv", "a", 10, 1.0)
    coming.begin_upload("agv", "b", 5, 2.0)
    assert coming.others_than("agv", "none") == ["a", "c", "b"]
    assert coming.others_than("agv", "b") == ["a", "c"]
    assert coming.total_bytes("agv") == 15
    assert coming.others_than("rover", "none") == []
    assert coming.total_bytes("rover") == 0


def test_what_nothing_has_come_of_since_stands() -> None:
    coming = ComingUploads()
    coming.begin_upload("agv", "old", 3, 10.0)
    coming.begin_upload("agv", "new", 3, 20.0)
    assert coming.standing_uploads("agv", 15.0) == ["old"]
    coming.update_upload("agv", "old", 4, 30.0)
    assert coming.standing_uploads("agv", 15.0) == []
    coming.end_upload("agv", "old")
    coming.end_upload("agv", "old")
    assert coming.others_than("agv", "new") == []


def test_a_row_says_how_far_it_is_after_four_mebibytes() -> None:
    coming = ComingUploads()
    # What was there when it was offered again has been said.
    coming.begin_upload("agv", "film", 3 * MIB, 0.0)
    due = [coming.update_upload("agv", "film", mebibytes * MIB, 0.0) for mebibytes in range(4, 13)]
    assert due == [False, False, False, True, False, False, False, True, False]
