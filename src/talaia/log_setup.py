"""How hub and gateway write their logs: level, and lines for people or JSON for collectors."""

from __future__ import annotations

import json
import logging
import time
from typing import TYPE_CHECKING

if TYPE_CHECKING:
    import argparse
    from collections.abc import Callable

__all__ = ["LOG_LEVELS", "add_log_options", "set_up_log"]

LOG_LEVELS = ("debug", "info", "warning", "error")


def add_log_options(parser: argparse.ArgumentParser) -> None:
    """Let a parser read ``--log-level`` and ``--log-format``."""
    parser.add_argument(
        "--log-level", choices=LOG_LEVELS, default="info", help="least level of the log (info)"
    )
    parser.add_argument(
        "--log-format",
        choices=("text", "json"),
        default="text",
        help="lines for people, or an object of JSON in each line (text)",
    )


def set_up_log(level: str, form: str, mask: Callable[[str], str] = str) -> None:
    """Write the log to stderr.

    Args:
        level: one of `LOG_LEVELS`.
        form: ``text`` or ``json``.
        mask: takes out of each line what is nobody's to read.

    """
    handler = logging.StreamHandler()
    handler.setFormatter(_JsonFormatter(mask) if form == "json" else _TextFormatter(mask))
    logging.basicConfig(level=level.upper(), handlers=[handler])


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
