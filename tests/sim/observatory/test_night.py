"""An observatory stands where it is night, whatever time it is."""

from __future__ import annotations

from datetime import UTC, datetime
from pathlib import Path
from zoneinfo import ZoneInfo

import pytest
from hypothesis import given, strategies as st

from talaia.model.checks.site_checks import check_site
from talaia.model.units.astronomy import (
    Observer,
    equatorial_to_horizontal,
    julian_day,
    sun_position,
)
from talaia.model.yaml_text.load import read_site
from talaia.sim.observatory.night import at_night, longitude_of_night

pytestmark = pytest.mark.pure

SITE = read_site(Path(__file__).parents[3] / "examples" / "observatory" / "site.yaml")


@given(st.floats(946_684_800, 4_102_444_800))
def test_wherever_it_is_the_sun_is_down_and_its_clock_says_midnight(now: float) -> None:
    site = at_night(SITE, now)
    assert site.place is not None
    assert site.place.longitude == longitude_of_night(now)
    place = Observer(site.place.latitude, site.place.longitude)
    jd = julian_day(now)
    # At this latitude it stays light longest at midsummer.
    assert equatorial_to_horizontal(*sun_position(jd), place, jd).alt < -20
    clock = datetime.fromtimestamp(now, UTC).astimezone(ZoneInfo(site.zone))
    assert (clock.hour * 60 + clock.minute + 31) % 1440 <= 62


def test_a_site_that_was_moved_is_still_right() -> None:
    assert list(check_site(at_night(SITE, 1_795_270_000.0))) == []
