"""Sessions of Google's Map Tiles API, made with the owner's key; browsers then ask it for tiles.

The key goes to the pages with the session, since each tile is asked for with it: its owner limits
it to this hub's address and to that API, as the how-to page says.
"""

from __future__ import annotations

import json
import ssl
from typing import TYPE_CHECKING, NamedTuple
from urllib.parse import quote

from talaia.hub.auth.provider_client import ask_address
from talaia.hub.errors import HubError
from talaia.hub.store.sites.map_sources import GOOGLE_HOST

if TYPE_CHECKING:
    import httpx

    from talaia.clock import Clock

__all__ = ["GoogleSession", "GoogleSessions", "SessionRefused"]

_TIMEOUT_S = 10.0
_MOST_ANSWER = 64 * 1024
# One that is nearly over would end while somebody looks (µs).
_SPARE_US = 3600 * 1_000_000
_ASKED = {"mapType": "roadmap", "language": "en-GB", "region": "GB"}


class SessionRefused(HubError):
    """No session was given; a sentence for people."""


class GoogleSession(NamedTuple):
    """The address of tiles, with ``{z}``, ``{x}`` and ``{y}``, and until when it holds (µs)."""

    tiles: str
    ends_us: int


class GoogleSessions:
    """Makes them, and keeps each until it is nearly over: sessions last about two weeks."""

    def __init__(self, clock: Clock, origin: str = GOOGLE_HOST) -> None:
        """Ask at ``origin``, which is Google's but in tests."""
        self._clock = clock
        self._origin = origin
        self._known: dict[str, GoogleSession] = {}

    async def open_session(self, key: str) -> GoogleSession:
        """Give a session of a key.

        Raises:
            SessionRefused: Google does not answer, or does not take the key.

        """
        known = self._known.get(key)
        now_us = self._clock.wall_ns() // 1000
        if known is not None and known.ends_us - _SPARE_US > now_us:
            return known
        said = await self._ask(key)
        try:
            token, ends_us = str(said["session"]), int(str(said["expiry"])) * 1_000_000
        except (KeyError, ValueError) as error:
            raise SessionRefused("Google's answer names no session") from error
        tiles = (
            f"{self._origin}/v1/2dtiles/{{z}}/{{x}}/{{y}}"
            f"?session={quote(token, safe='')}&key={quote(key, safe='')}"
        )
        made = GoogleSession(tiles, ends_us)
        # Keys are few: those of sources that an admin keeps.
        self._known = {old: one for old, one in self._known.items() if one.ends_us > now_us} | {
            key: made
        }
        return made

    async def _ask(self, key: str) -> dict[str, object]:
        url = f"{self._origin}/v1/createSession?key={quote(key, safe='')}"

        def build(client: httpx.AsyncClient) -> httpx.Request:
            return client.build_request("POST", url, json=_ASKED)

        secure = url.startswith("https:")
        try:
            status, body = await ask_address(
                url,
                build,
                verify=ssl.create_default_context() if secure else False,
                timeout_s=_TIMEOUT_S,
                most=_MOST_ANSWER,
            )
            said = json.loads(body)
        except (OSError, ValueError, RecursionError) as error:
            # Never the address: the key is in it.
            raise SessionRefused("Google does not answer; is the hub without internet?") from error
        if status != 200 or not isinstance(said, dict):
            reason = said.get("error", {}) if isinstance(said, dict) else {}
            told = str(reason.get("message", ""))[:200] if isinstance(reason, dict) else ""
            raise SessionRefused(f"Google refuses the key ({status}): {told or 'no reason given'}")
        return said
