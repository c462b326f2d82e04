"""Sign-ins that are awaited back from the provider; each comes once. Pure but for chance."""

from __future__ import annotations

import base64
import hashlib
import secrets
from dataclasses import dataclass
from enum import StrEnum

from talaia.clock import SECOND

__all__ = ["AwaitedSignIn", "OidcPurpose", "OidcStates"]

# To sign in at the provider, with a second factor there, may take a person a while.
_LIFE_NS = 600 * SECOND
# Beyond so many the oldest are forgotten: anybody may begin one.
_MOST = 10_000


class OidcPurpose(StrEnum):
    """What is done when the person comes back."""

    SIGN_IN = "sign_in"
    # To give rights away: it must have been a fresh sign-in.
    CONFIRM = "confirm"
    # From now on the person may sign in like this.
    CONNECT = "connect"


@dataclass(frozen=True, slots=True, kw_only=True)
class AwaitedSignIn:
    """One that is under way.

    Attributes:
        state: comes back from the provider as it went.
        nonce: has to stand in the token.
        verifier: whose hash the provider has (PKCE).
        browser: hash of what the browser that began it keeps in a cookie.
        session: of the person who began it; empty for a sign-in.
        redirect: to where the provider sends the browser back.
        returns: the page that was asked for.
        begun_ns: monotonic.

    """

    state: str
    nonce: str
    verifier: str
    browser: str
    purpose: OidcPurpose
    session: str
    redirect: str
    returns: str
    begun_ns: int

    @property
    def challenge(self) -> str:
        """What of the verifier the provider is told (S256)."""
        digest = hashlib.sha256(self.verifier.encode()).digest()
        return base64.urlsafe_b64encode(digest).rstrip(b"=").decode()


class OidcStates:
    """Those that are under way, in memory: after a restart they are begun again."""

    def __init__(self) -> None:
        """Begin with none."""
        # In the order in which they were begun.
        self._awaited: dict[str, AwaitedSignIn] = {}

    def begin(
        self,
        purpose: OidcPurpose,
        now_ns: int,
        *,
        browser: str,
        redirect: str,
        returns: str = "/",
        session: str = "",
    ) -> AwaitedSignIn:
        """Begin one."""
        begun = AwaitedSignIn(
            state=secrets.token_urlsafe(32),
            nonce=secrets.token_urlsafe(32),
            # 43 characters at least are asked for (RFC 7636, 4.1).
            verifier=secrets.token_urlsafe(48),
            browser=browser,
            purpose=purpose,
            session=session,
            redirect=redirect,
            returns=returns,
            begun_ns=now_ns,
        )
        self._awaited[begun.state] = begun
        while len(self._awaited) > _MOST:
            del self._awaited[next(iter(self._awaited))]
        return begun

    def redeem(self, state: str, browser: str, now_ns: int) -> AwaitedSignIn | None:
        """Take one back; None when it is unknown, used, too old, or another browser's."""
        found = self._awaited.get(state)
        # One that another browser brings stays for its own: who has read the address of somebody
        # else must not end their sign-in.
        if found is None or not browser or not secrets.compare_digest(found.browser, browser):
            return None
        del self._awaited[state]
        return found if now_ns - found.begun_ns <= _LIFE_NS else None
