"""How hub and gateway write their logs: lines for people, JSON, or fields for systemd's journal."""

from __future__ import annotations

import json
import logging
import os
import sys
import time
from typing import TYPE_CHECKING

from talaia import __version__
from talaia.journal import JOURNAL_SOCKET, JournalHandler, is_journal_stream

if TYPE_CHECKING:
    import argparse
    from collections.abc import Callable

__all__ = ["LOG_LEVELS", "add_log_field", "add_log_options", "set_up_log"]

LOG_LEVELS = ("debug", "info", "warning", "error")
_NUMBERS = {level: logging.getLevelNamesMapping()[level.upper()] for level in LOG_LEVELS}


def add_log_options(parser: argparse.ArgumentParser) -> None:
    """Let a parser read ``--log-level`` and ``--log-format``."""
    parser.add_argument(
        "--log-level",
        choices=LOG_LEVELS,
        default="info",
        help="least level of the log (info); debug of Talaia alone",
    )
    parser.add_argument(
        "--log-format",
        choices=("auto", "text", "json", "journal"),
        default="auto",
        help="lines for people, an object of JSON in each line, or entries of systemd's journal "
        "with their fields (auto: journal where a unit's stderr leads there, else text)",
    )


def set_up_log(
    level: str, form: str, mask: Callable[[str], str] = str, *, program: str = ""
) -> None:
    """Write the log to stderr, or to systemd's journal.

    Args:
        level: one of `LOG_LEVELS`.
        form: ``auto``, ``text``, ``json`` or ``journal``.
        mask: takes out of each line what is nobody's to read.
        program: ``hub`` or ``gateway``; the journal has it as ``TALAIA_PROGRAM``.

    """
    handler: logging.Handler
    if form == "journal" or (form == "auto" and _leads_to_journal()):
        fields = {
            "SYSLOG_IDENTIFIER": f"talaia-{program}" if program else "talaia",
            "TALAIA_PROGRAM": program,
            "TALAIA_VERSION": __version__,
        }
        handler = JournalHandler(fields, mask)
    else:
        handler = logging.StreamHandler()
        handler.setFormatter(_JsonFormatter(mask) if form == "json" else _TextFormatter(mask))
    # What libraries say to their own developers is too much, and holds values that are nobody's to
    # read: a database's says each one that it stores.
    logging.basicConfig(level=max(logging.INFO, _NUMBERS[level]), handlers=[handler])
    if _NUMBERS[level] < logging.INFO:
        logging.getLogger("talaia").setLevel(_NUMBERS[level])


def add_log_field(name: str, value: str) -> None:
    """Add a field to all that goes to the journal from now on; elsewhere nothing changes."""
    for handler in logging.getLogger().handlers:
        if isinstance(handler, JournalHandler):
            handler.fields[name] = value


def _leads_to_journal() -> bool:
    # The process's own stderr: a service manager has given it, whatever stands there now.
    if sys.__stderr__ is None or not os.path.exists(JOURNAL_SOCKET):
        return False
    try:
        return is_journal_stream(os.environ, sys.__stderr__.fileno())
    # It has none any more.
    except (OSError, ValueError):
        return False


class _TextFormatter(logging.Formatter):
    """A line for people."""

    def __init__(self, mask: Callable[[str], str]) -> None:
        super().__init__("%(asctime)s %(levelname)s %(name)s: %(message)s")
        self._mask = mask

    def format(self, record: logging.LogRecord) -> str:
        """Write a record, its traceback too, with each secret masked."""
        return self._mask(super().format(record))


class _JsonFormatter(logging.Formatter):
    """One object of JSON in each line; times are UTC."""

    def __init__(self, mask: Callable[[str], str]) -> None:
        super().__init__()
        self._mask = mask

    def format(self, record: logging.LogRecord) -> str:
        """Write a record, its traceback too, with each secret masked."""
        moment = time.gmtime(record.created)
        row: dict[str, object] = {
            "time": f"{time.strftime('%Y-%m-%dT%H:%M:%S', moment)}.{int(record.msecs):03d}Z",
            "level": record.levelname.lower(),
            "logger": record.name,
            "message": self._mask(record.getMessage()),
        }
        if record.exc_info:
            row["traceback"] = self._mask(self.formatException(record.exc_info))
        return json.dumps(row, ensure_ascii=False)
