"""The observatory of the time lapse is that of the demo once more."""

from __future__ import annotations

from pathlib import Path

import pytest

from talaia.cli.demo.time_lapse.lapse_site import lapse_site
from talaia.gateway.night.target_place import sun_altitude
from talaia.model.checks.site_checks import check_site
from talaia.model.yaml_text.load import load_site

pytestmark = pytest.mark.pure
EXAMPLE = Path(__file__).parents[4] / "examples" / "observatory" / "site.yaml"
NOW = 1_795_647_600.0  # 2026-11-25 23:00 UTC


def test_it_is_checked_as_any_other_and_says_in_its_name_that_its_time_is_not_ours() -> None:
    site = lapse_site(load_site(EXAMPLE.read_text()), NOW)
    assert check_site(site) == []
    assert site.name.endswith("(time lapse)")
    assert not any(device.streams for device in site.devices.values())


@pytest.mark.parametrize("hour", range(0, 24, 3))
def test_it_stands_where_evening_begins(hour: int) -> None:
    now = NOW + hour * 3600.0
    site = lapse_site(load_site(EXAMPLE.read_text()), now)
    assert site.place is not None
    assert -15.0 < sun_altitude(site.place, now) < 5.0
    assert sun_altitude(site.place, now + 3600.0) < sun_altitude(site.place, now)
