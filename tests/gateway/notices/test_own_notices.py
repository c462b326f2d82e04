"""The gateway's own way to people: a real mail server, a real HTTP receiver, a real command."""

# ruff: noqa: D107, ASYNC110

from __future__ import annotations

import asyncio
import json
import sys
from collections.abc import AsyncIterator
from pathlib import Path

import pytest
from aiosmtpd.smtp import SMTP
from hypothesis import given, strategies as st
from patience import PATIENCE_S

from talaia.clock import SECOND, HandClock
from talaia.gateway.errors import SettingsError
from talaia.gateway.notices.own_notices import OwnNotices, main
from talaia.gateway.notices.sending import send_notice
from talaia.gateway.notices.settings import NoticeSettings, read_notice_settings
from talaia.gateway.notices.standing_notices import GatewayNotice, StandingNotices
from talaia.wire.frames import EnclosureState

NOTICE = GatewayNotice("dome-1-1", "dome", "Dome: NOT CLOSED after 3 tries", 1_700_000_000_000_000)


class Mailbox:
    """Keeps what it gets."""

    def __init__(self) -> None:
        self.got: list[tuple[list[str], str]] = []

    async def handle_DATA(self, _server, _session, envelope) -> str:  # noqa: N802 - aiosmtpd's name
        self.got.append((envelope.rcpt_tos, envelope.content.decode()))
        return "250 OK"


class Receiver:
    """A web server that keeps what it is sent."""

    def __init__(self) -> None:
        self.got: list[tuple[str, bytes]] = []
        self.answer = "204 No Content"

    async def serve(self, reader: asyncio.StreamReader, writer: asyncio.StreamWriter) -> None:
        head = (await reader.readuntil(b"\r\n\r\n")).decode()
        size = next(
            int(line.split(":")[1])
            for line in head.splitlines()
            if line.lower().startswith("content-length")
        )
        self.got.append((head, await reader.readexactly(size)))
        writer.write(f"HTTP/1.1 {self.answer}\r\nContent-Length: 0\r\n\r\n".encode())
        writer.close()


@pytest.fixture
async def peers() -> AsyncIterator[tuple[Mailbox, int, Receiver, int]]:
    mailbox, receiver = Mailbox(), Receiver()
    loop = asyncio.get_running_loop()
    mail = await loop.create_server(lambda: SMTP(mailbox, hostname="test"), "127.0.0.1", 0)
    web = await asyncio.start_server(receiver.serve, "127.0.0.1", 0)
    yield mailbox, mail.sockets[0].getsockname()[1], receiver, web.sockets[0].getsockname()[1]
    mail.close()
    web.close()


def written(folder: Path, mail_port: int, web_port: int, more: str = "") -> Path:
    (folder / "token").write_text("s3cret\n")
    keep = "import pathlib,sys; pathlib.Path(sys.argv[1]).write_text(sys.stdin.read())"
    words = json.dumps([sys.executable, "-c", keep, str(folder / "told.json")])
    path = folder / "notices.toml"
    path.write_text(
        f"""{more}
[[mail]]
server = "127.0.0.1"
port = {mail_port}
security = "none"
sender = "roof@example.org"
to = ["anna@example.org", "ben@example.org"]
[[webhook]]
url = "http://127.0.0.1:{web_port}/hook"
token_file = "{folder / "token"}"
[[command]]
words = {words}
"""
    )
    return path


async def test_mail_webhook_and_command_each_get_it_with_its_time(
    tmp_path: Path, peers: tuple[Mailbox, int, Receiver, int]
) -> None:
    mailbox, mail_port, receiver, web_port = peers
    settings = read_notice_settings(written(tmp_path, mail_port, web_port))
    said = await send_notice(settings, "Hill", NOTICE)
    assert set(said.values()) == {""}, said
    to, text = mailbox.got[0]
    assert to == ["anna@example.org", "ben@example.org"]
    assert "Subject: Hill: Dome: NOT CLOSED after 3 tries" in text
    assert "2023-11-14 22:13:20 UTC" in text
    head, body = receiver.got[0]
    assert "Authorization: Bearer s3cret" in head
    assert "Idempotency-Key: dome-1-1" in head or "Idempotency-key: dome-1-1" in head
    assert json.loads(body)["time_us"] == NOTICE.time_us
    assert json.loads((tmp_path / "told.json").read_text()) == json.loads(body)


async def test_a_way_that_fails_says_why_and_holds_up_no_other(
    tmp_path: Path, peers: tuple[Mailbox, int, Receiver, int]
) -> None:
    _, mail_port, receiver, web_port = peers
    receiver.answer = "302 Found\r\nLocation: http://127.0.0.1:1/elsewhere"
    (path := written(tmp_path, 1, web_port)).write_text(
        path.read_text() + '[[command]]\nwords = ["/nonexistent/program"]\n'
    )
    assert mail_port
    said = await send_notice(read_notice_settings(path), "Hill", NOTICE)
    assert [bool(each) for each in said.values()] == [True, True, False, True]
    assert "302" in said["webhook 1"]
    assert (tmp_path / "told.json").exists()


async def test_a_test_notice_can_be_sent_by_hand(
    tmp_path: Path,
    peers: tuple[Mailbox, int, Receiver, int],
    capsys: pytest.CaptureFixture[str],
) -> None:
    mailbox, mail_port, _, web_port = peers
    path = written(tmp_path, mail_port, web_port)
    assert await asyncio.to_thread(main, [str(path), "--site", "Hill"]) == 0
    assert capsys.readouterr().out.count("sent") == 3
    assert "a test notice" in mailbox.got[0][1]
    assert await asyncio.to_thread(main, [str(written(tmp_path, 1, web_port))]) == 1


@pytest.mark.parametrize(
    "text",
    ["", "after = 0\n", "nonsense", "[[mail]]\nserver = 'a'\nsender = 'b'\nto = []\n",
     "[[webhook]]\nurl = 'file:///etc/passwd'\n", "[[command]]\nwords = []\n",
     "[[webhook]]\nurl = 'https://a'\ntoken = 'in the clear'\n"],
)  # fmt: skip
def test_settings_that_do_not_fit_are_refused_by_name(tmp_path: Path, text: str) -> None:
    (tmp_path / "notices.toml").write_text(text)
    with pytest.raises(SettingsError, match=r"notices\.toml"):
        read_notice_settings(tmp_path / "notices.toml")


def story(linked: list[bool], cleared_at: int = -1) -> list[tuple[int, bool]]:
    """When what is told, minute by minute, of something that stands from the beginning."""
    standing = StandingNotices(NoticeSettings(after=60, repeat=300, longest=1200))
    standing.raise_notice("dome", "NOT CLOSED", 7, 0)
    said = []
    for minute, link in enumerate(linked):
        if minute == cleared_at:
            standing.clear_notice("dome", 9)
        for each in standing.due_notices(minute * 60 * SECOND, linked=link):
            assert each.time_us == (9 if each.over else 7)
            said.append((minute, each.over))
    return said


def test_without_a_hub_it_is_told_again_and_later_each_time_until_it_is_over() -> None:
    said = story([False] * 80, cleared_at=70)
    assert said == [(1, False), (6, False), (16, False), (36, False), (56, False), (70, True)]


def test_a_hub_that_is_there_tells_people_by_itself() -> None:
    assert story([True] * 100, cleared_at=50) == []
    # It goes away after that: a stated time later the gateway tells, and not before.
    assert story([True] * 10 + [False] * 3) == [(11, False)]
    # A hub that is back has taken over; no storm, and nothing is told of what it saw end.
    assert story([False] * 3 + [True] * 30, cleared_at=20) == [(1, False)]


@given(st.lists(st.booleans(), max_size=200), st.integers(-1, 200))
def test_a_link_that_flaps_makes_no_storm(linked: list[bool], cleared_at: int) -> None:
    said = story(linked, cleared_at)
    assert sum(over for _, over in said) <= 1
    times = [minute for minute, over in said if not over]
    # A minute alone at the least before each.
    assert all(not any(linked[minute - 1 : minute + 1]) for minute in times if minute)


class Events:
    def __init__(self) -> None:
        self.told: list[tuple[str, str]] = []

    def report_event(
        self, kind: str, message: str, *, device: str = "", who: str = "", good: bool = False
    ) -> None:
        self.told.append((kind, message))


async def test_an_enclosure_that_is_not_closed_is_told_while_the_hub_is_away(
    tmp_path: Path, peers: tuple[Mailbox, int, Receiver, int]
) -> None:
    mailbox, mail_port, receiver, web_port = peers
    settings = read_notice_settings(written(tmp_path, mail_port, web_port, "after = 60"))
    clock, events = HandClock(), Events()
    ours = OwnNotices(
        settings=settings, site="Hill", clock=clock, linked=lambda: False, events=events
    )
    running = asyncio.ensure_future(ours.run())
    ours.hear_enclosure(EnclosureState(enclosure="dome", why="Dome: NOT CLOSED"))
    clock.advance(61 * SECOND)
    async with asyncio.timeout(PATIENCE_S):
        while len(events.told) < 3:
            await asyncio.sleep(0.01)
    ours.hear_enclosure(EnclosureState(enclosure="dome"))
    async with asyncio.timeout(PATIENCE_S):
        while len(events.told) < 6:
            await asyncio.sleep(0.01)
    running.cancel()
    assert {kind for kind, _ in events.told} == {"notice_sent"}
    assert len(mailbox.got) == len(receiver.got) == 2
    assert "over: Dome: NOT CLOSED" in mailbox.got[1][1]
