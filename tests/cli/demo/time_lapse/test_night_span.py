"""When the nights of a time lapse begin and end."""

from __future__ import annotations

import pytest
from hypothesis import given, strategies as st

from talaia.cli.demo.time_lapse.night_span import DAWN, DUSK, next_night
from talaia.gateway.night.target_place import sun_altitude
from talaia.model.interlocks.enclosure import Place

pytestmark = pytest.mark.pure
NOW = 1_795_647_600.0  # 2026-11-25 23:00 UTC


@given(st.floats(-60, 60), st.floats(-180, 180))
def test_a_night_begins_with_the_next_dusk_and_ends_at_dawn(
    latitude: float, longitude: float
) -> None:
    place = Place(latitude=latitude, longitude=longitude, elevation=0.0)
    night = next_night(place, NOW)
    assert NOW < night.begins < night.ends < night.begins + 86_400.0
    assert sun_altitude(place, night.begins) == pytest.approx(DUSK, abs=0.5)
    assert sun_altitude(place, night.ends) == pytest.approx(DAWN, abs=0.5)
    following = next_night(place, night.ends)
    assert following.begins > night.ends


def test_of_a_long_night_only_the_last_hours_are_lived_through_if_wanted() -> None:
    place = Place(latitude=42.0, longitude=0.0, elevation=0.0)
    whole, part = next_night(place, NOW), next_night(place, NOW, hours=2.0)
    assert part == (whole.ends - 7200.0, whole.ends)
    assert next_night(place, NOW, hours=24.0) == whole
