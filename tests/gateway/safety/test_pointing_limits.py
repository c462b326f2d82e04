"""Where the gateway lets nobody point a telescope."""

from __future__ import annotations

import pytest
from hypothesis import given, strategies as st

from talaia.clock import SECOND
from talaia.gateway.safety.pointing_limits import pointing_problem
from talaia.model.interlocks.enclosure import Place, Pointing, PointingArguments
from talaia.model.units import astronomy

pytestmark = pytest.mark.pure

PLACE = Place(latitude=42.05, longitude=0.73)
RULE = Pointing(commands={}, horizon=15, sun=30)
SKY = PointingArguments(ra="ra", dec="dec")
HORIZON = PointingArguments(alt="alt", az="az")
NOON = 1_795_262_400  # 2026-11-21 12:00 UTC


def test_a_target_below_the_limit_is_refused_with_its_altitude() -> None:
    said = pointing_problem(
        rule=RULE, names=HORIZON, args={"alt": 10, "az": 100}, place=PLACE, wall_ns=NOON * SECOND
    )
    assert said == "the target stands at 10.0 °; the horizon limit is 15 °"


def test_the_sun_is_refused_by_day_and_where_it_was_is_free_by_night() -> None:
    here = astronomy.Observer(PLACE.latitude, PLACE.longitude)
    sun = astronomy.equatorial_to_horizontal(
        *astronomy.sun_position(astronomy.julian_day(NOON)), here, astronomy.julian_day(NOON)
    )
    args = {"alt": sun.alt + 5, "az": sun.az}
    assert "from the Sun; the limit is 30 °" in pointing_problem(
        rule=RULE, names=HORIZON, args=args, place=PLACE, wall_ns=NOON * SECOND
    )
    assert (
        pointing_problem(
            rule=RULE, names=HORIZON, args=args, place=PLACE, wall_ns=(NOON + 10 * 3600) * SECOND
        )
        == ""
    )


@pytest.mark.parametrize(
    ("args", "said"),
    [
        ({"ra": 25.0, "dec": 0.0}, "RA 25 h: expected 0 to 24 h"),
        ({"ra": 1.0, "dec": -91.0}, "Dec -91 °: expected -90 to 90 °"),
        ({"ra": float("nan"), "dec": 0.0}, "the argument 'ra' does not say where to point"),
        ({"ra": True, "dec": 0.0}, "the argument 'ra' does not say where to point"),
        ({"dec": 0.0}, "the argument 'ra' does not say where to point"),
    ],
)
def test_what_is_no_place_in_the_sky_is_refused(args: dict[str, float], said: str) -> None:
    assert (
        pointing_problem(rule=RULE, names=SKY, args=args, place=PLACE, wall_ns=NOON * SECOND)
        == said
    )


@given(st.floats(0, 23.99), st.floats(-90, 90), st.integers(0, 365 * 24))
def test_what_is_let_through_is_above_the_limit_and_away_from_the_sun(
    ra: float, dec: float, hour: int
) -> None:
    now = NOON + hour * 3600
    if pointing_problem(
        rule=RULE, names=SKY, args={"ra": ra, "dec": dec}, place=PLACE, wall_ns=now * SECOND
    ):
        return
    here, jd = astronomy.Observer(PLACE.latitude, PLACE.longitude), astronomy.julian_day(now)
    at, sun = (
        astronomy.equatorial_to_horizontal(ra, dec, here, jd),
        astronomy.equatorial_to_horizontal(*astronomy.sun_position(jd), here, jd),
    )
    assert at.alt >= 15
    assert sun.alt <= -6 or astronomy.angular_separation(at, sun) >= 30
