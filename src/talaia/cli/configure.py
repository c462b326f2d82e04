"""``talaia configure``: the window that makes a site description and starts everything."""

from __future__ import annotations

import argparse
import os
import sys
from pathlib import Path
from typing import TYPE_CHECKING

from talaia.cli.errors import CliError, PartMissing
from talaia.cli.local_machine import has_screen, open_page, zone_here

if TYPE_CHECKING:
    from collections.abc import Sequence

__all__ = ["main"]

# What Qt's window needs of a Debian or Ubuntu without a desktop.
_LIBRARIES = "libegl1 libgl1 libxkbcommon-x11-0 libxcb-cursor0 libdbus-1-3 libfontconfig1"


def main(argv: Sequence[str]) -> int:
    """Show the window until it is closed.

    Raises:
        PartMissing: there is no PySide6 here.
        CliError: there is no screen, or Qt's libraries are missing.

    """
    options = _parse_options(argv)
    # Before Qt, which takes a while and may be missing.
    if options.site is not None and not options.site.is_file():
        raise CliError(f"{options.site}: there is no such file")
    try:
        from talaia.configurator.qt.app import run_window
        from talaia.configurator.qt.window import Means
    # The package is missing; below, it is there, and a library of the system is not.
    except ModuleNotFoundError as error:
        raise PartMissing("talaia configure", error.name or "PySide6", "configurator") from error
    except ImportError as error:
        raise CliError(
            f"Qt cannot be loaded ({error}); on Debian or Ubuntu run: sudo apt install {_LIBRARIES}"
        ) from error
    # Without a screen Qt would end the process with a core dump.
    if not has_screen() and not os.environ.get("QT_QPA_PLATFORM"):
        raise CliError(
            "there is no screen here (DISPLAY and WAYLAND_DISPLAY are not set); run it on a "
            "desktop, and let it find the robot over ssh"
        )
    talaia = (sys.executable, "-m", "talaia")
    return run_window(Means(talaia, zone_here(), open_page, options.data), options.site)


def _parse_options(argv: Sequence[str]) -> argparse.Namespace:
    parser = argparse.ArgumentParser(
        "talaia configure",
        description="Make or change a site description in a window, find what a robot offers, "
        "start hub and gateway, and open the dashboard.",
    )
    parser.add_argument("site", type=Path, nargs="?", help="site description (YAML) to open")
    parser.add_argument(
        "--data", default="", metavar="DIR", help="folder of accounts and history, as talaia up's"
    )
    return parser.parse_args(argv)
