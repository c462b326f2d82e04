"""ImageBytes and JSON as FITS, judged by astropy."""

from __future__ import annotations

import contextlib
import io
import json
import struct

import numpy as np
import pytest
from astropy.io import fits
from hypothesis import given, strategies as st
from stand_in import image_bytes

from talaia.gateway.adapters.alpaca.camera_pictures import header_cards
from talaia.gateway.adapters.alpaca.pictures import fits_of, pixels_of
from talaia.gateway.adapters.alpaca.protocol import AlpacaRefused
from talaia.gateway.errors import FieldError

# Three columns of two: x runs first.
COLUMNS = [[0, 1], [10, 11], [65_535, 21]]


@pytest.mark.parametrize("kind", [8, 2])
def test_a_picture_keeps_its_pixels_and_its_rows(kind: int) -> None:
    whole = fits_of(pixels_of(image_bytes(COLUMNS, kind=kind)), [])
    with fits.open(io.BytesIO(whole)) as opened:
        opened.verify("exception")
        assert opened[0].data.tolist() == [[0, 10, 65_535], [1, 11, 21]]
        assert opened[0].header["BITPIX"] == 16
        assert opened[0].header["ROWORDER"] == "TOP-DOWN"
    assert len(whole) % 2880 == 0


def test_a_server_without_imagebytes_gives_the_same_as_json() -> None:
    said = json.dumps({"Type": 2, "Rank": 2, "Value": COLUMNS, "ErrorNumber": 0}).encode()
    assert pixels_of(said).tolist() == pixels_of(image_bytes(COLUMNS)).tolist()


def test_colours_become_planes_and_numbers_below_zero_stay() -> None:
    cube = np.arange(2 * 3 * 3).reshape(2, 3, 3)
    pixels = pixels_of(json.dumps({"Value": cube.tolist()}).encode())
    with fits.open(io.BytesIO(fits_of(pixels, []))) as opened:
        assert opened[0].data.shape == (3, 3, 2)
        assert opened[0].data[1, 2, 0] == cube[0, 2, 1]
    deep = pixels_of(json.dumps({"Value": [[-5, 70_000]]}).encode())
    with fits.open(io.BytesIO(fits_of(deep, []))) as opened:
        assert opened[0].data.ravel().tolist() == [-5, 70_000]


def test_an_error_in_a_picture_is_the_cameras() -> None:
    said = struct.pack("<iiIIiiiiiii", 1, 0x40B, 1, 1, 44, 0, 0, 0, 0, 0, 0) + b"no picture yet"
    with pytest.raises(AlpacaRefused, match="no picture yet"):
        pixels_of(said)


@given(st.binary(max_size=120), st.lists(st.integers(-2, 70_000), min_size=11, max_size=11))
def test_any_bytes_are_a_picture_or_a_problem(data: bytes, numbers: list[int]) -> None:
    head = struct.pack("<iiIIiiiiiii", 1, 0, *(abs(n) for n in numbers[:2]), 44, *numbers[2:8])
    for said in (data, head + data, image_bytes(COLUMNS)[: len(data)]):
        with contextlib.suppress(FieldError, AlpacaRefused):
            assert pixels_of(said).size


def test_a_header_says_what_mount_filter_and_asker_say() -> None:
    scene: dict[str, object] = {
        "camera/name": "ASI",
        "camera/ccdtemperature": -10.0,
        "camera/binx": 2,
        "camera/pixelsizex": 3.8,
        "filterwheel/names": ["R", "G"],
        "filterwheel/position": 1,
        "telescope/rightascension": 1.0,
        "telescope/declination": 45.0,
        "telescope/equatorialsystem": 1,
    }
    asked = {"OBJECT": "M 31"}
    cards = header_cards({"Duration": 2.0, "Light": False}, asked, scene, 1_700_000_000 * 10**9)
    with fits.open(io.BytesIO(fits_of(np.zeros((2, 2), np.uint16), cards))) as opened:
        header = opened[0].header
    assert (header["OBJECT"], header["FILTER"], header["IMAGETYP"]) == ("M 31", "G", "Dark")
    assert (header["RA"], header["RADESYS"], "EQUINOX" in header) == (15.0, "GAPPT", False)
    assert header["XPIXSZ"] == 7.6
    assert header["DATE-OBS"] == "2023-11-14T22:13:20.000"


def test_what_the_asker_says_of_a_frame_stands_once_and_wins() -> None:
    cards = header_cards({"Duration": 2.0, "Light": True}, {"IMAGETYP": "Flat"}, {}, 0)
    assert [card.value for card in cards if card.key == "IMAGETYP"] == ["Flat"]
