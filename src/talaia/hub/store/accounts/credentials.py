"""Who is signed in, people and scripts alike."""

from __future__ import annotations

from typing import TYPE_CHECKING

if TYPE_CHECKING:
    from collections.abc import Collection

    from talaia.hub.store.accounts.displays import Displays
    from talaia.hub.store.accounts.mission_accounts import MissionAccounts
    from talaia.hub.store.accounts.sessions import LiveSession, Sessions
    from talaia.hub.store.accounts.tokens import ApiTokens

__all__ = ["Credentials"]


class Credentials:
    """Sessions, tokens, displays and missions by the names that a `Who` carries."""

    def __init__(
        self, sessions: Sessions, tokens: ApiTokens, displays: Displays, missions: MissionAccounts
    ) -> None:
        """Ask all four."""
        self._sessions = sessions
        self._tokens = tokens
        self._displays = displays
        self._missions = missions

    async def live_sessions(self, keys: Collection[str]) -> dict[str, LiveSession]:
        """Give those that are alive, with their rights of now."""
        return {
            **await self._sessions.live_sessions(keys),
            **await self._tokens.live_sessions(keys),
            **await self._displays.live_sessions(keys),
            **await self._missions.live_sessions(keys),
        }

    async def mark_used(self, used: Collection[LiveSession]) -> int:
        """Write down that sessions are used; give when they end if nobody does any more (µs)."""
        return await self._sessions.mark_used(used)
