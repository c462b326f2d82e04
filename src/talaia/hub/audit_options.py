"""Options of ``talaia hub`` that say where signed heads of the audit log go."""

from __future__ import annotations

import argparse
import math
import re
from pathlib import Path

__all__ = ["add_audit_options"]

# One address and nothing that could be a second one, or a header.
_ADDRESS = re.compile(r"[^\s\x00-\x1f\x7f<>(),:;\"\\@]{1,64}@[A-Za-z0-9.\-]{1,190}\Z")
# Heads are made once an hour: a mail more often would be empty.
_LEAST_H = 1.0


def add_audit_options(parser: argparse.ArgumentParser) -> None:
    """Let a parser read what begins with ``audit_``: heads, syslog, mail, mail_hours, hub."""
    parser.add_argument(
        "--audit-heads",
        type=Path,
        action="append",
        default=[],
        metavar="FILE",
        help="signed heads of the audit log are appended to it every hour: a file on another"
        " machine or on a medium that is only appended to; may repeat",
    )
    parser.add_argument(
        "--audit-syslog",
        action="store_true",
        help="they go to the machine's log, too, and with it to a log server",
    )
    parser.add_argument(
        "--audit-mail",
        type=_read_address,
        metavar="ADDRESS",
        help="they are mailed there, too, as an attached file, by the mail server of the hub's"
        " notifications (the one that was set up first)",
    )
    parser.add_argument(
        "--audit-mail-hours",
        type=_read_hours,
        default=24.0,
        metavar="HOURS",
        help="at most one such mail in this time, with all heads since the last (24; at least 1)",
    )
    parser.add_argument(
        "--audit-hub",
        type=Path,
        metavar="FILE",
        help="names another hub that keeps them, too, and the token that it gave for this one",
    )


def _read_address(text: str) -> str:
    if not _ADDRESS.match(text):
        raise argparse.ArgumentTypeError(
            f"{text!r} is no mail address; write one, like audit@example.org"
        )
    return text


def _read_hours(text: str) -> float:
    try:
        hours = float(text)
    except ValueError:
        hours = math.nan
    # Also refuses what is not a number, which no comparison holds for.
    if not _LEAST_H <= hours < math.inf:
        raise argparse.ArgumentTypeError(f"{text!r} is no number of hours of at least 1")
    return hours
