"""Sends notices: mail, webhook, a command. Each by itself, so that one that hangs holds up none."""

from __future__ import annotations

import asyncio
import contextlib
import datetime as dt
import json
import smtplib
import ssl
import urllib.request
from email.message import EmailMessage
from email.utils import formatdate, make_msgid
from typing import TYPE_CHECKING

from talaia.errors import TalaiaError
from talaia.gateway.notices.settings import secret_of

if TYPE_CHECKING:
    from collections.abc import Awaitable

    from talaia.gateway.notices.settings import CommandWay, MailWay, NoticeSettings, WebhookWay
    from talaia.gateway.notices.standing_notices import GatewayNotice

__all__ = ["send_notice"]

# Of each wait for a server, and of a command from begin to end (s).
WITHIN_S = 20.0


async def send_notice(settings: NoticeSettings, site: str, notice: GatewayNotice) -> dict[str, str]:
    """Send by every way at once; give by way what went wrong, empty where it arrived."""
    # By name: two ways to the same server are told apart.
    ways: dict[str, Awaitable[None]] = {}
    for index, mail in enumerate(settings.mail):
        name = f"mail {index + 1} ({mail.server})"
        # Threads of their own, for these libraries block.
        ways[name] = asyncio.to_thread(_send_mail, mail, site, notice)
    for index, hook in enumerate(settings.webhook):
        ways[f"webhook {index + 1}"] = asyncio.to_thread(_post_notice, hook, site, notice)
    for index, command in enumerate(settings.command):
        name = f"command {index + 1} ({command.words[0]})"
        ways[name] = _run_command(command, site, notice)
    outcomes = await asyncio.gather(*ways.values(), return_exceptions=True)
    said: dict[str, str] = {}
    for name, outcome in zip(ways, outcomes, strict=True):
        # A cancellation is passed on; all else is that way's failure alone.
        if isinstance(outcome, BaseException) and not isinstance(outcome, Exception):
            raise outcome
        said[name] = f"{type(outcome).__name__}: {outcome}" if outcome is not None else ""
    return said


def _notice_title(site: str, notice: GatewayNotice) -> str:
    # In one line: a break would not be allowed in a mail's subject.
    return f"{site}: {notice.message}".replace("\n", " ")[:200]


def _notice_body(site: str, notice: GatewayNotice) -> str:
    moment = dt.datetime.fromtimestamp(notice.time_us / 1e6, dt.UTC)
    return f"{moment:%Y-%m-%d %H:%M:%S} UTC  {_notice_title(site, notice)}\n\n{notice.teller}"


def _notice_json(site: str, notice: GatewayNotice) -> bytes:
    return json.dumps(
        {
            "key": notice.key,
            "title": _notice_title(site, notice),
            "body": _notice_body(site, notice),
            "severity": "critical",
            "sites": [site],
            "time_us": notice.time_us,
            "over": notice.over,
        }
    ).encode()


def _send_mail(way: MailWay, site: str, notice: GatewayNotice) -> None:
    message = EmailMessage()
    message["From"], message["To"] = way.sender, ", ".join(way.to)
    message["Subject"] = _notice_title(site, notice)
    # A domain of its own: the default asks the network for this machine's name, which may hang.
    message["Date"], message["Message-ID"] = formatdate(), make_msgid(domain="talaia.invalid")
    message.set_content(_notice_body(site, notice))
    # Read for each mail, so that it can be changed while the gateway runs.
    password = secret_of(way.password_file, way.password_env)
    # Checks name and authority; without it a password could go to anybody.
    context = ssl.create_default_context()
    with contextlib.ExitStack() as stack:
        if way.security == "tls":
            server: smtplib.SMTP = smtplib.SMTP_SSL(
                way.server, way.port, timeout=WITHIN_S, context=context
            )
        else:
            server = smtplib.SMTP(way.server, way.port, timeout=WITHIN_S)
        stack.enter_context(server)
        if way.security == "starttls":
            # Raises when the server has no TLS, so a password never goes in the clear.
            server.starttls(context=context)
        if way.user:
            server.login(way.user, password)
        server.send_message(message)


class _NoRedirect(urllib.request.HTTPRedirectHandler):
    """A token goes where it was meant to go, and nowhere else."""

    def redirect_request(self, *_: object) -> None:
        return None


def _post_notice(way: WebhookWay, site: str, notice: GatewayNotice) -> None:
    # The same key for the same notice, so that a receiver can drop what comes twice.
    headers = {"Content-Type": "application/json", "Idempotency-Key": notice.key}
    if token := secret_of(way.token_file, way.token_env):
        headers["Authorization"] = f"Bearer {token}"
    # The settings take http and https only.
    request = urllib.request.Request(way.url, _notice_json(site, notice), headers, method="POST")  # noqa: S310
    with urllib.request.build_opener(_NoRedirect).open(request, timeout=WITHIN_S):
        pass


async def _run_command(way: CommandWay, site: str, notice: GatewayNotice) -> None:
    process = await asyncio.create_subprocess_exec(
        *way.words, stdin=asyncio.subprocess.PIPE, stdout=asyncio.subprocess.DEVNULL
    )
    try:
        async with asyncio.timeout(WITHIN_S):
            # On its input, not in its arguments, which everybody on the machine can see.
            await process.communicate(_notice_json(site, notice))
    finally:
        # Also when it is cancelled: no program is left behind.
        if process.returncode is None:
            process.kill()
            await process.wait()
    # A status that is not 0 is a notice that did not arrive.
    if process.returncode:
        raise CommandFailed(process.returncode)


class CommandFailed(TalaiaError):
    """A command that should have told people ended badly."""

    def __init__(self, status: int) -> None:
        """Take its exit status."""
        super().__init__(status)
        self.status = status

    def __str__(self) -> str:
        return f"it ended with {self.status}"
