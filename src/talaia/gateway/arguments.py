"""The gateway's command line: words to settings."""

from __future__ import annotations

import argparse
import os
from pathlib import Path
from typing import TYPE_CHECKING, NoReturn

from talaia.gateway.errors import SettingsError
from talaia.gateway.settings import HubAddress, Settings

if TYPE_CHECKING:
    from collections.abc import Sequence

    from talaia.model.site import Site

__all__ = ["parsed", "settings_of"]


class _Parser(argparse.ArgumentParser):
    def error(self, message: str) -> NoReturn:
        self.exit(2, f"talaia gateway: {message}\n")


def parsed(argv: Sequence[str]) -> argparse.Namespace:
    """Read the words; a mistake ends the process with 2 and one line."""
    parser = _Parser(prog="talaia gateway", description="Run the gateway beside a robot.")
    parser.add_argument("site", type=Path, help="site description (YAML)")
    parser.add_argument("--hub", required=True, metavar="URL", help="wss://host:port")
    parser.add_argument("--key-file", required=True, type=Path, metavar="FILE")
    trust = parser.add_mutually_exclusive_group()
    trust.add_argument("--fingerprint", default="", metavar="HEX", help="SHA-256 of the hub's cert")
    trust.add_argument("--ca", type=Path, metavar="FILE", help="certificate authorities (PEM)")
    parser.add_argument("--allow-plain", action="store_true", help="permit ws:// on loopback")
    parser.add_argument("--data", type=Path, metavar="DIR", help="what must survive a restart")
    parser.add_argument(
        "--spool-mb", type=_positive, default=1024, metavar="N",
        help="most disk for samples that wait for the hub (MB; the oldest give way)",
    )  # fmt: skip
    parser.add_argument(
        "--spool-days", type=_positive, default=14, metavar="N",
        help="longest that samples wait for the hub",
    )  # fmt: skip
    parser.add_argument("--ros-domain", type=int, metavar="N", help="overrides the description's")
    parser.add_argument("--verbose", action="store_true", help="log more")
    return parser.parse_args(argv)


def _positive(text: str) -> float:
    number = float(text)
    if not 0 < number < 1e9:
        raise argparse.ArgumentTypeError(f"{text} is not a number over 0")
    return number


def settings_of(arguments: argparse.Namespace, site: Site) -> Settings:
    """Make settings of the words.

    Raises:
        SettingsError: a key file that holds no key, an address that is none.

    """
    try:
        key = arguments.key_file.read_text().strip()
    except (OSError, UnicodeDecodeError) as error:
        raise SettingsError(f"--key-file {arguments.key_file}: {error}") from error
    if not key or any(ord(each) <= 32 or ord(each) > 126 for each in key):
        raise SettingsError(f"--key-file {arguments.key_file}: expected the key on one line")
    state = os.environ.get("XDG_STATE_HOME") or str(Path.home() / ".local" / "state")
    return Settings(
        hub=HubAddress.checked(
            arguments.hub,
            fingerprint=arguments.fingerprint,
            ca=arguments.ca,
            allow_plain=arguments.allow_plain,
        ),
        key=key,
        data=arguments.data or Path(state) / "talaia" / "gateway" / site.site,
        domain=arguments.ros_domain,
        spool_bytes=round(arguments.spool_mb * 1024 * 1024),
        spool_age_s=arguments.spool_days * 86400.0,
    )
