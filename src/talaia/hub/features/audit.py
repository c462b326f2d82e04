"""The audit log: what happened, who asked for it, and how it ended."""

from __future__ import annotations

from typing import TYPE_CHECKING

from talaia.hub.api.records.audit import AuditPages
from talaia.hub.api.records.witnessed_hubs import WitnessedHubPages
from talaia.hub.auth.audit_heads import head_key
from talaia.hub.features.feature import BackgroundTask, Feature
from talaia.hub.notify.audit_heads import HEADS_FILE, AuditHeads, read_heads
from talaia.hub.notify.audit_hub import HeadForwarder
from talaia.hub.notify.audit_hub_settings import read_audit_hub_settings
from talaia.hub.notify.audit_mail import HeadMails
from talaia.hub.notify.senders import Sender
from talaia.hub.store.alarms.notification_channels import NotifyStore
from talaia.hub.store.audit import Audit
from talaia.hub.store.witnessed_hubs import WitnessedHubs

if TYPE_CHECKING:
    from talaia.hub.features.feature import Core

__all__ = ["AuditFeature"]


class AuditFeature(Feature):
    """First to begin and last to end, so that every other feature can write.

    Attributes:
        log: what other features write to.
        heads: sends signed heads out; None before it is open.
        mails: mails them; None before it is open, and where no address is named.
        forwarder: sends them to another hub; None before it is open, and where none is named.

    """

    name = "audit"

    def __init__(self, core: Core) -> None:
        """Keep the log in the hub's database."""
        self._core = core
        self.log = Audit(core.database, core.clock)
        self.heads: AuditHeads | None = None
        self.mails: HeadMails | None = None
        witnessed = WitnessedHubs(core.database, core.clock)
        self.routers = [
            WitnessedHubPages(hubs=witnessed, audit=self.log, clock=core.clock).make_router(),
            AuditPages(self.log, self._read_heads).make_router(),
        ]
        self.forwarder: HeadForwarder | None = None
        # Rows are chained, so one task writes them, one after the other.
        self.tasks = [
            BackgroundTask(name="write", run=self._write_records, stop=self._stop_writing),
        ]
        # One of several shards says for all what the chain's end is: there is one chain.
        if not core.shard.is_main:
            return
        self.tasks.append(
            BackgroundTask(name="heads", run=self._send_heads, stop=self._stop_sending)
        )
        if core.settings.audit_mail:
            # Cancelled at the end: a mail server that hangs must not hold the hub's end up.
            self.tasks.append(BackgroundTask(name="mail heads", run=self._mail_heads))
        if core.settings.audit_hub:
            self.tasks.append(BackgroundTask(name="forward heads", run=self._forward_heads))

    async def open(self) -> None:
        """Read the key that signs heads.

        Raises:
            CannotStart: it cannot be read.

        """
        settings = self._core.settings
        if not self._core.shard.is_main:
            return
        key = head_key(settings.data)
        self.heads = AuditHeads(
            audit=self.log,
            key=key,
            files=[settings.data / HEADS_FILE, *settings.audit_heads],
            syslog=settings.audit_syslog,
            clock=self._core.clock,
        )
        if settings.audit_mail:
            self.mails = HeadMails(
                folder=settings.data,
                target=settings.audit_mail,
                every_s=settings.audit_mail_s,
                public=key.public,
                store=NotifyStore(self._core.database, self._core.secret_box),
                sender=Sender(settings.notify_networks),
                audit=self.log,
                clock=self._core.clock,
            )

        if settings.audit_hub:
            self.forwarder = HeadForwarder(
                folder=settings.data,
                settings=read_audit_hub_settings(settings.audit_hub),
                public=key.public,
                audit=self.log,
                clock=self._core.clock,
            )

    async def _write_records(self) -> None:
        self.log.append_record("hub started", message=self._shard_words())
        await self.log.run()

    def _stop_writing(self) -> None:
        # Before the stop, which lets what waits be written once more.
        self.log.append_record("hub stopped", message=self._shard_words())
        self.log.stop()

    def _shard_words(self) -> str:
        shard = self._core.shard
        return "" if shard.is_whole else f"shard {shard.name}"

    async def _send_heads(self) -> None:
        if self.heads is not None:
            await self.log.wait_written()
            await self.heads.run()

    async def _mail_heads(self) -> None:
        if self.mails is not None:
            await self.mails.run()

    async def _forward_heads(self) -> None:
        if self.forwarder is not None:
            await self.forwarder.run()

    def _stop_sending(self) -> None:
        if self.heads is not None:
            self.heads.stop()

    def _read_heads(self) -> dict[int, str]:
        """Read the heads that lie in the data folder; called in a thread."""
        file = self._core.settings.data / HEADS_FILE
        if not file.exists():
            return {}
        with file.open(encoding="utf-8", errors="replace") as lines:
            return read_heads(lines, head_key(self._core.settings.data).public)
