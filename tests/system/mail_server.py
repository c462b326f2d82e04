"""A real SMTP server on loopback that keeps what it gets."""

from __future__ import annotations

import asyncio
import email
import email.policy
from collections.abc import AsyncIterator
from contextlib import asynccontextmanager
from typing import NamedTuple

from aiosmtpd.smtp import SMTP


class Mail(NamedTuple):
    """To whom (before the @), and what it says."""

    to: str
    subject: str
    text: str


class Mailbox:
    """What has come."""

    def __init__(self) -> None:
        """Hold nothing."""
        self.port = 0
        self.mails: list[Mail] = []

    async def handle_DATA(self, _server, _session, envelope) -> str:  # noqa: N802 - aiosmtpd's name
        mail = email.message_from_bytes(envelope.content, policy=email.policy.default)
        subject, text = str(mail["Subject"]), str(mail.get_content())
        self.mails += [Mail(to.partition("@")[0], subject, text) for to in envelope.rcpt_tos]
        return "250 OK"

    def to(self, who: str) -> list[str]:
        """Give the subjects of the mails to one."""
        return [mail.subject for mail in self.mails if mail.to == who]


@asynccontextmanager
async def mail_server() -> AsyncIterator[Mailbox]:
    """Listen on a free port."""
    mailbox = Mailbox()
    loop = asyncio.get_running_loop()
    server = await loop.create_server(
        lambda: SMTP(mailbox, hostname="test", enable_SMTPUTF8=False), "127.0.0.1", 0
    )
    mailbox.port = server.sockets[0].getsockname()[1]
    yield mailbox
    server.close()
