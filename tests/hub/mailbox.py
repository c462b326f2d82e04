"""A mail server on loopback, and people who want to be told by it."""

# ruff: noqa: D107

from __future__ import annotations

import asyncio
import email
import email.policy

import pytest
from aiosmtpd.smtp import SMTP


class Mailbox:
    """A real SMTP server on loopback that keeps what it gets."""

    def __init__(self) -> None:
        self.envelopes = []
        self.news = asyncio.Event()
        self.answer = "250 OK"
        # The hub's number of the way that leads here, once there is one.
        self.way = ""

    async def handle_DATA(self, _server, _session, envelope) -> str:  # noqa: N802 - aiosmtpd's name
        if self.answer.startswith("250"):
            self.envelopes.append(envelope)
            self.news.set()
        return self.answer

    def text(self, at: int = 0) -> str:
        mail = email.message_from_bytes(self.envelopes[at].content, policy=email.policy.default)
        return f"{mail['Subject']}\n{mail.get_content()}"


@pytest.fixture
async def mailbox():
    mailbox = Mailbox()
    server = await asyncio.get_running_loop().create_server(
        lambda: SMTP(mailbox, enable_SMTPUTF8=False), "127.0.0.1", 0
    )
    mailbox.port = server.sockets[0].getsockname()[1]
    yield mailbox
    server.close()


def mail_way(port: int) -> dict[str, object]:
    return {
        "name": "Mail",
        "kind": "mail",
        "host": "127.0.0.1",
        "port": port,
        "security": "none",
        "sender": "talaia@example.org",
    }


async def want_mail(hub, mailbox, who: str = "operator", **rule) -> str:
    """Let somebody be told by mail, the first by a new way; give the rule's id."""
    admin, person = await hub.client("admin"), await hub.client(who)
    if not mailbox.way:
        made = await admin.post("/api/ways", json=mail_way(mailbox.port))
        assert made.status_code == 201, made.text
        mailbox.way = made.json()["id"]
    asked = {
        "site": "agv",
        "way": mailbox.way,
        "target": "op@example.org",
        "group_s": 0,
        **rule,
    }
    added = await person.post("/api/me/rules", json=asked)
    assert added.status_code == 201, added.text
    return added.json()["id"]
