"""A process that sends one message and ends: ``python -m talaia.hub.notify.child``.

It reads a job (JSON) from its input and writes how it went (JSON) to its output. A process of its
own, because the libraries of the ways out resolve names by themselves: here `socket.getaddrinfo`
itself gives no address that messages may not go to, so that nothing can be reached by another
name, by a redirect, or by a name that means something else the second time it is asked. And one
that hangs is ended without harm to the hub.

Long, because every way out is here, behind the same guard.
"""

from __future__ import annotations

import base64
import contextlib
import http.client
import ipaddress
import json
import logging
import os
import re
import smtplib
import socket
import ssl
import sys
import time
from email.message import EmailMessage
from email.utils import formatdate
from typing import TYPE_CHECKING, Any, NamedTuple
from urllib.parse import SplitResult, urlsplit

import msgspec

from talaia.hub.notify.address_policy import AddressRefused, may_reach

if TYPE_CHECKING:
    from collections.abc import Callable, Iterator

__all__ = ["main"]

# For each answer of a server (s).
_PATIENCE_S = 15.0
Job = dict[str, Any]  # what `Sender.send_message` writes
Outcome = dict[str, str]
# Services that apprise may speak to for us.
# Others would speak to this machine itself (syslog, dbus), not to a person elsewhere.
_CHATS = ("ntfy", "ntfys", "matrix", "matrixs", "tgram")
# As apprise logs a status other than success: the server did not take it.
_ANSWERED = re.compile(r"error=\d{3}")


class _Left:
    """Whether a word of the message may have left this machine, and what was not let through."""

    def __init__(self) -> None:
        # Set by `_watch_output`; reset where only now the message itself begins.
        self.yes = False
        # The last address that was not let through; another try would not be, either.
        self.refused: AddressRefused | None = None


def main() -> None:
    """Do the job that stands on the input."""
    job: Job = json.load(sys.stdin)
    # Both before any library of a way is imported, which could keep the functions of before.
    left = _watch_output(_words_of(job))
    _guard([ipaddress.ip_network(network) for network in job["networks"]], left)
    try:
        outcome = _WAYS[job["kind"]](job, left)
    except Exception as error:  # noqa: BLE001 - said to whoever asked, whatever it is
        outcome = _make_outcome("unsure" if left.yes else "again", _describe_error(error))
    # Libraries say in words of their own that nothing answered; the refusal is the reason.
    if left.refused is not None and outcome["outcome"] == "again":
        outcome = _make_outcome("failed", str(left.refused))
    json.dump(outcome, sys.stdout)


def _make_outcome(outcome: str, problem: str = "") -> Outcome:
    """Say how it went.

    ``sent``; ``again``: it has certainly not arrived, another try may do; ``failed``: it has not,
    and another try will not do; ``unsure``: it may have arrived.
    """
    return {"outcome": outcome, "problem": problem[:1500]}


def _guard(networks: list[ipaddress.IPv4Network | ipaddress.IPv6Network], left: _Left) -> None:
    # The one that asks; ours is put in its place below.
    resolve = socket.getaddrinfo

    def guarded(host: Any, *args: Any, **kwargs: Any) -> Any:  # noqa: ANN401 - as it is there
        found = resolve(host, *args, **kwargs)
        # Checked where the address is given out, so that nobody asks a second time.
        allowed = [info for info in found if may_reach(str(info[4][0]), networks)]
        if found and not allowed:
            left.refused = AddressRefused(str(host), str(found[0][4][0]))
            raise left.refused
        return allowed

    socket.getaddrinfo = guarded
    connect, connect_ex = socket.socket.connect, socket.socket.connect_ex

    def check_address(family: int, address: Any) -> None:  # noqa: ANN401 - as it is there
        # An extension may name an address without a look-up.
        if family in (socket.AF_INET, socket.AF_INET6):
            host = str(address[0])
            if _is_address(host) and not may_reach(host, networks):
                left.refused = AddressRefused(host, host)
                raise left.refused

    def reached(self: socket.socket, address: Any) -> None:  # noqa: ANN401 - as it is there
        check_address(self.family, address)
        connect(self, address)

    def reached_ex(self: socket.socket, address: Any) -> int:  # noqa: ANN401 - as it is there
        # Raises although this one gives numbers: a number would not say why.
        check_address(self.family, address)
        return connect_ex(self, address)

    socket.socket.connect = reached  # type: ignore[method-assign, assignment]
    socket.socket.connect_ex = reached_ex  # type: ignore[method-assign, assignment]


def _is_address(text: str) -> bool:
    try:
        ipaddress.ip_address(text.partition("%")[0])
    except ValueError:
        return False
    return True


def _words_of(job: Job) -> bytes:
    """Give what only the message itself has, of whatever goes out; empty: all of it may be it."""
    # Before it, Matrix is signed in to and its room is joined, which nobody reads.
    return b"/send/" if job["kind"] == "chat" and job["url"].lower().startswith("matrix") else b""


def _watch_output(words: bytes) -> _Left:
    """Notice the first word of the message that goes out over any connection."""
    left = _Left()
    # smtplib and http.client write by `sendall`; a TLS handshake does not go through it.
    for kind in (socket.socket, ssl.SSLSocket):
        send: Callable[..., None] = kind.sendall

        # Bound now: by the name alone both would call the last one's.
        def noticed(self: socket.socket, data: Any, *args: Any, send: Any = send) -> None:  # noqa: ANN401
            left.yes = left.yes or words in bytes(data)
            send(self, data, *args)

        kind.sendall = noticed  # type: ignore[method-assign, assignment]
    return left


def _describe_error(error: BaseException) -> str:
    return f"{type(error).__name__}: {error}" if str(error) else type(error).__name__


def _send_mail(job: Job, left: _Left) -> Outcome:
    message = EmailMessage()
    message["From"] = job["sender"]
    message["To"] = job["target"]
    message["Subject"] = job["title"]
    message["Date"] = formatdate()
    # Sent twice it is the same message, for a server that looks.
    message["Message-ID"] = f"<{job['key']}@talaia.invalid>"
    # RFC 3834: no holiday notice answers it.
    message["Auto-Submitted"] = "auto-generated"
    message.set_content(job["body"])
    if job.get("picture"):
        data = base64.b64decode(job["picture"])
        message.add_attachment(data, maintype="image", subtype="jpeg", filename="seen.jpg")
    if job.get("file"):
        name, text = job["file"]
        # As base64: no server on the way wraps its lines or changes their ends.
        message.add_attachment(text, filename=name, cte="base64")
    # Until the text itself goes out, nothing of the message has left.
    accepted = False
    try:
        with _connect_smtp(job) as server:
            if job.get("user"):
                server.login(job["user"], job["password"])
            # One address, and nothing else may hide in it.
            server.mail(job["sender"])
            code, said = server.rcpt(job["target"])
            # 251: not a local user, and it will forward (RFC 5321, 4.2.3).
            if code not in {250, 251}:
                return _make_outcome(
                    _by_code(code), f"{job['target']} is refused: {code} {_decode_reply(said)}"
                )
            # What went out until here was the sign-in and the addresses.
            left.yes = False
            accepted = True
            # smtplib mends the line ends of texts only, not of bytes.
            code, said = server.data(message.as_bytes(policy=message.policy.clone(linesep="\r\n")))
            if code != 250:
                return _make_outcome(
                    _by_code(code), f"the message is refused: {code} {_decode_reply(said)}"
                )
            return _make_outcome("sent")
    except smtplib.SMTPDataError as error:
        return _make_outcome(
            _by_code(error.smtp_code), f"{error.smtp_code} {_decode_reply(error.smtp_error)}"
        )
    except smtplib.SMTPResponseException as error:
        return _make_outcome(
            _by_code(error.smtp_code), f"{error.smtp_code} {_decode_reply(error.smtp_error)}"
        )
    except (OSError, smtplib.SMTPException) as error:
        return _make_outcome("unsure" if accepted else "again", _describe_error(error))


@contextlib.contextmanager
def _connect_smtp(job: Job) -> Iterator[smtplib.SMTP]:
    """Connect; TLS unless the admin chose otherwise, and never a password without it."""
    security, host, port = job["security"], job["host"], int(job["port"])
    # Checks the server's certificate and name.
    context = ssl.create_default_context()
    if security == "tls":
        server: smtplib.SMTP = smtplib.SMTP_SSL(host, port, timeout=_PATIENCE_S, context=context)
    else:
        server = smtplib.SMTP(host, port, timeout=_PATIENCE_S)
    try:
        # Raises where the server has no STARTTLS; it never goes on in the clear.
        if security == "starttls":
            server.starttls(context=context)
        elif security == "none" and job.get("user"):
            raise smtplib.SMTPException("a password is not sent without TLS; choose TLS")
        server.ehlo_or_helo_if_needed()
        yield server
    finally:
        # It was accepted or refused before; how the farewell goes is no matter.
        with contextlib.suppress(OSError, smtplib.SMTPException):
            server.quit()


# RFC 5321, 4.2.1: 4yz may do later, 5yz will not. Below 0, smtplib could not read the reply.
def _by_code(code: int) -> str:
    return "again" if 400 <= code < 500 or code < 0 else "failed"


def _decode_reply(said: bytes | str) -> str:
    return said.decode("utf-8", "replace") if isinstance(said, bytes) else said


def _send_webhook(job: Job, left: _Left) -> Outcome:
    try:
        parts = urlsplit(job["url"])
        # Read here: a port is checked only when it is asked for.
        port = parts.port
    except ValueError as error:
        # No other try would read it.
        return _make_outcome("failed", f"the address is not valid: {error}")
    if parts.scheme not in {"http", "https"} or not parts.hostname:
        return _make_outcome("failed", "the address does not begin with https:// or http://")
    keys = ("key", "title", "body", "severity", "sites")
    # A document that is no message goes as it is.
    document = job.get("document") or {key: job[key] for key in keys}
    if job.get("picture"):
        # JPEG as base64; a webhook that shows none passes it over.
        document["picture"] = job["picture"]
    body = json.dumps(document).encode()
    headers = {
        "Content-Type": "application/json",
        "User-Agent": "Talaia",
        # Of the same message sent again the other side can tell by this.
        "Idempotency-Key": job["key"],
    }
    if job.get("token"):
        headers["Authorization"] = f"Bearer {job['token']}"
    answer = _post(parts, port, body, headers)
    if isinstance(answer, OSError | http.client.HTTPException):
        return _make_outcome("unsure" if left.yes else "again", _describe_error(answer))
    # A redirect is none of these.
    if 200 <= answer.status < 300:
        return _make_outcome("sent")
    # Not followed: it could lead anywhere.
    return _make_outcome(_by_status(answer.status), f"it answered {answer}")


class _Answer(NamedTuple):
    """What a server of HTTP said."""

    status: int
    reason: str
    text: str

    def __str__(self) -> str:
        return f"{self.status} {self.reason}: {self.text}"


def _post(
    parts: SplitResult, port: int | None, body: bytes, headers: dict[str, str]
) -> _Answer | OSError | http.client.HTTPException:
    """Post; the standard library's follows no redirect and reads no proxy from the environment."""
    kind = http.client.HTTPSConnection if parts.scheme == "https" else http.client.HTTPConnection
    connection = kind(parts.hostname or "", port, timeout=_PATIENCE_S)
    try:
        path = (parts.path or "/") + (f"?{parts.query}" if parts.query else "")
        connection.request("POST", path, body, headers)
        answer = connection.getresponse()
        # Enough for its reason, whatever it sends.
        said = answer.read(300).decode("utf-8", "replace")
    except (OSError, http.client.HTTPException) as error:
        return error
    finally:
        connection.close()
    return _Answer(answer.status, answer.reason, said)


def _by_status(status: int) -> str:
    return "again" if status >= 500 or status == 429 else "failed"


def _send_chat(job: Job, left: _Left) -> Outcome:
    try:
        import apprise
    except ModuleNotFoundError as error:
        return _make_outcome(
            "failed",
            f"chats need the Python package {error.name!r}, which is not installed; on the hub's "
            "machine run: pip install 'talaia[chats]'",
        )
    scheme = job["url"].partition("://")[0].lower()
    if scheme not in _CHATS:
        return _make_outcome("failed", f"{scheme!r} is none of {', '.join(_CHATS)}")
    # apprise tells why only in its log, so that is listened to.
    said: list[str] = []
    handler = logging.Handler(logging.WARNING)
    handler.emit = lambda record: said.append(record.getMessage())  # type: ignore[method-assign]
    logger = logging.getLogger("apprise")
    logger.addHandler(handler)
    logger.setLevel(logging.INFO)
    service = apprise.Apprise(asset=apprise.AppriseAsset(secure_logging=True, app_id="Talaia"))
    if not service.add(job["url"]):
        return _make_outcome("failed", "; ".join(said) or "the address is not understood")
    targets = len(service[0])
    if targets > 1:
        # Of a part that failed could not be told which, and the rest would come twice.
        return _make_outcome("failed", f"it names {targets} targets; make a way for each of them")
    kinds = {"critical": apprise.NotifyType.FAILURE, "warning": apprise.NotifyType.WARNING}
    done = service.notify(
        title=job["title"],
        body=job["body"],
        notify_type=kinds.get(job["severity"], apprise.NotifyType.INFO),
        body_format=apprise.NotifyFormat.TEXT,
    )
    if done:
        return _make_outcome("sent")
    problem = "; ".join(said) or "the service did not take it"
    if left.yes and not _ANSWERED.search(problem):
        return _make_outcome("unsure", problem)
    return _make_outcome("again", problem)


def _send_push(job: Job, left: _Left) -> Outcome:
    """Send to every browser of the person; one that has gone away is named for removal."""
    gone, problems, outcomes = [], [], set()
    for number, subscription in job["browsers"]:
        # Each browser has a push service of its own.
        left.yes = False
        try:
            parts, body, headers = _seal_push(job, subscription)
            answer = _post(parts, parts.port, body, headers)
        except ValueError as error:
            # Of an address or of keys that a browser gave; no other try would read them.
            outcomes.add("failed")
            problems.append(str(error))
            continue
        if isinstance(answer, OSError | http.client.HTTPException):
            outcomes.add("unsure" if left.yes else "again")
            problems.append(_describe_error(answer))
        elif 200 <= answer.status < 300:
            outcomes.add("sent")
        else:
            # The subscription is over: the person, or the browser, ended it.
            if answer.status in {404, 410}:
                gone.append(number)
            outcomes.add(_by_status(answer.status))
            problems.append(f"a browser's push service answered {answer}")
    # One browser that has it is enough; else what may have arrived is not sent again.
    best = next(
        (outcome for outcome in ("sent", "unsure", "again") if outcome in outcomes), "failed"
    )
    problem = "; ".join(problems) or "no browser of yours takes messages yet"
    outcome = _make_outcome(best, "" if best == "sent" else problem)
    return {**outcome, "gone": ",".join(str(number) for number in gone)}


def _seal_push(job: Job, subscription: dict[str, str]) -> tuple[SplitResult, bytes, dict[str, str]]:
    # Only this way needs the library behind it.
    from cryptography.hazmat.primitives.asymmetric import ec

    from talaia.hub.notify.sealed_push import seal_message, vouch_for

    said = {key: job[key] for key in ("key", "title", "body", "severity", "open")}
    # A push service need not take more than 4096 bytes, sealed (RFC 8030, 7.2).
    said["body"] = said["body"][:1500]
    # The picture itself would not fit: the browser asks the hub for it, as its person.
    if job.get("picture_path"):
        said["picture"] = job["picture_path"]
    endpoint = subscription["endpoint"]
    parts = urlsplit(endpoint)
    if parts.scheme not in {"http", "https"} or not parts.hostname:
        raise ValueError("a browser's push service has no address of https://")
    key = ec.generate_private_key(ec.SECP256R1())
    sealed = seal_message(json.dumps(said).encode(), subscription, key, os.urandom(16))
    headers = {
        "Authorization": vouch_for(endpoint, job["subject"], job["private_key"], time.time()),
        "Content-Encoding": "aes128gcm",
        "Content-Type": "application/octet-stream",
        # For a browser that is off the service keeps it for a day (s).
        "TTL": "86400",
        # RFC 8030, 5.3 and 5.4: a phone wakes up for it, and sent again it replaces itself.
        "Urgency": "high",
        "Topic": job["key"][:32],
    }
    return parts, sealed, headers


def _send_extension(job: Job, left: _Left) -> Outcome:
    from talaia.extensions.declarations import NotDelivered, NotifierMessage
    from talaia.extensions.installed import installed_extensions

    name = job["extension"]
    known = installed_extensions().notifiers_by_name().get(name)
    if known is None:
        said = "; ".join(
            str(extension)
            for extension in installed_extensions().list_broken()
            if extension.name == name
        )
        return _make_outcome(
            "failed", said or f"the extension {name!r} is not installed at this hub"
        )
    message = NotifierMessage(
        job["key"], job["title"], job["body"], job["severity"], tuple(job["sites"]), job["open"]
    )
    try:
        # Checked again: the extension may be another version than when they were set.
        keys = msgspec.convert(json.loads(job.get("keys", "{}")), known.keys, strict=False)
    except msgspec.ValidationError as error:
        return _make_outcome("failed", f"the keys of {name!r} do not fit: {error}")
    try:
        # What it prints is no answer of ours.
        with contextlib.redirect_stdout(sys.stderr):
            known.send(keys, message)
    except NotDelivered as error:
        return _make_outcome("again" if error.again else "failed", str(error))
    except Exception as error:  # noqa: BLE001 - said to whoever asked, whatever it is
        if left.refused is not None:
            return _make_outcome("failed", str(left.refused))
        # Not sent again: nobody knows how far it came.
        return _make_outcome("unsure", f"the extension {name!r} failed: {_describe_error(error)}")
    return _make_outcome("sent")


_WAYS: dict[str, Callable[[Job, _Left], Outcome]] = {
    "mail": _send_mail,
    "webhook": _send_webhook,
    "chat": _send_chat,
    "push": _send_push,
    "extension": _send_extension,
}

if __name__ == "__main__":
    main()
