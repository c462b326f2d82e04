"""FITS headers as bytes, held against astropy's own reading and writing."""

import io
import math
import warnings

import numpy as np
import pytest
from astropy import units
from astropy.coordinates import FK5, SkyCoord
from astropy.io import fits
from astropy.time import Time
from hypothesis import given, settings, strategies as st
from many_examples import examples

from talaia.gateway.adapters.indi.fits_circumstances import precess_to_j2000
from talaia.gateway.fits.header import (
    BLOCK,
    HeaderCard,
    NotFits,
    length_of,
    rewrite_header,
    values_of,
)

ASCII = st.text(st.characters(min_codepoint=32, max_codepoint=126), max_size=60)
VALUES = st.one_of(
    ASCII, st.booleans(), st.integers(-(10**15), 10**15),
    st.floats(allow_nan=False, allow_infinity=False, min_value=-1e30, max_value=1e30),
)  # fmt: skip


def picture(**cards: object) -> bytes:
    hdu = fits.PrimaryHDU(np.arange(12, dtype=np.uint16).reshape(3, 4))
    for key, value in cards.items():
        hdu.header[key] = value
    out = io.BytesIO()
    hdu.writeto(out)
    return out.getvalue()


@settings(deadline=None, max_examples=examples(15, many=600))
@given(VALUES, ASCII)
def test_card_is_read_by_astropy_as_it_was_meant(value: object, comment: str) -> None:
    data = picture(OBJECT="M 31")
    length = length_of(data)
    whole = rewrite_header(
        data[:length], [HeaderCard("OBJECT", "other"), HeaderCard("NEW", value, comment)]
    )
    assert len(whole) % BLOCK == 0
    with warnings.catch_warnings():
        warnings.simplefilter("error")
        with fits.open(io.BytesIO(whole + data[length:])) as hdus:
            hdus.verify("exception")
            found = hdus[0].header["NEW"]
            assert hdus[0].header["OBJECT"] == "other"
            assert (hdus[0].data == np.arange(12).reshape(3, 4)).all()
    if isinstance(value, float):
        assert found == pytest.approx(value, rel=1e-11)
    elif isinstance(value, str):
        # A quote counts twice, and FITS knows no blanks at the end.
        assert value.rstrip().startswith(found.rstrip())
        assert len(found) == len(value.rstrip()) or len(found.replace("'", "''")) >= 60
    else:
        assert found == value
    assert values_of(whole)["OBJECT"] == "other"


def test_letters_that_fits_does_not_allow_are_spelled_out() -> None:
    data = picture()
    whole = rewrite_header(
        data[: length_of(data)], [HeaderCard("SITENAME", "Montsec, 1568 m µ°²\n日")]
    )
    assert values_of(whole)["SITENAME"] == "Montsec, 1568 m udeg2??"


def test_value_that_is_no_number_is_written_as_undefined() -> None:
    data = picture()
    whole = rewrite_header(
        data[: length_of(data)], [HeaderCard("A", math.nan), HeaderCard("B", None)]
    )
    assert values_of(whole)["A"] is None
    with fits.open(io.BytesIO(whole + data[length_of(data) :])) as hdus:
        assert hdus[0].header["A"] is None


def test_header_grows_over_its_block(tmp_path) -> None:
    data = picture()
    length = length_of(data)
    whole = rewrite_header(data[:length], [HeaderCard(f"KEY{at}", at) for at in range(80)])
    assert len(whole) == 3 * BLOCK
    with fits.open(io.BytesIO(whole + data[length:])) as hdus:
        assert hdus[0].header["KEY79"] == 79


@pytest.mark.parametrize("data", [b"\xff\xd8\xff\xe0 a jpeg it is, not FITS", b"<html>" * 20])
def test_what_is_not_fits_says_so(data: bytes) -> None:
    with pytest.raises(NotFits):
        length_of(data)


def test_header_without_an_end_is_waited_for_and_then_refused() -> None:
    begun = b"SIMPLE  =                    T".ljust(BLOCK)
    assert length_of(begun) is None
    with pytest.raises(NotFits):
        length_of(begun * 300)


@settings(deadline=None, max_examples=examples(30, many=300))
@given(st.floats(0, 359.9), st.floats(-89.0, 89.0), st.integers(2000, 2026))
def test_precession_agrees_with_astropy_to_a_fifth_of_an_arcsecond(
    ra: float, dec: float, year: int
) -> None:
    when = Time(f"{year}-11-21T00:00:00", scale="utc")
    of_date = SkyCoord(ra * units.deg, dec * units.deg, frame=FK5(equinox=when))
    theirs = of_date.transform_to(FK5(equinox="J2000"))
    ours = precess_to_j2000(ra, dec, when.unix)
    apart = theirs.separation(SkyCoord(*ours, unit="deg", frame=FK5(equinox="J2000")))
    assert apart.arcsec < 0.2
