"""What of a site its watchdog needs."""

from __future__ import annotations

from pathlib import Path

import pytest

from talaia.gateway.watchdog.closing_site import closing_site
from talaia.model.yaml_text.load import load_site

pytestmark = pytest.mark.pure
EXAMPLE = Path(__file__).parents[3] / "examples" / "observatory" / "site.yaml"


def test_a_roof_is_closed_without_waiting_for_what_only_the_night_goes_by() -> None:
    site = load_site(EXAMPLE.read_text())
    # The night sets the camera's gain and goes by its reading; no roof does.
    assert "camera/gain" in site.safety_signals()
    closing = closing_site(site)
    assert closing.night is None
    assert set(closing.devices) == {"dome", "telescope", "camera"}
    assert closing.safety_signals() == {
        "dome/closed",
        "dome/shutter",
        "dome/position",
        "telescope/state",
    }
