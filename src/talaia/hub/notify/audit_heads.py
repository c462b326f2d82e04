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
from functools import partial
from typing import TYPE_CHECKING

from talaia.hub.auth.audit_heads import AuditHead, read_head
from talaia.hub.errors import StoreDown
from talaia.hub.notify.head_trouble import HeadTrouble

if TYPE_CHECKING:
    from collections.abc import Callable, Iterable, Sequence
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
        # By where it goes: row and lost notes of what is there already.
        self._sent: dict[str, tuple[int, int]] = {}
        self._trouble = HeadTrouble(audit)
        # The database did not answer the last time.
        self._away = False
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
        """Say what the newest row is, wherever it was not said yet; None: it was, or there is none.

        Where it cannot be said is told once, in the log and the audit log, and does not keep it
        from the others.

        Raises:
            StoreDown: nobody knows it now.

        """
        row, said_hash = await self._audit.read_head()
        lost = self._audit.lost
        targets: list[tuple[str, Callable[[str], None]]] = [
            (str(file), partial(_append_line, file)) for file in self._files
        ]
        if self._syslog:
            targets.append(("the machine's log", _send_syslog))
        waiting = [target for target in targets if self._sent.get(target[0]) != (row, lost)]
        if not row or not waiting:
            return None
        head = AuditHead(row, said_hash, self._clock.wall_ns() // 1000, lost)
        line = self._key.sign_head(head)
        for name, write in waiting:
            try:
                await asyncio.to_thread(write, line)
            except OSError as error:
                self._trouble.show(name, error.strerror or str(error))
            else:
                self._sent[name] = (row, lost)
                self._trouble.show(name, "")
        return head

    async def _try_sending(self) -> None:
        try:
            await self.send_head()
        except StoreDown as error:
            # Told once: `Audit` itself says when the database is there again.
            if not self._away:
                _LOG.error("the head of the audit log is not known now: %s", error)
            self._away = True
        else:
            self._away = False


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
