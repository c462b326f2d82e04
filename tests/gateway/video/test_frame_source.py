"""Pictures for those who look at the gateway itself."""

from __future__ import annotations

import threading

import numpy as np
import pytest

from talaia.gateway.video.frame_source import FrameSource

pytestmark = pytest.mark.pure

RGB = np.zeros((2, 3, 3), np.uint8)


def test_nothing_is_kept_of_a_stream_that_nobody_holds() -> None:
    looks = FrameSource()
    looks.offer_frame("cam/front", (1, 2, 3), lambda: RGB)
    assert looks.newest("cam/front") is None
    assert looks.held_streams() == frozenset()


def test_the_newest_is_decoded_once_and_only_when_asked_for() -> None:
    looks, decoded = FrameSource(), []
    looks.hold("cam/front")

    def decode() -> np.ndarray:
        decoded.append(1)
        return RGB

    for seq in (1, 2, 3):
        looks.offer_frame("cam/front", (seq, 10, 20), decode)
    assert decoded == []
    look = looks.newest("cam/front")
    assert look is not None
    assert (look.stream, look.seq, look.time_us, look.mono_us) == ("cam/front", 3, 10, 20)
    assert looks.newest("cam/front") is look
    assert decoded == [1]
    assert looks.newest("cam/front", after=3) is None


def test_who_waits_gets_the_next_one() -> None:
    looks = FrameSource()
    looks.hold("cam/front")
    got: list[object] = []
    asking = threading.Thread(
        target=lambda: got.append(looks.newest("cam/front", after=1, wait_s=30))
    )
    asking.start()
    looks.offer_frame("cam/front", (1, 0, 0), lambda: RGB)
    looks.offer_frame("cam/front", (2, 0, 0), lambda: RGB)
    asking.join(30)
    assert got
    assert got[0] is not None
    assert got[0].seq == 2  # type: ignore[attr-defined]


def test_camera_that_is_connected_anew_and_numbers_anew_is_seen_at_once() -> None:
    looks = FrameSource()
    looks.hold("cam/front")
    assert looks.arrived("cam/front") == 0
    looks.offer_frame("cam/front", (7, 10, 20), lambda: RGB)
    assert looks.arrived("cam/front") == 20
    assert looks.arrived("cam/front", since_us=20) == 0
    old = looks.newest("cam/front")
    looks.offer_frame("cam/front", (7, 11, 30), lambda: RGB + 1)
    assert looks.arrived("cam/front", since_us=20) == 30
    new = looks.newest("cam/front")
    assert old is not None
    assert new is not None
    assert (int(old.rgb.max()), int(new.rgb.max())) == (0, 1)


def test_a_stream_rests_once_all_have_let_go_of_it() -> None:
    told: list[frozenset[str]] = []
    looks = FrameSource(on_held=lambda: told.append(looks.held_streams()))
    first, second = looks.hold("cam/front"), looks.hold("cam/front")
    first()
    first()
    assert looks.held_streams() == {"cam/front"}
    second()
    assert told == [{"cam/front"}, frozenset()]


def test_a_picture_that_cannot_be_read_is_none() -> None:
    looks = FrameSource()
    looks.hold("cam/front")
    looks.offer_frame("cam/front", (1, 0, 0), lambda: None)
    assert looks.newest("cam/front") is None
