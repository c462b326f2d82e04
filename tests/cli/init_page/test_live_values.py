"""What the page of `talaia init --web` shows of a robot: its newest values and pictures."""

from __future__ import annotations

from collections.abc import Collection

import pytest
from described_robot import found_of, read_robot

from talaia.cli.init_page.live_values import LiveValues
from talaia.clock import SECOND, HandClock
from talaia.model.discovery.generate_description import propose_description
from talaia.wire.frames import PictureForm, PictureFrame

pytestmark = pytest.mark.pure

SITE = propose_description(found_of(read_robot("chosen", "two_arms")), "duo", "Duo", "UTC").site
COLOR = "head_camera/color"


def picture(data: bytes) -> PictureFrame:
    return PictureFrame(
        stream=COLOR, seq=1, time_us=0, mono_us=0, width=4, height=3, forms=[], data=data
    )


def test_a_camera_is_read_from_when_the_page_first_asks_for_its_picture() -> None:
    values = LiveValues(SITE, HandClock())
    watched: list[Collection[str]] = []
    values.on_asked = watched.append
    assert values.picture_of(COLOR) is None
    values.offer(picture(b"one"))
    assert values.picture_of(COLOR) == b"one"
    assert watched == [{COLOR}]
    # What is no camera of the robot is asked of nobody.
    assert values.picture_of("head_camera/../x") is None
    assert watched == [{COLOR}]


def test_a_picture_is_made_once_a_second_while_the_page_asks() -> None:
    clock = HandClock(monotonic_ns=SECOND)
    values = LiveValues(SITE, clock)
    assert values.asked(COLOR) == ()
    values.picture_of(COLOR)
    assert values.asked(COLOR) == (PictureForm.JPEG_SMALL,)
    values.offer(picture(b"one"))
    assert values.asked(COLOR) == ()
    clock.advance(2 * SECOND)
    assert values.asked(COLOR) == (PictureForm.JPEG_SMALL,)
    # The page was closed.
    clock.advance(20 * SECOND)
    assert values.asked(COLOR) == ()
