"""Lease epochs and latched stops outlast the gateway."""

from __future__ import annotations

from typing import TYPE_CHECKING

import pytest

from talaia.gateway.driving.persistent_state import LeaseEpochs, PersistentStops
from talaia.gateway.driving.stop_latch import LatchedStop
from talaia.gateway.errors import SpoolError

if TYPE_CHECKING:
    from pathlib import Path

pytestmark = pytest.mark.pure


def test_epochs_rise_over_restarts(tmp_path: Path) -> None:
    path = tmp_path / "e.json"
    seen = []
    for count in (1, 1500, 1003, 2002, 1):
        epochs = LeaseEpochs(path)
        seen += [epochs.next_epoch() for _ in range(count)]
    assert seen == sorted(set(seen))


def test_damaged_epochs_are_not_guessed(tmp_path: Path) -> None:
    path = tmp_path / "e.json"
    path.write_bytes(b"12x")
    with pytest.raises(SpoolError, match="not guessed"):
        LeaseEpochs(path)


def test_stops_are_kept_by_device(tmp_path: Path) -> None:
    stops = PersistentStops(tmp_path / "s.json")
    stops.write_stop("a", LatchedStop("1", "Ada", 5))
    stops.write_stop("b", LatchedStop("2", "Ben", 6))
    stops.write_stop("a", None)
    later = PersistentStops(tmp_path / "s.json")
    assert later.find_stop("a") is None
    assert later.find_stop("b") == LatchedStop("2", "Ben", 6)
