"""Who may connect with another tool: by token, from the origins that an admin has named."""

from __future__ import annotations

import base64
import binascii
from contextlib import asynccontextmanager
from typing import TYPE_CHECKING, NamedTuple

from talaia.hub.api.access import deny_socket
from talaia.hub.api.problems import STORE_DOWN, ApiProblem
from talaia.hub.api.rate_limits import MOST_SOCKETS
from talaia.hub.api.server.request_guard import HIDDEN_TOKEN
from talaia.hub.errors import StoreDown
from talaia.hub.policy import CLIENT_ROUTES, AccessNeed, allows, need_of_route

if TYPE_CHECKING:
    from collections.abc import AsyncIterator
    from contextlib import AbstractContextManager

    from starlette.requests import HTTPConnection, Request
    from starlette.websockets import WebSocket

    from talaia.hub.api.access import Access
    from talaia.hub.api.rate_limits import RateLimits
    from talaia.hub.auth.permissions import Who
    from talaia.hub.clients.open_protocols import OpenProtocols
    from talaia.hub.live.sites import LiveSite, Sites
    from talaia.hub.ports import DescribedSites
    from talaia.hub.store.accounts.sessions import LiveSession

__all__ = ["AdmittedClient", "ClientAdmission", "token_of"]


class AdmittedClient(NamedTuple):
    """A client that may connect: who it speaks for, to which site, and of which page's origin."""

    who: Who
    live: LiveSite
    origin: str | None


class ClientAdmission:
    """Lets clients of other tools in, or says why not."""

    def __init__(
        self,
        *,
        access: Access,
        limits: RateLimits,
        protocols: OpenProtocols,
        sites: Sites,
        known: DescribedSites,
    ) -> None:
        """Know tokens by ``access``; what is open stands in ``protocols``.

        Clients connect to ``sites``; ``known`` are those of other shards, too.
        """
        self._known = known
        # Tokens only: what a browser sends by itself does not count here.
        self._access = access
        # The same counts as for pages, by person.
        self._limits = limits
        self._protocols = protocols
        self._sites = sites

    async def identify_account(self, connection: HTTPConnection, protocol: str) -> Who:
        """Give the account of a request or socket of a protocol.

        Raises:
            ApiProblem: as of `find_session`.
            StoreDown: it cannot be told whose token it is.

        """
        return (await self.find_session(connection, protocol)).who

    async def find_session(self, connection: HTTPConnection, protocol: str) -> LiveSession:
        """Give what a token stands for in a request or socket of a protocol.

        Raises:
            ApiProblem: 403 the protocol is shut or the page's origin is not let in, 401 there is
                no good token.
            StoreDown: it cannot be told whose token it is.

        """
        # First: a protocol that is shut looks nothing up for anybody.
        if not self._protocols.is_open(protocol):
            raise ApiProblem(
                403, "shut", "an admin has to open this protocol first (Admin, Clients)"
            )
        if not self._protocols.lets_in(protocol, connection.headers.get("origin")):
            raise ApiProblem(
                403, "origin", "pages of this origin are not let in; an admin may (Admin, Clients)"
            )
        # Its rights are what is left of the person's by now.
        alive = await self._access.who_of_token(token_of(connection))
        if alive is None:
            raise ApiProblem(401, "unauthorized", "no token, or one that is not good; see Account")
        return alive

    async def guard_request(self, request: Request) -> None:
        """Let a request pass that is none of a client's, or that brings a client's good token.

        Raises:
            ApiProblem: as of `find_session`.
            StoreDown: it cannot be told whose token it is.

        """
        path = request.scope["route"].path
        if need_of_route(request.method, path) is AccessNeed.CLIENT:
            # For the route and for the limits, as `Access.guard_request` leaves it.
            alive = await self.find_session(request, CLIENT_ROUTES[path])
            request.state.alive, request.state.who = alive, alive.who

    def site_for(self, who: Who, name: str) -> LiveSite:
        """Give a site that an account may see something of.

        Raises:
            ApiProblem: 404 there is none such, or it is not for them.

        """
        live = self._sites.find_site(name)
        if live is None or not allows(AccessNeed.SEE, who.grants, live.description):
            raise ApiProblem(404, "unknown", "there is no such site")
        return live

    def choose_site(self, who: Who, name: str) -> LiveSite:
        """Give the named site, or without a name the only one that an account may see.

        Raises:
            ApiProblem: 404 as of `site_for`; 400 there are several.

        """
        if name:
            return self.site_for(who, name)
        seen = [
            site for site in self._known if allows(AccessNeed.SEE, who.grants, site.description)
        ]
        live = self._sites.find_site(seen[0].name) if len(seen) == 1 else None
        # The only one may be of another shard, which is found by its name alone.
        if live is None:
            names = ", ".join(site.name for site in seen) or "none"
            raise ApiProblem(400, "site", f"put site=… into the address; there are: {names}")
        return live

    def count_connection(self, who: Who) -> AbstractContextManager[bool]:
        """Count a connection while it is open, as a page's; gives False when it is too many."""
        return self._limits.count_socket(who)

    @asynccontextmanager
    async def admit_client(
        self, socket: WebSocket, protocol: str
    ) -> AsyncIterator[AdmittedClient | None]:
        """Give who opens a socket at a site, and count it while it is open; None: sent away."""
        try:
            who = await self.identify_account(socket, protocol)
            live = self.site_for(who, socket.path_params["site"])
        except ApiProblem as no:
            await deny_socket(socket, status=no.status, code=no.code, message=no.message)
            yield None
            return
        except StoreDown:
            await deny_socket(socket, status=503, code="store", message=STORE_DOWN, retry_s=2)
            yield None
            return
        # Counted for as long as the caller serves it.
        with self._limits.count_socket(who) as allowed:
            if not allowed:
                message = f"at most {MOST_SOCKETS} connections at once"
                await deny_socket(socket, status=429, code="busy", message=message)
            origin = socket.headers.get("origin")
            yield AdmittedClient(who, live, origin) if allowed else None


def token_of(connection: HTTPConnection) -> str:
    """Give the token of a client; empty if it brings none. Cookies do not count.

    By ``Authorization``, as bearer or as the password of HTTP basic, else by the address, for
    clients that know nothing else.
    """
    kind, _, said = connection.headers.get("authorization", "").partition(" ")
    match kind.lower():
        case "bearer":
            return said.strip()
        case "basic":
            try:
                decoded = base64.b64decode(said.strip(), validate=True).decode()
            except (binascii.Error, UnicodeDecodeError):
                return ""
            # The user's name is for people; the token knows whose it is.
            return decoded.partition(":")[2]
        case _:
            pass
    # `RequestGuard` has taken it out of the address.
    hidden = connection.scope.get(HIDDEN_TOKEN, "")
    return hidden if isinstance(hidden, str) else ""
