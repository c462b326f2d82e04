"""A real indiserver for one test each."""

from __future__ import annotations

import sys
from pathlib import Path
from typing import TYPE_CHECKING

import pytest

sys.path.insert(0, str(Path(__file__).parent))  # test modules are imported by path

from indi_server import server_of

if TYPE_CHECKING:
    from collections.abc import Callable


@pytest.fixture
def indi(tmp_path: Path) -> Callable[..., object]:
    """Give `server_of` for this test's own folder."""
    return lambda *drivers: server_of(tmp_path, *drivers)
