"""Sends signed heads of the audit log to another hub, which keeps them.

The lines are taken from the file in the data folder, and how far they were sent stands beside it:
while the other hub is away they gather, and a line that comes twice does no harm there.
"""

from __future__ import annotations

import asyncio
import ssl
from contextlib import suppress
from pathlib import Path
from typing import TYPE_CHECKING
from urllib.parse import urlsplit

import msgspec

from talaia.certificate_pin import has_fingerprint, trust_only
from talaia.hub.auth.audit_heads import read_head
from talaia.hub.auth.provider_client import EndlessAnswer, ask_address
from talaia.hub.notify.audit_heads import HEADS_FILE
from talaia.hub.notify.head_file import read_head_piece, write_note
from talaia.hub.notify.head_trouble import HeadTrouble

if TYPE_CHECKING:
    from talaia.clock import Clock
    from talaia.hub.notify.audit_hub_settings import AuditHubSettings
    from talaia.hub.store.audit import Audit

__all__ = ["SENT_FILE", "HeadForwarder"]

# In the data folder: how far the heads were sent, and to which hub.
SENT_FILE = "audit-sent.json"
# Between two looks whether there are new heads (s).
_LOOK_S = 60.0
# Without new heads the other hub hears so often that this one is there (µs).
_ALIVE_US = 3_600_000_000
_TIMEOUT_S = 15.0
# Of one question: some 400 lines (bytes).
_MOST_BYTES = 96 * 1024
_MOST_TOKEN = 1000
# Of an answer (bytes).
_MOST_ANSWER = 64 * 1024


class _Sent(msgspec.Struct, frozen=True):
    """How far it came: bytes of the file, and the hub that has them."""

    url: str = ""
    at: int = 0


class _Refusal(msgspec.Struct):
    """What of a hub's answer says why not."""

    message: str = ""


class HeadForwarder:
    """Sends heads to one other hub."""

    def __init__(
        self, *, folder: Path, settings: AuditHubSettings, public: str, audit: Audit, clock: Clock
    ) -> None:
        """Send what lies in ``folder`` to the hub of ``settings``, with the key of the heads."""
        self._folder = folder
        self._settings = settings
        self._public = public
        self._trouble = HeadTrouble(audit)
        self._clock = clock
        # When the other hub last had anything of this one (monotonic); None: not since the start.
        self._heard_us: int | None = None

    async def run(self) -> None:
        """Send now and then, until cancelled."""
        while True:
            await self.send_new()
            await asyncio.sleep(_LOOK_S)

    async def send_new(self) -> bool:
        """Send what is new; tell whether the other hub has all.

        What goes wrong is told in the log and the audit log, once until it is mended.
        """
        try:
            while await self._send_piece():
                pass
        except (OSError, ssl.SSLError, ValueError) as error:
            self._trouble.show(self._settings.url, str(error) or type(error).__name__)
            return False
        self._trouble.show(self._settings.url, "")
        return True

    async def _send_piece(self) -> bool:
        """Send one piece; tell whether there may be more."""
        sent = await asyncio.to_thread(self._read_sent)
        piece = await asyncio.to_thread(
            read_head_piece, self._folder / HEADS_FILE, sent.at, _MOST_BYTES
        )
        now_us = self._clock.monotonic_ns() // 1000
        quiet = self._heard_us is not None and now_us - self._heard_us < _ALIVE_US
        if piece is None and quiet:
            return False
        # Also without lines: so the other hub knows silence from having nothing to say.
        await self._post(_whole_heads(piece.text, self._public) if piece else [])
        self._heard_us = now_us
        if piece is None:
            return False
        note = msgspec.json.encode(_Sent(self._settings.url, piece.end))
        await asyncio.to_thread(write_note, self._folder / SENT_FILE, note)
        return True

    async def _post(self, lines: list[str]) -> None:
        """Ask the other hub to keep lines.

        Raises:
            OSError: it does not answer, or does not keep them.
            ValueError: what it answers cannot be read.

        """
        url = f"{self._settings.url}/api/heads"
        token = await asyncio.to_thread(self._read_token)
        verify = await asyncio.to_thread(self._make_context)
        said = {"token": token, "key": self._public, "lines": lines}
        try:
            status, body = await ask_address(
                url,
                lambda client: client.build_request("POST", url, json=said),
                verify=verify,
                timeout_s=_TIMEOUT_S,
                most=_MOST_ANSWER,
            )
        except EndlessAnswer:
            raise
        except OSError as error:
            raise OSError(f"it does not answer: {error}") from error
        if status != 200:
            try:
                why = msgspec.json.decode(body, type=_Refusal).message
            except msgspec.DecodeError:
                why = "it is no hub"
            raise OSError(f"it refuses ({status}): {why[:300]}")

    def _read_token(self) -> str:
        with Path(self._settings.token_file).open("rb") as file:
            return file.read(_MOST_TOKEN).decode("ascii", "replace").strip()

    def _make_context(self) -> ssl.SSLContext | bool:
        """Give what the other hub's certificate is held against; blocks."""
        found = urlsplit(self._settings.url)
        if found.scheme == "http":
            return False
        if not self._settings.fingerprint:
            return ssl.create_default_context(cafile=self._settings.ca or None)
        # Nothing is sent here: the certificate is looked at, and then the only one that counts.
        # Each time, for a renewed one has the same key.
        address = (found.hostname or "", found.port or 443)
        shown = ssl.PEM_cert_to_DER_cert(ssl.get_server_certificate(address, timeout=_TIMEOUT_S))
        if not has_fingerprint(shown, self._settings.fingerprint):
            raise OSError("it shows another certificate than the one known")
        return trust_only(shown)

    def _read_sent(self) -> _Sent:
        fresh = _Sent(self._settings.url)
        try:
            found = msgspec.json.decode((self._folder / SENT_FILE).read_bytes(), type=_Sent)
        except (FileNotFoundError, msgspec.DecodeError, UnicodeDecodeError):
            return fresh
        # Another hub has none of them yet.
        return found if found.url == self._settings.url else fresh


def _whole_heads(text: str, public: str) -> list[str]:
    """Give the lines that are heads of a key; there are others of a crash, or of a key before."""
    found = []
    for line in text.splitlines():
        with suppress(ValueError):
            if read_head(line, public) is not None:
                found.append(line)
    return found
