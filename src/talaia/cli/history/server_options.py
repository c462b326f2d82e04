"""The option that names servers of histories, for commands that open them."""

from __future__ import annotations

import os
from pathlib import Path
from typing import TYPE_CHECKING

if TYPE_CHECKING:
    import argparse

__all__ = ["add_history_servers"]

# As the hub reads it.
_VARIABLE = "TALAIA_HUB_HISTORY_SERVERS"


def add_history_servers(parser: argparse.ArgumentParser) -> None:
    """Add it; where it is not given, the hub's own variable counts."""
    said = os.environ.get(_VARIABLE, "")
    parser.add_argument(
        "--history-servers",
        type=Path,
        default=Path(said) if said else None,
        metavar="FILE",
        help=f"names databases for histories, as for the hub ({_VARIABLE})",
    )
