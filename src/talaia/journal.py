"""Sends log records to systemd's journal with their fields, by its native protocol.

See systemd's *Native Journal Protocol* (JOURNAL_NATIVE_PROTOCOL) and systemd.journal-fields(7).
"""

from __future__ import annotations

import array
import contextlib
import errno
import fcntl
import logging
import os
import re
import socket
import sys
from typing import TYPE_CHECKING

if TYPE_CHECKING:
    from collections.abc import Callable, Mapping

__all__ = ["JOURNAL_SOCKET", "JournalHandler", "encode_entry", "is_journal_stream"]

JOURNAL_SOCKET = "/run/systemd/journal/socket"
# syslog(3) has more; these are what Python's levels mean.
_PRIORITIES = (
    (logging.CRITICAL, 2),
    (logging.ERROR, 3),
    (logging.WARNING, 4),
    (logging.INFO, 6),
    (logging.NOTSET, 7),
)
# Others are dropped by the journal without a word.
_FIELD = re.compile(r"[A-Z0-9][A-Z0-9_]{0,63}\Z")
# What a file handed over may not become any more: the journal refuses one that could change.
_SEALS = fcntl.F_SEAL_SEAL | fcntl.F_SEAL_SHRINK | fcntl.F_SEAL_GROW | fcntl.F_SEAL_WRITE


def is_journal_stream(environment: Mapping[str, str], descriptor: int) -> bool:
    """Tell whether what is written to a descriptor ends in the journal (``$JOURNAL_STREAM``)."""
    device, _, inode = environment.get("JOURNAL_STREAM", "").partition(":")
    # A program whose output was led elsewhere has inherited the variable, and not the stream.
    with contextlib.suppress(OSError):
        status = os.fstat(descriptor)
        return (device, inode) == (str(status.st_dev), str(status.st_ino))
    return False


def encode_entry(fields: Mapping[str, str]) -> bytes:
    """Write one entry of the journal; fields without a valid name or any value are left out."""
    parts = []
    for name, value in fields.items():
        if not value or not _FIELD.match(name):
            continue
        said = value.encode("utf-8", "replace")
        if b"\n" in said:
            # With its length, for a line end would begin a field of somebody else's choice.
            parts.append(name.encode() + b"\n" + len(said).to_bytes(8, "little") + said + b"\n")
        else:
            parts.append(name.encode() + b"=" + said + b"\n")
    return b"".join(parts)


class JournalHandler(logging.Handler):
    """Sends each record as one entry; what the journal does not take goes to stderr as a line."""

    def __init__(
        self,
        fields: Mapping[str, str],
        mask: Callable[[str], str] = str,
        address: str = JOURNAL_SOCKET,
    ) -> None:
        """Add ``fields`` to each entry; ``mask`` takes out what is nobody's to read."""
        super().__init__()
        self.fields = dict(fields)
        self._mask = mask
        self._address = address
        self._socket = socket.socket(socket.AF_UNIX, socket.SOCK_DGRAM | socket.SOCK_CLOEXEC)
        # A journal that does not read must never hold up a control loop.
        self._socket.settimeout(0)
        self._fallback = logging.StreamHandler()
        self._fallback.setFormatter(_MaskedLine(mask))

    def emit(self, record: logging.LogRecord) -> None:
        """Send a record, its traceback too, with each secret masked."""
        # The log of a program must never be what ends it.
        try:
            self._send_entry(encode_entry(self._fields_of(record)))
        except OSError:
            # That of now: somebody may have put another in its place.
            self._fallback.stream = sys.stderr
            self._fallback.handle(record)
        except (TypeError, ValueError):
            # Its words and what belongs into them do not fit.
            self.handleError(record)

    def close(self) -> None:
        """Send nothing any more."""
        self._socket.close()
        super().close()

    def _fields_of(self, record: logging.LogRecord) -> dict[str, str]:
        message = record.getMessage()
        traceback = ""
        if record.exc_info:
            traceback = self._mask(logging.Formatter().formatException(record.exc_info))
        priority = next(number for level, number in _PRIORITIES if record.levelno >= level)
        return {
            **self.fields,
            # Without a message the journal has nothing to show.
            "MESSAGE": self._mask(message) or " ",
            "PRIORITY": str(priority),
            "LOGGER": record.name,
            "THREAD_NAME": record.threadName or "",
            "CODE_FILE": record.pathname,
            "CODE_LINE": str(record.lineno),
            "CODE_FUNC": record.funcName or "",
            "TRACEBACK": traceback,
        }

    def _send_entry(self, entry: bytes) -> None:
        try:
            self._socket.sendto(entry, self._address)
        except OSError as error:
            if error.errno not in (errno.EMSGSIZE, errno.ENOBUFS):
                raise
            self._send_file(entry)

    def _send_file(self, entry: bytes) -> None:
        """Hand over an entry that fits no datagram, in a file without a name."""
        descriptor = os.memfd_create("talaia-journal", os.MFD_CLOEXEC | os.MFD_ALLOW_SEALING)
        with os.fdopen(descriptor, "wb") as file:
            file.write(entry)
            file.flush()
            fcntl.fcntl(descriptor, fcntl.F_ADD_SEALS, _SEALS)
            rights = array.array("i", [descriptor]).tobytes()
            ancillary = [(socket.SOL_SOCKET, socket.SCM_RIGHTS, rights)]
            self._socket.sendmsg([], ancillary, 0, self._address)


class _MaskedLine(logging.Formatter):
    """A line for people, where there is no journal."""

    def __init__(self, mask: Callable[[str], str]) -> None:
        super().__init__("%(asctime)s %(levelname)s %(name)s: %(message)s")
        self._mask = mask

    def format(self, record: logging.LogRecord) -> str:
        """Write a record with each secret masked."""
        return self._mask(super().format(record))
