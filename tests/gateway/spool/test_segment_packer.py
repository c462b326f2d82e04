"""Segment packer: what it cannot pack is forced to disk as it is."""

from __future__ import annotations

from typing import TYPE_CHECKING

from talaia.gateway.spool.files import Segment, SegmentHead
from talaia.gateway.spool.segment_packer import pack_segment

if TYPE_CHECKING:
    from pathlib import Path

    import pytest


def test_segment_that_cannot_be_packed_is_forced_to_disk(
    tmp_path: Path, caplog: pytest.LogCaptureFixture
) -> None:
    # It holds no head, so it is not packed; and the system says of it that it cannot be forced,
    # which shows that this was tried.
    path = tmp_path / "0000000001.seg"
    path.symlink_to("/dev/null")
    pack_segment(Segment(1, path, SegmentHead("boot-a", "cat", []), 0, 0))
    assert f"{path} cannot be forced to disk" in caplog.text
