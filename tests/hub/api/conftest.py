"""What several tests of the API start from."""

from __future__ import annotations

import pytest

from talaia.hub.api import rate_limits


@pytest.fixture(scope="module")
def unhurried():
    """Let a person ask as fast as they can, of hubs that are started after this."""
    with pytest.MonkeyPatch.context() as patch:
        patch.setattr(rate_limits, "RATES", {})
        patch.setattr(rate_limits, "ANY", rate_limits.Rate(burst=10**6, per_s=10**6))
        yield
