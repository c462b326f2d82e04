"""Signed heads of the audit log by mail: at most one in a time, and the log is held against it."""

from __future__ import annotations

import asyncio
import email
import email.policy
import ipaddress
from dataclasses import replace

import pytest

from talaia.cli.auditing.main import main as verify_from_command_line
from talaia.clock import SECOND, HandClock
from talaia.hub.auth.audit_heads import HeadKey
from talaia.hub.auth.secret_box import Seal
from talaia.hub.notify.audit_heads import HEADS_FILE, AuditHeads, read_heads
from talaia.hub.notify.audit_mail import MAILED_FILE, HeadMails
from talaia.hub.notify.senders import Sender
from talaia.hub.store.alarms.notification_channels import NotifyStore, WayKind
from talaia.hub.store.audit import Audit, AuditFilter
from talaia.hub.store.database import Database

from ..auth.test_audit_heads import rewrite
from ..conftest import PATIENCE_S, RunningHub
from ..mailbox import mail_way

LOOPBACK = (ipaddress.ip_network("127.0.0.1/32"),)
KEY = HeadKey(bytes(range(32)))
HOUR = 3600 * SECOND


@pytest.fixture
async def database(settings):
    """One on SQLite: what a mail holds is read from a file, whatever the database is."""
    database = Database(settings.url)
    yield database
    await database.close()


def attached(mailbox, at: int) -> tuple[str, str]:
    """Give name and text of what hangs on a mail, as who saves it has it."""
    mail = email.message_from_bytes(mailbox.envelopes[at].content, policy=email.policy.default)
    (file,) = mail.iter_attachments()
    assert file.get_content_type() == "text/plain"
    return file.get_filename(), file.get_content()


class MailedLog:
    """An audit log whose heads are mailed once a day, as a hub that begins now has it."""

    def __init__(self, database: Database, folder, clock: HandClock) -> None:  # noqa: D107
        self.log = Audit(database, clock)
        self.store = NotifyStore(database, lambda: Seal(bytes(32)))
        self.heads = AuditHeads(
            audit=self.log, key=KEY, files=[folder / HEADS_FILE], syslog=False, clock=clock
        )
        self.mails = HeadMails(
            folder=folder, target="audit@example.org", every_s=86_400.0, public=KEY.public,
            store=self.store, sender=Sender(LOOPBACK), audit=self.log, clock=clock,
        )  # fmt: skip

    async def write(self, kind: str) -> None:
        """Write a row, and its head."""
        self.log.append_record(kind)
        self.log.stop()
        await self.log.run()
        await self.heads.send_head()

    async def add_way(self, port: int) -> None:
        settings = {key: str(said) for key, said in mail_way(port).items() if key != "name"}
        await self.store.put_way(
            None, f"mail {port}", kind=WayKind.MAIL, settings=settings, secrets={}, now_us=0
        )


async def test_saved_attachment_of_a_mail_verifies_and_fails_once_the_log_was_made_anew(
    settings, history, mailbox, tmp_path, capsys
) -> None:
    settings = replace(settings, notify_networks=LOOPBACK, audit_mail="audit@example.org")
    async with RunningHub(settings, history) as hub:
        await hub.populate()
        admin = await hub.client("admin")
        made = await admin.post("/api/ways", json=mail_way(mailbox.port))
        assert made.status_code == 201, made.text
    # It said its last head when it ended; the next one finds that at its start.
    async with RunningHub(settings, history), asyncio.timeout(PATIENCE_S):
        await mailbox.news.wait()
    assert mailbox.envelopes[0].rcpt_tos == ["audit@example.org"]
    name, text = attached(mailbox, 0)
    saved = tmp_path / name
    saved.write_text(text)
    # As it was signed, line for line: nothing on the way has wrapped it.
    assert (settings.data / HEADS_FILE).read_text().startswith(text)
    asked = ["verify", "--data", str(settings.data), "--heads", str(saved)]
    assert await asyncio.to_thread(verify_from_command_line, asked) == 0
    assert "0 signed heads fit" not in capsys.readouterr().out
    database = Database(settings.url)
    await rewrite(database, without="login")
    await database.close()
    assert await asyncio.to_thread(verify_from_command_line, asked) == 1
    assert "not the one that was signed" in capsys.readouterr().out


async def test_one_mail_a_day_brings_all_heads_since_the_last_also_after_a_restart(
    database, mailbox, tmp_path
) -> None:
    clock = HandClock()
    hub = MailedLog(database, tmp_path, clock)
    await hub.add_way(mailbox.port)
    # Nothing has gathered yet.
    assert not await hub.mails.mail_due()
    await hub.write("login")
    assert await hub.mails.mail_due()
    for kind in ("logout", "login"):
        clock.advance(HOUR)
        await hub.write(kind)
        assert not await hub.mails.mail_due()
    clock.advance(21 * HOUR)
    begun_anew = MailedLog(database, tmp_path, clock)
    assert not await begun_anew.mails.mail_due()
    clock.advance(HOUR)
    assert await begun_anew.mails.mail_due()
    rows = [list(read_heads(attached(mailbox, at)[1].splitlines(), KEY.public)) for at in (0, 1)]
    assert rows == [[1], [2, 3]]
    # A day later nothing is new.
    clock.advance(24 * HOUR)
    assert not await begun_anew.mails.mail_due()


async def test_mail_server_that_fails_is_told_once_and_once_more_when_it_takes_mails(
    database, mailbox, tmp_path, caplog
) -> None:
    clock = HandClock()
    hub = MailedLog(database, tmp_path, clock)
    await hub.write("login")
    assert not await hub.mails.mail_due()
    assert "no way of the kind mail" in caplog.text
    await hub.add_way(mailbox.port)
    mailbox.answer = "451 Later"
    assert not await hub.mails.mail_due()
    mailbox.answer = "250 OK"
    # What certainly did not arrive is tried again before its day is over.
    assert await hub.mails.mail_due()
    assert attached(mailbox, 0)[1] == (tmp_path / HEADS_FILE).read_text()
    await hub.write("logout")
    clock.advance(24 * HOUR)
    assert await hub.mails.mail_due()
    assert caplog.text.count("were not mailed") == 1
    assert caplog.text.count("are mailed to") == 1
    rows, _ = await hub.log.find_records(AuditFilter(), 10)
    told = sorted((row.entry.kind, row.entry.good) for row in rows if "mailed" in row.entry.kind)
    assert told == [("heads mailed again", True), ("heads not mailed", False)]


async def test_mail_that_may_have_arrived_waits_its_day_and_its_heads_come_again(
    database, mailbox, tmp_path
) -> None:
    clock = HandClock()
    hub = MailedLog(database, tmp_path, clock)

    async def hang_up(reader: asyncio.StreamReader, writer: asyncio.StreamWriter) -> None:
        """Take a mail as a whole, and close instead of answering."""
        writer.write(b"220 here\r\n")
        while line := await reader.readline():
            if line == b".\r\n":
                break
            # Lines of the mail itself get no answer.
            if line[:4].upper() in {b"EHLO", b"MAIL", b"RCPT"}:
                writer.write(b"250 OK\r\n")
            elif line.lower() == b"data\r\n":
                writer.write(b"354 go on\r\n")
        writer.close()

    server = await asyncio.start_server(hang_up, "127.0.0.1", 0)
    await hub.add_way(server.sockets[0].getsockname()[1])
    await hub.write("login")
    assert not await hub.mails.mail_due()
    (way,) = await hub.store.list_ways()
    server.close()
    await hub.store.remove_way(way.id)
    await hub.add_way(mailbox.port)
    assert not await hub.mails.mail_due()
    assert not mailbox.envelopes
    clock.advance(24 * HOUR)
    assert await hub.mails.mail_due()
    assert list(read_heads(attached(mailbox, 0)[1].splitlines(), KEY.public)) == [1]


@pytest.mark.parametrize(
    "said",
    [
        "",
        "no JSON",
        # The address was another one, which had some just now.
        '{"target": "somebody@example.org", "at": 5, "time_us": 1700000000000000}',
        # A backup was restored: the file is shorter than what was mailed of it.
        '{"target": "audit@example.org", "at": 999999}',
    ],
)
async def test_of_a_damaged_note_another_address_or_a_restored_file_all_heads_are_mailed(
    database, mailbox, tmp_path, said
) -> None:
    hub = MailedLog(database, tmp_path, HandClock())
    await hub.add_way(mailbox.port)
    await hub.write("login")
    (tmp_path / MAILED_FILE).write_text(said)
    assert await hub.mails.mail_due()
    assert attached(mailbox, 0)[1] == (tmp_path / HEADS_FILE).read_text()
