"""Who is asking, and whether the policy lets them; stands before every route and socket.

Long, because every way in, with the cookies and headers by which it knows somebody, is here.
"""

from __future__ import annotations

from typing import TYPE_CHECKING

from fastapi import Request  # noqa: TC002 - FastAPI reads it at run time

from talaia.hub.api.problems import STORE_DOWN, ApiProblem, problem_response
from talaia.hub.errors import StoreDown
from talaia.hub.policy import (
    BEFORE_FACTOR,
    BY_SCRIPT,
    CONFIRMED,
    SOCKETS,
    AccessNeed,
    allows,
    need_of_route,
)
from talaia.hub.store.accounts.displays import DISPLAY_MARK
from talaia.hub.store.accounts.known_browsers import KNOWN_S
from talaia.hub.store.accounts.tokens import MARK

if TYPE_CHECKING:
    from starlette.requests import HTTPConnection
    from starlette.responses import Response
    from starlette.websockets import WebSocket

    from talaia.hub.auth.permissions import Who
    from talaia.hub.live.sites import LiveSite, Sites
    from talaia.hub.settings import Settings
    from talaia.hub.store.accounts.displays import Displays
    from talaia.hub.store.accounts.sessions import LiveSession, Sessions
    from talaia.hub.store.accounts.tokens import ApiTokens

__all__ = [
    "Access",
    "address_of",
    "alive_of",
    "deny_socket",
    "known_live_of",
    "live_of",
    "number_of",
    "who_of",
]

# A page that asks by itself, and not because a person did something, says so with this header.
_BACKGROUND = "talaia-background"
# As long as browsers keep a cookie (RFC 6265bis); a screen that is opened anew gets it anew.
_DISPLAY_S = 400 * 86_400
_FACTOR_FIRST = "your role requires a second factor; set one up first"
# Digits; so many always fit a column of 64 bits.
_LONGEST_NUMBER = 18


class Access:
    """The guard of the routes, and the doorman of the sockets."""

    def __init__(
        self,
        *,
        sessions: Sessions,
        tokens: ApiTokens,
        displays: Displays,
        sites: Sites,
        settings: Settings,
    ) -> None:
        """Know people by ``sessions``, scripts by ``tokens`` and screens by ``displays``."""
        # By whom somebody is known: browsers by their cookie, scripts by their header.
        self._sessions = sessions
        self._tokens = tokens
        self._displays = displays
        # As they are now: a right is held against the description of this moment.
        self._sites = sites
        self._tls = settings.tls
        # The cookie lasts as long as a session may at most; the hub ends an idle one itself (s).
        self._life_s = round(settings.life_s)

    @property
    def cookie(self) -> str:
        """Name of the session's cookie; the prefix makes browsers hold us to its rules."""
        # ``__Host-`` needs Secure, Path=/ and no Domain, so a neighbour of our name cannot set it.
        return "__Host-talaia" if self._tls else "talaia"

    @property
    def browser_cookie(self) -> str:
        """Name of the cookie by which a browser is known from an earlier sign-in."""
        return f"{self.cookie}-browser"

    def set_cookie(self, response: Response, token: str) -> None:
        """Hand the session to the browser."""
        self._hand(response, self.cookie, token, self._life_s)

    def set_display_cookie(self, response: Response, token: str) -> None:
        """Hand a display's token to its browser, in the place of a session."""
        self._hand(response, self.cookie, token, _DISPLAY_S)

    def set_browser_cookie(self, response: Response, token: str) -> None:
        """Let the browser be known at the next sign-in. It opens nothing."""
        self._hand(response, self.browser_cookie, token, KNOWN_S)

    @property
    def oidc_cookie(self) -> str:
        """Name of the cookie by which a browser is known while it is at the provider."""
        return f"{self.cookie}-oidc"

    def set_oidc_cookie(self, response: Response, token: str) -> None:
        """Let the browser be known when it comes back from the provider. It opens nothing."""
        self._hand(response, self.oidc_cookie, token, 600)

    def clear_cookie(self, response: Response) -> None:
        """Take the session from the browser."""
        response.delete_cookie(
            self.cookie, path="/", secure=self._tls, httponly=True, samesite="strict"
        )

    async def identify_caller(self, connection: HTTPConnection) -> LiveSession | None:
        """Tell who is asking: by the token where one is sent, else by the cookie.

        Raises:
            StoreDown: nobody can be known now.

        """
        kind, _, key = connection.headers.get("authorization", "").partition(" ")
        if kind.lower() == "bearer":
            # Whoever sends a token means it: a cookie beside it does not help.
            return await self.who_of_token(key.strip())
        token = connection.cookies.get(self.cookie)
        # Only as a cookie: it opens no door of other tools.
        if token is not None and token.startswith(DISPLAY_MARK):
            return await self._displays.find_session(token)
        # Only what a person does keeps a session alive; sockets report their use by themselves.
        used = connection.headers.get(_BACKGROUND) != "1" and connection.scope["type"] == "http"
        return await self._sessions.find_session(token, used=used) if token else None

    async def who_of_token(self, token: str) -> LiveSession | None:
        """Tell for whom a token speaks; None when it is none of ours, or not good any more.

        Raises:
            StoreDown: it cannot be told now.

        """
        return await self._tokens.find_session(token) if token.startswith(MARK) else None

    async def guard_request(self, request: Request) -> None:
        """Let a request pass by the policy table's line of its route.

        Raises:
            ApiProblem: 401 nobody is signed in, 403 not for them, 404 there is no such thing,
                which is also what those are told who may not know of it, 422 no database
                could look for it.
            StoreDown: it cannot be told who asks.

        """
        # By the route's own path with its placeholders, never by what was typed.
        need = need_of_route(request.method, request.scope["route"].path)
        # A client's token is asked for by the guard after this one, which knows what is open.
        if need in {AccessNeed.OPEN, AccessNeed.CLIENT}:
            return
        # PostgreSQL takes no NUL in a text; it would come out as an error of ours.
        if b"%00" in request.scope["query_string"]:
            raise ApiProblem(422, "invalid", "the query holds the character NUL")
        alive = await self.identify_caller(request)
        if alive is None:
            raise ApiProblem(401, "unauthorized", "sign in first")
        who = alive.who
        # For the routes and for the limits, which ask after this.
        request.state.alive, request.state.who = alive, who
        # It only looks, also where the one line of a route is for looking and for doing.
        if who.display and request.method not in {"GET", "HEAD"}:
            raise ApiProblem(403, "forbidden", "a display only shows; sign in to do something")
        # Before the rights: whatever its person may, a token may not.
        if who.script and need not in BY_SCRIPT:
            raise ApiProblem(403, "forbidden", "a token may not do this; sign in yourself")
        # Whatever the rights: until then it could be anybody who knows the password.
        open_now = (request.method, request.scope["route"].path) in BEFORE_FACTOR
        if who.factor_missing and not open_now:
            raise ApiProblem(403, "factor_required", _FACTOR_FIRST)
        site = request.path_params.get("site")
        # None also for a site that is not known; `allows` then lets only admins of everything pass.
        live = self._sites.find_site(site) if site else None
        described = live.description if live else None
        if allows(need, who.grants, described):
            request.state.live = live
            self._require_confirmation(request, who)
            return
        # The same words whether it is hidden or not there at all.
        if site and not allows(AccessNeed.SEE, who.grants, described):
            raise ApiProblem(404, "unknown", "there is no such site")
        raise ApiProblem(403, "forbidden", "you do not have the right to do this")

    def _require_confirmation(self, request: Request, who: Who) -> None:
        """Ask for the password anew before rights are given away.

        Raises:
            ApiProblem: 403 ``confirm``, it was not given lately; for scripts 403 ``forbidden``.

        """
        if (request.method, request.scope["route"].path) not in CONFIRMED:
            return
        if who.script:
            raise ApiProblem(403, "forbidden", "a token may not do this; sign in yourself")
        if not self._sessions.is_confirmed(who.session):
            raise ApiProblem(403, "confirm", "confirm first that it is you: POST /api/me/confirm")

    async def admit_socket(self, socket: WebSocket) -> Who | None:
        """Tell who opens a socket; None when they were sent away before the upgrade."""
        # A socket that has no line in the policy table lets nobody in.
        need = SOCKETS.get(socket.scope["path"], AccessNeed.NEVER)
        try:
            alive = await self.identify_caller(socket)
        except StoreDown:
            await deny_socket(socket, status=503, code="store", message=STORE_DOWN)
            return None
        # Of a stream, which site it is of is not known here; its own route looks.
        looked_at = {AccessNeed.SESSION, AccessNeed.SEE, AccessNeed.UNBLURRED}
        if alive is None or need not in looked_at:
            await deny_socket(socket, status=401, code="unauthorized", message="sign in first")
            return None
        if alive.who.factor_missing:
            await deny_socket(socket, status=403, code="factor_required", message=_FACTOR_FIRST)
            return None
        return alive.who

    def _hand(self, response: Response, name: str, token: str, life_s: int) -> None:
        response.set_cookie(
            name,
            token,
            max_age=life_s,
            path="/",
            secure=self._tls,
            # Not for scripts, and not sent along when another site's page asks.
            httponly=True,
            samesite="strict",
        )


def who_of(request: Request) -> Who:
    """Give the person the guard has let pass."""
    return alive_of(request).who


def alive_of(request: Request) -> LiveSession:
    """Give the session of the person the guard has let pass."""
    alive: LiveSession = request.state.alive
    return alive


def address_of(connection: HTTPConnection) -> str:
    """Give the asker's address. The shield has seen to proxies; headers are not believed here."""
    return connection.client.host if connection.client else ""


def live_of(request: Request) -> LiveSite:
    """Give the site the guard has let pass."""
    live: LiveSite = request.state.live
    return live


def known_live_of(request: Request) -> LiveSite:
    """Give the site of a request that an admin may make about any name, known or not.

    Raises:
        ApiProblem: 404, there is no such site.

    """
    live: LiveSite | None = request.state.live
    if live is None:
        raise ApiProblem(404, "unknown", "there is no such site")
    return live


def number_of(text: str, what: str) -> int:
    """Read an id of a path.

    Raises:
        ApiProblem: 404, it can be no id.

    """
    # `int` would also take other scripts' digits, signs, spaces and underscores.
    if not (text.isascii() and text.isdecimal()) or len(text) > _LONGEST_NUMBER:
        raise ApiProblem(404, "unknown", f"there is no such {what}")
    return int(text)


async def deny_socket(
    socket: WebSocket, *, status: int, code: str, message: str, retry_s: int = 0
) -> None:
    """Send a socket away before the upgrade; ``retry_s`` says when to come back."""
    await socket.send_denial_response(problem_response(status, code, message, retry_s))
