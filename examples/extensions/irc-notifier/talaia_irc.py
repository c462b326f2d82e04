"""A notifier that writes alarms into an IRC channel (RFC 1459)."""

from __future__ import annotations

import re
import socket
import ssl
from typing import TYPE_CHECKING

from talaia.extend.notifier import ExtensionKeys, NotDelivered, NotifierExtension

if TYPE_CHECKING:
    from talaia.extend.notifier import NotifierMessage

# A line of IRC has at most 512 bytes, of which the server adds some.
MAX_TEXT = 400
PATIENCE_S = 20.0


class IrcKeys(ExtensionKeys, frozen=True, kw_only=True):
    """What an admin fills in.

    Attributes:
        host: the server.
        port: its port; 6697 is TLS by custom.
        channel: where to, with its sign: #observatory.
        nick: the name to write under.
        password: the server's, if it wants one.
        tls: false only inside a network of your own.

    """

    host: str
    channel: str
    port: int = 6697
    nick: str = "talaia"
    password: str = ""
    tls: bool = True

    def __post_init__(self) -> None:
        """Refuse what would be another command of the protocol."""
        if not re.fullmatch(r"[#&+!][^\s,:\x00-\x1f]{1,49}", self.channel):
            raise ValueError("channel: expected a name such as #observatory")
        if not re.fullmatch(r"[A-Za-z\[\]\\`_^{|}][-A-Za-z0-9\[\]\\`_^{|}]{0,29}", self.nick):
            raise ValueError("nick: expected a name such as talaia")
        if re.search(r"[\s\x00]", self.password):
            raise ValueError("password: there may be no spaces in it")


def send(keys: IrcKeys, message: NotifierMessage) -> None:
    """Join the channel, write the message line by line, and leave."""
    try:
        connection = socket.create_connection((keys.host, keys.port), timeout=PATIENCE_S)
    except OSError as error:
        raise NotDelivered(f"{keys.host}: {error}") from error
    with connection:
        if keys.tls:
            try:
                context = ssl.create_default_context()
                connection = context.wrap_socket(connection, server_hostname=keys.host)
            except OSError as error:
                raise NotDelivered(f"{keys.host}: {error}") from error
        with connection, connection.makefile("r", encoding="utf-8", errors="replace") as replies:
            _enter(keys, connection, replies)
            # From here on it may arrive; whatever goes wrong now is not tried again.
            for line in (message.title, *message.body.splitlines()):
                _write(connection, f"PRIVMSG {keys.channel} :{_plain(line)[:MAX_TEXT]}")
            _write(connection, "QUIT :done")
            for line in replies:
                if " ERROR " in f" {line}":
                    break


def _enter(keys: IrcKeys, connection: socket.socket, replies: object) -> None:
    try:
        if keys.password:
            _write(connection, f"PASS {keys.password}")
        _write(connection, f"NICK {keys.nick}")
        _write(connection, f"USER {keys.nick} 0 * :Talaia")
        for line in replies:  # type: ignore[attr-defined]
            words = line.split()
            if words[:1] == ["PING"]:
                _write(connection, f"PONG {words[-1]}")
            elif words[1:2] == ["001"]:
                _write(connection, f"JOIN {keys.channel}")
            elif words[1:2] == ["366"]:
                return
            elif len(words) > 1 and words[1].isdigit() and words[1] >= "400":
                # Such as 433, the name is in use; 471 to 475, the channel cannot be joined.
                raise NotDelivered(f"{keys.host} answers: {line.strip()}")
    except OSError as error:
        raise NotDelivered(f"{keys.host}: {error}") from error
    raise NotDelivered(f"{keys.host} closed the connection")


def _write(connection: socket.socket, line: str) -> None:
    connection.sendall(f"{line}\r\n".encode())


def _plain(text: str) -> str:
    """Leave out control characters: a line end would begin another command."""
    return "".join(letter if letter.isprintable() else " " for letter in text) or " "


extension = NotifierExtension(
    api=1,
    summary="a channel of an IRC server",
    keys=IrcKeys,
    send=send,
    secret=frozenset({"password"}),
)
