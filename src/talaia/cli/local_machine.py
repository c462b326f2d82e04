"""Where things are on this machine: a free port, a screen with a browser, a folder for data."""

from __future__ import annotations

import os
import socket
import sys
import webbrowser
from pathlib import Path

from talaia.cli.errors import CliError
from talaia.model.units.time_zones import known_zones

__all__ = ["DEFAULT_PORT", "data_folder", "free_port", "has_screen", "open_page", "zone_here"]

DEFAULT_PORT = 8470


def free_port(wanted: int, host: str = "127.0.0.1") -> int:
    """Give the wanted port, or with 0 the first free one from the usual one on.

    Raises:
        CliError: it is taken.

    """
    family = socket.AF_INET6 if ":" in host else socket.AF_INET
    for port in [wanted] if wanted else range(DEFAULT_PORT, DEFAULT_PORT + 50):
        with socket.socket(family) as probe:
            # A port whose last connection is still in TIME_WAIT is free.
            probe.setsockopt(socket.SOL_SOCKET, socket.SO_REUSEADDR, 1)
            try:
                probe.bind((host, port))
            # Python raises the second for a port above 65535.
            except (OSError, OverflowError):
                continue
            return port
    raise CliError(f"port {wanted} is taken; choose another with --port" if wanted else "no port")


def has_screen() -> bool:
    """Tell whether a browser could be seen here."""
    # A Mac always has one; elsewhere X11 or Wayland leaves its variable.
    return sys.platform == "darwin" or bool(
        os.environ.get("DISPLAY") or os.environ.get("WAYLAND_DISPLAY")
    )


def open_page(address: str) -> None:
    """Open the browser without the library path that the ROS wheels need and it must not have."""
    # Of this process, for `webbrowser` gives no way to set that of the browser.
    kept = os.environ.pop("LD_LIBRARY_PATH", None)
    try:
        webbrowser.open(address)
    finally:
        if kept is not None:
            os.environ["LD_LIBRARY_PATH"] = kept


def data_folder(site: str) -> Path:
    """Give the folder where a site's accounts and history are kept for this user."""
    # An empty variable counts as unset, as the XDG specification has it.
    base = os.environ.get("XDG_DATA_HOME") or "~/.local/share"
    return Path(base).expanduser() / "talaia" / site


def zone_here() -> str:
    """Give this machine's time zone by its IANA name; UTC where it cannot be told."""
    # A colon may stand before the name (POSIX).
    named = os.environ.get("TZ", "").lstrip(":")
    if not named:
        target = Path("/etc/localtime").resolve()
        # The link leads to /usr/share/zoneinfo/Europe/Madrid: what follows is the name.
        parts = target.parts
        if "zoneinfo" in parts:
            named = "/".join(parts[parts.index("zoneinfo") + 1 :])
    # Etc/UTC and UTC are one zone; a name that no list has would be refused in the description.
    return named.removeprefix("Etc/") if named in known_zones() else "UTC"
