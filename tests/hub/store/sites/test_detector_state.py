"""What anomaly detectors have learned comes back as it was, from every kind of database."""

from __future__ import annotations

from talaia.clock import HandClock
from talaia.hub.store.sites.detector_state import DetectorState


async def test_what_is_saved_last_comes_back_byte_by_byte(database) -> None:
    learned = DetectorState(database, HandClock())
    state = bytes(range(256)) + b'it\'s \\ "quoted"'
    await learned.save_states([("agv", "power/charge", "together", b"before")])
    await learned.save_states(
        [("agv", "power/charge", "together", state), ("moon", "a/b", "flat", b"")]
    )
    assert await learned.states_of("agv") == {("power/charge", "together"): state}
