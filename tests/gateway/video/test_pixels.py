"""Every encoding of an image: its colours keep their places, and what is not so is refused."""

from __future__ import annotations

from types import SimpleNamespace as Message

import numpy as np
import pytest
from hypothesis import given, settings, strategies as st
from many_examples import examples

from talaia.gateway.errors import FieldError
from talaia.gateway.video.jpeg import jpeg_of, jpeg_size, pixels_in
from talaia.gateway.video.pixels import ENCODINGS, pixels_of, rgb_of, thin_pixels

from .scenes import packed, planes_of, psnr, scene

GREY = {"mono8", "mono16", "8UC1"}
DEPTH = {"16UC1", "32FC1"}
IN_COLOUR = sorted(ENCODINGS.keys() - GREY - DEPTH)
EXACT = {each for each in IN_COLOUR if each.startswith(("rgb", "bgr", "8UC"))}


@pytest.mark.parametrize("encoding", IN_COLOUR)
@given(pad=st.integers(0, 9), big=st.booleans(), turn=st.integers(0, 50))
@settings(max_examples=examples(12, many=120), deadline=None)
def test_every_encoding_gives_the_picture_that_was_put_in(
    encoding: str, pad: int, turn: int, *, big: bool
) -> None:
    sent = scene(turn=turn)
    seen = rgb_of(pixels_of(packed(sent, encoding, pad, big=big)))
    assert seen.shape == sent.shape
    assert psnr(seen, sent) > (60 if encoding in EXACT else 32)


@pytest.mark.parametrize("encoding", sorted(GREY))
@pytest.mark.parametrize("big", [False, True])
def test_grey_stays_grey(encoding: str, *, big: bool) -> None:
    sent = scene()
    seen = rgb_of(pixels_of(packed(sent, encoding, 3, big=big)))
    assert (seen == planes_of(sent)[0][:, :, None]).all()


@pytest.mark.parametrize("encoding", sorted(DEPTH))
@pytest.mark.parametrize("big", [False, True])
def test_what_is_near_is_bright_and_what_is_nowhere_is_black(encoding: str, *, big: bool) -> None:
    sent = scene()
    sent[:10, :10] = 0
    message = packed(sent, encoding, big=big)
    rows = message.data.reshape(48, -1)
    rows[:10, : 10 * rows.shape[1] // 64] = 0
    seen = rgb_of(pixels_of(message))[:, :, 0].astype(int)
    far = planes_of(sent)[0].astype(int)
    assert (seen[:10, :10] == 0).all()
    assert seen[10:].min() >= 32
    assert np.corrcoef(seen[10:].ravel(), far[10:].ravel())[0, 1] < -0.98


def test_distances_that_are_no_numbers_are_black() -> None:
    data = np.array([[np.nan, np.inf, -1.0, 2.0]], "<f4").view(np.uint8).ravel()
    image = Message(height=1, width=4, encoding="32FC1", step=16, is_bigendian=0, data=data)
    assert pixels_of(image).data.ravel().tolist()[:3] == [0, 0, 0]


@given(
    encoding=st.sampled_from([*sorted(ENCODINGS), "yuv9", ""]),
    width=st.integers(0, 70),
    height=st.integers(0, 70),
    step=st.integers(0, 300),
    data=st.binary(max_size=6000),
    big=st.booleans(),
)
@settings(max_examples=examples(100, many=4000), deadline=None)
def test_any_image_is_read_or_refused_in_words(
    encoding: str, width: int, height: int, step: int, data: bytes, *, big: bool
) -> None:
    image = Message(
        encoding=encoding, width=width, height=height, step=step, data=data, is_bigendian=big
    )
    try:
        pixels = pixels_of(image)
    except FieldError:
        return
    assert rgb_of(pixels).shape == (height, width, 3)
    small = thin_pixels(pixels, 20)
    assert small.width <= max(20, 1)


@pytest.mark.parametrize(
    ("change", "word"),
    [
        ({"encoding": "yuv9"}, "not known here"),
        ({"step": 3}, "too short"),
        ({"height": 900}, "cut off"),
        ({"width": 0, "step": 0}, "empty"),
        ({"width": 2**20, "height": 2**20, "step": 0}, "more than"),
    ],
)
def test_picture_that_is_not_what_it_says_is_refused_in_words(change: dict, word: str) -> None:
    broken = Message(**(vars(packed(scene(), "rgb8")) | change))
    with pytest.raises(FieldError, match=word):
        jpeg_of(broken, 70, 0)


def test_wide_picture_is_made_smaller_by_a_whole_number() -> None:
    assert jpeg_of(packed(scene(16, 8), "rgb8"), 70, 10)[1:] == (8, 4)
    assert jpeg_of(packed(scene(16, 8), "yuyv"), 70, 10)[1:] == (8, 4)


def test_a_camera_s_own_jpeg_passes_and_one_that_is_cut_off_does_not() -> None:
    whole = jpeg_of(packed(scene(), "bgr8"), 90, 0)[0]
    assert jpeg_size(Message(format="jpeg", data=whole)) == (whole, 64, 48)
    padded = whole + bytes(300)
    assert jpeg_size(Message(format="jpeg", data=padded))[0] == padded
    assert psnr(pixels_in(whole).data, scene()) > 32
    with pytest.raises(FieldError, match="cut off"):
        jpeg_size(Message(format="jpeg", data=whole[:-40]))
    with pytest.raises(FieldError, match="no JPEG"):
        jpeg_size(Message(format="webp", data=b"RIFF1234WEBP"))
    with pytest.raises(FieldError, match="cannot be decoded"):
        pixels_in(whole[:200])
