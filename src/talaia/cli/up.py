"""The words of ``talaia up``, before anything is imported that runs a site.

So ``--help`` and wrong words are answered at once.
"""

from __future__ import annotations

import argparse
from pathlib import Path
from typing import TYPE_CHECKING

from talaia.cli.local_machine import DEFAULT_PORT
from talaia.gateway.accepted_changes import AcceptedChanges

if TYPE_CHECKING:
    from collections.abc import Sequence

__all__ = ["main", "parse_words"]


def main(argv: Sequence[str]) -> int:
    """Run until Ctrl-C; what was stored stays for the next time."""
    options = parse_words(argv)
    # The whole model and the hub's accounts: a second of a core.
    from talaia.cli.local_site.run_site import run_site

    return run_site(options)


def parse_words(argv: Sequence[str]) -> argparse.Namespace:
    """Read the options; wrong words and ``--help`` end the process."""
    parser = argparse.ArgumentParser(
        "talaia up",
        description="Start the hub and the gateway of a site on this machine, and open the "
        "dashboard. Accounts and history are kept between runs.",
    )
    parser.add_argument("site", type=Path, help="site description (YAML)")
    parser.add_argument(
        "--port", type=int, default=0, help=f"of the dashboard (default: {DEFAULT_PORT} or next)"
    )
    parser.add_argument(
        "--host",
        default="127.0.0.1",
        help="address to listen on; other than loopback only with TLS, which is then on "
        "(default: 127.0.0.1)",
    )
    parser.add_argument("--data", type=Path, help="folder of accounts and history")
    parser.add_argument("--no-browser", action="store_true", help="only print the address")
    parser.add_argument(
        "--accept-changes",
        type=AcceptedChanges,
        choices=list(AcceptedChanges),
        default=AcceptedChanges.READINGS,
        metavar="{no,readings,all}",
        help="what admins may change of the description in the dashboard: nothing, what is read "
        "and shown, or also commands, driving and interlocks (default: readings)",
    )
    return parser.parse_args(argv)
