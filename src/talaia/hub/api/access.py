"""Who is asking, and whether the policy lets them; stands before every route and socket."""

from __future__ import annotations

from typing import TYPE_CHECKING

from fastapi import Request  # noqa: TC002 - FastAPI reads it at run time

from talaia.hub.api.problems import ApiProblem, problem
from talaia.hub.policy import SOCKETS, Need, allows, need_of_route

if TYPE_CHECKING:
    from starlette.requests import HTTPConnection
    from starlette.responses import Response
    from starlette.websockets import WebSocket

    from talaia.hub.auth.permissions import Who
    from talaia.hub.live.sites import LiveSite, Sites
    from talaia.hub.settings import Settings
    from talaia.hub.store.sessions import Sessions
    from talaia.hub.store.sites import GatewayKey, SiteRegistry

__all__ = ["Access", "address_of", "deny", "live_of", "who_of"]


class Access:
    """The guard of the routes, and the doorman of the sockets."""

    def __init__(
        self, sessions: Sessions, sites: Sites, registry: SiteRegistry, settings: Settings
    ) -> None:
        """Know people by ``sessions`` and gateways by ``registry``."""
        self._sessions = sessions
        self._sites = sites
        self._registry = registry
        self._tls = settings.tls
        self._life_s = round(settings.life_s)

    @property
    def cookie(self) -> str:
        """Name of the session's cookie; the prefix makes browsers hold us to its rules."""
        return "__Host-talaia" if self._tls else "talaia"

    def set_cookie(self, response: Response, token: str) -> None:
        """Hand the session to the browser."""
        response.set_cookie(
            self.cookie,
            token,
            max_age=self._life_s,
            path="/",
            secure=self._tls,
            httponly=True,
            samesite="strict",
        )

    def clear_cookie(self, response: Response) -> None:
        """Take the session from the browser."""
        response.delete_cookie(
            self.cookie, path="/", secure=self._tls, httponly=True, samesite="strict"
        )

    async def who(self, connection: HTTPConnection) -> Who | None:
        """Tell who is asking, by the cookie."""
        token = connection.cookies.get(self.cookie)
        return await self._sessions.who(token) if token else None

    async def guard(self, request: Request) -> None:
        """Let a request pass by the policy table's line of its route.

        Raises:
            ApiProblem: 401 nobody is signed in, 403 not for them, 404 there is no such thing,
                which is also what those are told who may not know of it.

        """
        need = need_of_route(request.method, request.scope["route"].path)
        if need is Need.OPEN:
            return
        who = await self.who(request)
        if who is None:
            raise ApiProblem(401, "unauthorized", "sign in first")
        request.state.who = who
        site = request.path_params.get("site")
        live = self._sites.get(site) if site else None
        described = live.description if live else None
        if allows(need, who.grants, described):
            request.state.live = live
            return
        if site and not allows(Need.SEE, who.grants, described):
            raise ApiProblem(404, "unknown", "there is no such site")
        raise ApiProblem(403, "forbidden", "you do not have the right to do this")

    async def admit(self, socket: WebSocket) -> Who | None:
        """Tell who opens a socket; None when they were sent away (401) before the upgrade."""
        need = SOCKETS.get(socket.scope["path"], Need.NEVER)
        who = await self.who(socket)
        if who is None or need not in {Need.SESSION, Need.SEE}:
            await deny(socket, 401, "unauthorized", "sign in first")
            return None
        return who

    async def admit_gateway(self, socket: WebSocket) -> GatewayKey | None:
        """Tell which gateway opens a socket; None when it was sent away (401)."""
        need = SOCKETS.get(socket.scope["path"], Need.NEVER)
        kind, _, key = socket.headers.get("authorization", "").partition(" ")
        found = None
        if need is Need.GATEWAY and kind.lower() == "bearer" and key:
            found = await self._registry.gateway_of(key.strip())
        if found is None:
            await deny(socket, 401, "unauthorized", "this key is not known, or was revoked")
        return found


def who_of(request: Request) -> Who:
    """Give the person the guard has let pass."""
    who: Who = request.state.who
    return who


def address_of(connection: HTTPConnection) -> str:
    """Give the asker's address. The shield has seen to proxies; headers are not believed here."""
    return connection.client.host if connection.client else ""


def live_of(request: Request) -> LiveSite:
    """Give the site the guard has let pass."""
    live: LiveSite = request.state.live
    return live


async def deny(socket: WebSocket, status: int, code: str, message: str) -> None:
    """Send a socket away before the upgrade."""
    await socket.send_denial_response(problem(status, code, message))
