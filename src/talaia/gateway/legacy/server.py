"""A door for clients of the founding observatory: its WebSocket messages over TLS, by the gateway.

Closed unless it is asked for, on this machine only unless told otherwise, and nobody comes in
without the token, also from loopback. What comes in goes the way of every command: the gateway's
journal, its interlocks, its limits.
"""

from __future__ import annotations

import asyncio
import base64
import binascii
import hashlib
import hmac
import json
import logging
import os
import secrets
import ssl
from dataclasses import dataclass
from http import HTTPStatus
from typing import TYPE_CHECKING
from urllib.parse import parse_qs, urlsplit

from websockets.asyncio.server import ServerConnection, serve
from websockets.exceptions import ConnectionClosed

from talaia.gateway.errors import SettingsError
from talaia.gateway.legacy.messages import (
    MAX_MESSAGE,
    LegacyRequestError,
    NewestValues,
    read_message,
    status_of,
)
from talaia.wire.frames import CommandPhase, CommandRequest

if TYPE_CHECKING:
    from collections.abc import Mapping
    from pathlib import Path

    from websockets.http11 import Request, Response

    from talaia.clock import Clock
    from talaia.gateway.commands.command_service import CommandService
    from talaia.gateway.legacy.messages import LegacyAction
    from talaia.gateway.ports import EventSink
    from talaia.gateway.settings import LegacySettings
    from talaia.model.site import Site

__all__ = ["LegacyCredentials", "LegacyServer", "keys_of"]

log = logging.getLogger(__name__)
MAX_CLIENTS = 16  # At the same time.
# The founding client asks once a second; more than this from one is not it.
MOST_A_SECOND = 20
# After a wrong token everybody with a wrong one waits: a guesser gets one try a second.
WRONG_S = 1.0
MAX_MISTAKES = 50  # Of one client, until it is sent away.


@dataclass(frozen=True)
class LegacyCredentials:
    """What the door proves itself with, and what it wants to hear.

    Attributes:
        fingerprint: SHA-256 of the certificate, hex.

    """

    context: ssl.SSLContext  # TLS with the certificate; made once.
    token: str  # What a client must say; never logged.
    fingerprint: str


def keys_of(settings: LegacySettings, data: Path) -> LegacyCredentials:
    """Read certificate and token; make what is not given, in the data folder, at the first start.

    Raises:
        SettingsError: a file cannot be read or does not fit.

    """
    certificate, key = settings.certificate, settings.key
    try:
        if certificate is None or key is None:
            certificate, key = data / "classic.crt", data / "classic-tls.key"
            if not certificate.exists():
                _make_certificate(certificate, key)
        token_file = settings.token_file or data / "classic.token"
        if settings.token_file is None and not token_file.exists():
            _write_private(token_file, secrets.token_urlsafe(24).encode() + b"\n")
        token = token_file.read_text().strip()
        # No certificate is asked of clients: they say the token.
        context = ssl.SSLContext(ssl.PROTOCOL_TLS_SERVER)
        # TLS 1.0 and 1.1 are deprecated (RFC 8996).
        context.minimum_version = ssl.TLSVersion.TLSv1_2
        context.load_cert_chain(certificate, key)
        der = ssl.PEM_cert_to_DER_cert(certificate.read_text())
    except (OSError, ValueError) as error:
        raise SettingsError(f"the door for founding clients cannot be opened: {error}") from error
    # Too short to be left open to guessing, even at one try a second.
    if len(token) < 16:
        raise SettingsError(f"{token_file}: expected a token of at least 16 characters")
    return LegacyCredentials(context, token, hashlib.sha256(der).hexdigest())


def _write_private(path: Path, data: bytes) -> None:
    # `O_EXCL` and the mode at once: nobody reads it in between, and no link put there is followed.
    file = os.open(path, os.O_WRONLY | os.O_CREAT | os.O_EXCL, 0o600)
    with os.fdopen(file, "wb") as opened:
        opened.write(data)


def _make_certificate(certificate: Path, key: Path) -> None:
    try:
        from talaia.gateway.legacy.self_signed import self_signed
    except ImportError as error:
        raise SettingsError(
            f"no certificate can be made here ({error}); give --classic-cert and --classic-key, "
            "or install the package cryptography"
        ) from error
    made, secret = self_signed()
    # The key first: only the certificate is looked for, so a crash between makes both anew.
    key.unlink(missing_ok=True)
    _write_private(key, secret)
    _write_private(certificate, made)


class LegacyServer:
    """Serves founding clients for as long as it runs."""

    def __init__(
        self,
        *,
        settings: LegacySettings,
        keys: LegacyCredentials,
        site: Site,
        clock: Clock,
        commands: CommandService,
        newest: NewestValues,
        answers: Mapping[str, str],
        events: EventSink,
    ) -> None:
        """Take what it answers from: the newest values, and what commands have printed."""
        self._settings, self._keys, self._site, self._clock = settings, keys, site, clock
        self._commands, self._newest, self._answers = commands, newest, answers
        self._events = events
        self._clients: set[ServerConnection] = set()  # Admitted, and talking.
        # Held while a wrong token waits: guesses stand in line, from however many addresses.
        self._wrong = asyncio.Lock()
        self.port = settings.port  # The one that was had, when the settings say 0.

    def redescribe(self, site: Site) -> None:
        """Answer by another description from here on."""
        self._site = site

    async def run(self) -> None:
        """Serve until cancelled.

        Raises:
            SettingsError: the port cannot be had.

        """
        host, port = self._settings.host, self._settings.port
        try:
            server = await serve(
                self._serve_client,
                host,
                port,
                ssl=self._keys.context,
                process_request=self._admit_client,
                # Longer messages end the connection before they are in memory whole.
                max_size=MAX_MESSAGE,
                # So many wait unread; then TCP holds the client back.
                max_queue=4,
                # Messages are small, and compression would cost memory for each client.
                compression=None,
                # Strangers are not told what runs here.
                server_header=None,
            )
        except OSError as error:
            raise SettingsError(f"--classic-port {port} cannot be opened: {error}") from error
        async with server:
            self.port = next(iter(server.sockets)).getsockname()[1]
            log.info(
                "founding clients: wss://%s:%d, certificate %s",
                host,
                self.port,
                self._keys.fingerprint,
            )
            await asyncio.Event().wait()

    # ── who comes in ──

    async def _admit_client(self, socket: ServerConnection, request: Request) -> Response | None:
        # Before the token is looked at, so that a crowd costs next to nothing.
        if len(self._clients) >= MAX_CLIENTS:
            return socket.respond(HTTPStatus.SERVICE_UNAVAILABLE, "too many clients\n")
        if self._has_token(request):
            return None
        async with self._wrong:
            # Slept within the lock, and only by those who are wrong: others come in meanwhile.
            await asyncio.sleep(WRONG_S)
        self._events.report_event("classic_refused", f"a wrong token from {_address_of(socket)}")
        response = socket.respond(HTTPStatus.UNAUTHORIZED, "give the token\n")
        # So that an old browser asks for a password, which is the token.
        response.headers["WWW-Authenticate"] = 'Basic realm="observatory"'
        return response

    def _has_token(self, request: Request) -> bool:
        """Look for the token: Bearer, the password of Basic, or ``?token=`` for old browsers."""
        given = ""
        kind, _, value = request.headers.get("Authorization", "").partition(" ")
        if kind.lower() == "bearer":
            given = value.strip()
        elif kind.lower() == "basic":
            try:
                # `user:password`, and the user may be anybody.
                given = base64.b64decode(value, validate=True).decode().partition(":")[2]
            except (binascii.Error, UnicodeDecodeError):
                given = ""
        # A browser's WebSocket can send no header.
        else:
            given = parse_qs(urlsplit(request.path).query).get("token", [""])[0]
        # In constant time: how long it takes must not tell how much of it is right.
        return hmac.compare_digest(given.encode(), self._keys.token.encode())

    # ── what is said ──

    async def _serve_client(self, socket: ServerConnection) -> None:
        self._clients.add(socket)
        try:
            await self._answer_messages(socket)
        # A client that goes away is no error; what it asked for goes on.
        except ConnectionClosed:
            pass
        finally:
            self._clients.discard(socket)

    async def _answer_messages(self, socket: ServerConnection) -> None:
        loop = asyncio.get_running_loop()
        # The loop's clock is monotonic.
        second, count, mistakes = loop.time(), 0, 0
        async for message in socket:
            if loop.time() - second >= 1.0:
                second, count = loop.time(), 0
            count += 1
            if count > MOST_A_SECOND:
                # 1008: against the rules (RFC 6455).
                await socket.close(1008, "too many messages a second")
                return
            answer: dict[str, object] = {}
            try:
                actions = read_message(message, self._site)
                for action in actions:
                    said = await self._begin_action(action, socket)
                    told = answer.setdefault("action", {})
                    if isinstance(told, dict):
                        told.setdefault(action.device, {})[action.command] = said
            except LegacyRequestError as error:
                mistakes += 1
                answer["error"] = str(error)
            now = self._clock.monotonic_ns()
            answer["status"] = status_of(self._site, self._newest, self._answers, now)
            await socket.send(json.dumps(answer, ensure_ascii=False))
            if mistakes > MAX_MISTAKES:
                await socket.close(1008, "too many messages that mean nothing")
                return

    async def _begin_action(self, action: LegacyAction, socket: ServerConnection) -> str:
        """Begin a command; tell whether it began, in the words for people."""
        ask = CommandRequest(
            # Random: no id comes twice, also over restarts.
            id=f"classic-{secrets.token_hex(8)}",
            device=action.device,
            command=action.command,
            args=action.args,
            ttl_ms=5000,
            who=f"founding client at {_address_of(socket)}",
        )
        await self._commands.handle_request(ask)
        state = self._commands.command_state(ask.id)
        if state is None or state.phase is CommandPhase.REFUSED:
            return f"refused: {'' if state is None else state.message}"
        return str(state.phase)


def _address_of(socket: ServerConnection) -> str:
    address = socket.remote_address
    return str(address[0]) if address else "nowhere"
