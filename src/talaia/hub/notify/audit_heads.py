"""Sends signed heads of the audit log out: into files, and to the machine's log.

What lies outside the database and is never written over is what a chain that was made anew cannot
match. Keep it on another machine: a log server takes it from the machine's log.
"""

from __future__ import annotations

import asyncio
import logging
import os
import socket
from contextlib import suppress
from typing import TYPE_CHECKING

from talaia.hub.auth.audit_heads import AuditHead, read_head
from talaia.hub.errors import StoreDown

if TYPE_CHECKING:
    from collections.abc import Iterable, Sequence
    from pathlib import Path

    from talaia.clock import Clock
    from talaia.hub.auth.audit_heads import HeadKey
    from talaia.hub.store.audit import Audit

__all__ = ["HEADS_FILE", "AuditHeads", "read_heads"]

_LOG = logging.getLogger(__name__)
# In the data folder, beside the key.
HEADS_FILE = "audit-heads.log"
_EVERY_S = 3_600.0
# So long the last notes may take to be written before the last head (s).
_LAST_S = 1.0
# Facility 13 is "log audit", severity 5 a notice (RFC 5424, 6.2.1).
_PRIORITY = 13 * 8 + 5
_SYSLOG = "/dev/log"


class AuditHeads:
    """Says every hour, and at the end, what the newest row is."""

    def __init__(
        self,
        *,
        audit: Audit,
        key: HeadKey,
        files: Sequence[Path],
        syslog: bool,
        clock: Clock,
        every_s: float = _EVERY_S,
    ) -> None:
        """Append to ``files``, and send to the machine's log where ``syslog``."""
        self._audit = audit
        self._key = key
        self._files = tuple(files)
        self._syslog = syslog
        self._clock = clock
        self._every_s = every_s
        self._last = (0, 0)
        self._stopping = asyncio.Event()

    async def run(self) -> None:
        """Say it now and then until `stop`, and once more."""
        while not self._stopping.is_set():
            await self._try_sending()
            with suppress(TimeoutError):
                async with asyncio.timeout(self._every_s):
                    await self._stopping.wait()
        # Of the end, too; a hub whose database is away ends all the same.
        with suppress(TimeoutError):
            async with asyncio.timeout(_LAST_S):
                await self._audit.wait_written()
        await self._try_sending()

    def stop(self) -> None:
        """Let `run` end."""
        self._stopping.set()

    async def send_head(self) -> AuditHead | None:
        """Say what the newest row is; None where it was said already, or there is none.

        Raises:
            StoreDown: nobody knows it now.
            OSError: it cannot be written.

        """
        row, said_hash = await self._audit.read_head()
        if not row or (row, self._audit.lost) == self._last:
            return None
        head = AuditHead(row, said_hash, self._clock.wall_ns() // 1000, self._audit.lost)
        line = self._key.sign_head(head)
        for file in self._files:
            await asyncio.to_thread(_append_line, file, line)
        if self._syslog:
            await asyncio.to_thread(_send_syslog, line)
        self._last = (row, self._audit.lost)
        return head

    async def _try_sending(self) -> None:
        try:
            await self.send_head()
        except (StoreDown, OSError) as error:
            _LOG.error("the head of the audit log could not be sent out: %s", error)


def read_heads(lines: Iterable[str], public: str) -> dict[int, str]:
    """Give what rows' hashes were, by heads of a key.

    Raises:
        ValueError: a head's signature is wrong, or two say different things of one row.

    """
    found: dict[int, str] = {}
    for line in lines:
        head = read_head(line, public)
        if head is None:
            continue
        if found.setdefault(head.row, head.hash) != head.hash:
            raise ValueError(f"two heads say different things of row {head.row}")
    return found


def _append_line(file: Path, line: str) -> None:
    number = os.open(file, os.O_WRONLY | os.O_APPEND | os.O_CREAT | os.O_CLOEXEC, 0o600)
    try:
        os.write(number, line.encode() + b"\n")
        os.fsync(number)
    finally:
        os.close(number)


def _send_syslog(line: str) -> None:
    with socket.socket(socket.AF_UNIX, socket.SOCK_DGRAM) as out:
        out.connect(_SYSLOG)
        out.send(f"<{_PRIORITY}>talaia: {line}".encode())
