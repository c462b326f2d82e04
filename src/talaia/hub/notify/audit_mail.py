"""Mails signed heads of the audit log: what gathered since the last mail, as an attached file.

The lines are taken from the file in the data folder, and how far they were mailed stands beside it:
a restart loses none and sends no mail before its time.
"""

from __future__ import annotations

import asyncio
import datetime as dt
import socket
from typing import TYPE_CHECKING

import msgspec

from talaia.hub.auth.audit_heads import key_name
from talaia.hub.errors import StoreDown
from talaia.hub.notify.audit_heads import HEADS_FILE
from talaia.hub.notify.head_file import HeadPiece, read_head_piece, write_note
from talaia.hub.notify.head_trouble import HeadTrouble
from talaia.hub.notify.message import AlarmMessage
from talaia.hub.notify.senders import Outcome
from talaia.hub.store.alarms.notification_channels import WayKind

if TYPE_CHECKING:
    from pathlib import Path

    from talaia.clock import Clock
    from talaia.hub.notify.senders import Sender
    from talaia.hub.store.alarms.notification_channels import NotifyStore, Way
    from talaia.hub.store.audit import Audit

__all__ = ["MAILED_FILE", "HeadMails"]

# In the data folder: how far the heads were mailed, to whom, and when.
MAILED_FILE = "audit-mailed.json"
# Between two looks whether a mail is due; so long until a mail that failed is tried again, too (s).
_LOOK_S = 900.0
# Of one mail (bytes): more than a year of heads, and less than mail servers refuse.
_MOST_BYTES = 4 * 1024**2


class _Mailed(msgspec.Struct, frozen=True):
    """How far it came: bytes of the file, the address, and when the last mail went (UTC)."""

    target: str = ""
    at: int = 0
    time_us: int = 0


class HeadMails:
    """Mails heads to one address, at most once in a given time."""

    def __init__(
        self,
        *,
        folder: Path,
        target: str,
        every_s: float,
        public: str,
        store: NotifyStore,
        sender: Sender,
        audit: Audit,
        clock: Clock,
    ) -> None:
        """Mail what lies in ``folder`` to ``target``; ``public`` is the key of the heads."""
        self._folder = folder
        self._target = target
        self._every_us = round(every_s * 1e6)
        self._public = public
        # The ways of alarms' messages; the mail server is one of them.
        self._store = store
        self._sender = sender
        self._trouble = HeadTrouble(audit, done="mailed")
        self._clock = clock

    async def run(self) -> None:
        """Look now and then whether a mail is due, until cancelled."""
        while True:
            await self.mail_due()
            await asyncio.sleep(_LOOK_S)

    async def mail_due(self) -> bool:
        """Mail what has gathered, where it is time; tell whether the server took a mail.

        What goes wrong is told in the log and the audit log, once until it is mended.
        """
        try:
            problem = await self._mail_gathered()
        except (StoreDown, OSError) as error:
            problem = str(error)
        if problem is None:
            return False
        self._trouble.show(self._target, problem)
        return not problem

    async def _mail_gathered(self) -> str | None:
        """Give why it was not mailed, an empty text if it was, None if nothing was due."""
        mailed = await asyncio.to_thread(self._read_mailed)
        now_us = self._clock.wall_ns() // 1000
        # A clock that was set back must not hold mails up for as long as it was set.
        if 0 <= now_us - mailed.time_us < self._every_us:
            return None
        piece = await asyncio.to_thread(
            read_head_piece, self._folder / HEADS_FILE, mailed.at, _MOST_BYTES
        )
        if piece is None:
            return None
        found = await self._find_way()
        if found is None:
            return "the hub has no way of the kind mail; an admin adds one under Notifications"
        # Before a word leaves: whatever becomes of us now, no second mail goes before its time.
        before = msgspec.structs.replace(mailed, time_us=now_us)
        await asyncio.to_thread(self._write_mailed, before)
        way, secrets = found
        went = await self._sender.mail_file(
            way,
            secrets,
            target=self._target,
            message=self._compose_mail(piece),
            file=(f"audit-heads-{_utc_time(now_us):%Y%m%dT%H%M%SZ}.txt", piece.text),
        )
        match went.outcome:
            case Outcome.SENT:
                after = msgspec.structs.replace(before, at=piece.end)
                await asyncio.to_thread(self._write_mailed, after)
                return ""
            case Outcome.UNSURE:
                # The next mail has these lines once more: a line that comes twice does no harm.
                return f"it may have been delivered: {went.problem}"
            case _:
                await asyncio.to_thread(self._write_mailed, mailed)
                return went.problem

    async def _find_way(self) -> tuple[Way, dict[str, str]] | None:
        """Give the mail server that was set up first, with its secrets."""
        ways = [way.id for way in await self._store.list_ways() if way.kind is WayKind.MAIL]
        return await self._store.find_way(min(ways)) if ways else None

    def _compose_mail(self, piece: HeadPiece) -> AlarmMessage:
        host = socket.gethostname()
        body = (
            f"Attached are signed heads of the audit log of the Talaia hub on {host}.\n"
            "Keep them where nobody of the hub can delete them. Whether the log is as it was:\n\n"
            "    talaia audit verify --data FOLDER --heads FILE\n\n"
            f"Key of the heads: {self._public}\n"
        )
        # The same lines again are the same message, for a server that looks.
        key = f"audit-heads-{key_name(self._public)}-{piece.start}-{piece.end}"
        return AlarmMessage(key, f"Talaia: heads of the audit log of {host}", body, "info", ())

    def _read_mailed(self) -> _Mailed:
        fresh = _Mailed(self._target)
        try:
            found = msgspec.json.decode((self._folder / MAILED_FILE).read_bytes(), type=_Mailed)
        except (FileNotFoundError, msgspec.DecodeError, UnicodeDecodeError):
            return fresh
        # Another address has none of them yet.
        return found if found.target == self._target else fresh

    def _write_mailed(self, mailed: _Mailed) -> None:
        write_note(self._folder / MAILED_FILE, msgspec.json.encode(mailed))


def _utc_time(time_us: int) -> dt.datetime:
    return dt.datetime.fromtimestamp(time_us / 1e6, dt.UTC)
