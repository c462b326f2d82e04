"""The description of the HTTP API: every route with the right it needs and all it may answer."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

from fastapi import APIRouter, FastAPI, Request

from talaia import __version__
from talaia.hub.api.guarded_routes import GuardedRoute
from talaia.hub.api.schemas.common import ProblemShape
from talaia.hub.policy import BY_SCRIPT, AccessNeed, need_of_route

if TYPE_CHECKING:
    from collections.abc import Mapping

__all__ = ["ApiDescription", "describe_api", "needs_in_words"]

_PROBLEM = "ProblemShape"
_SESSION, _TOKEN = "session", "token"  # names of the schemes in the description
_SCHEMES = {
    _SESSION: {
        "type": "apiKey",
        "in": "cookie",
        "name": "__Host-talaia",
        "description": "Set by POST /api/login (without its prefix on a hub that speaks plain).",
    },
    _TOKEN: {
        "type": "http",
        "scheme": "bearer",
        "description": "A token of POST /api/me/tokens, with some of its person's rights.",
    },
}
_NEEDS: Mapping[AccessNeed, str] = {
    AccessNeed.OPEN: "Nothing: nobody has to be signed in.",
    AccessNeed.SESSION: "To be signed in, by a session or a token.",
    AccessNeed.OWN: "To be signed in oneself; a token does not do.",
    AccessNeed.SEE: "That the site, or something of it, is public or open to you.",
    AccessNeed.VIEW: "The right to view the site.",
    AccessNeed.USE: "The right to use the site.",
    AccessNeed.ADMIN: "The right to manage the whole hub.",
    AccessNeed.REQUEST: "The right to ask for observations at the site.",
    AccessNeed.APPROVE: "The right to approve observations at the site; a token does not do.",
    AccessNeed.ARM: "The right to let the site's nights run; a token does not do.",
    AccessNeed.CLIENT: "A token, while an admin has opened the client protocol; no session.",
}
# What each status means here, whatever route says it.
_SAID: Mapping[int, str] = {
    400: "The body is no JSON.",
    401: "Nobody is signed in, or name, password or code is wrong.",
    403: "You may not do this, or a page of another origin asked.",
    404: "There is no such thing, or it is not yours to know of.",
    409: "It cannot be done as things are; the code says why.",
    410: "It was good once, and is not any more.",
    411: "The body does not say how long it is.",
    413: "The body is too large.",
    415: "The body is not sent as JSON.",
    421: "The hub is not known by that name.",
    422: "The request is not as described here, or what it says breaks a rule.",
    429: "Too much at once, or too many wrong tries; Retry-After says how long to wait.",
    500: "The hub could not do it; the message says why.",
    502: "The provider of sign-ins does not answer as one.",
    503: "The hub's database does not answer, so nothing is done.",
}
# What `RequestGuard` and the check of the parameters may answer anywhere.
_ANYONE = frozenset({400, 411, 413, 421, 422})
# What these may answer besides what follows from their method and need.
_BESIDES: Mapping[tuple[str, str], frozenset[int]] = {
    ("POST", "/api/boards"): frozenset({409}),
    ("PUT", "/api/boards/{board}"): frozenset({409}),
    ("DELETE", "/api/boards/{board}"): frozenset({409}),
    ("PUT", "/api/boards/{board}/share"): frozenset({409}),
    ("PUT", "/api/boards/{board}/public"): frozenset({409}),
    ("POST", "/api/boards/{board}/versions/{number}/restore"): frozenset({409}),
    ("POST", "/api/login"): frozenset({401, 429, 503}),
    ("POST", "/api/login/passkey"): frozenset({401, 429, 503}),
    ("POST", "/api/login/passkey/options"): frozenset({401, 409, 429, 503}),
    ("POST", "/api/login/oidc"): frozenset({404, 502}),
    ("POST", "/api/login/oidc/finish"): frozenset({401, 403, 404, 503}),
    ("POST", "/api/me/oidc/confirm"): frozenset({404, 502}),
    ("POST", "/api/me/oidc/connect"): frozenset({404, 502}),
    ("POST", "/api/me/password"): frozenset({409}),
    ("POST", "/api/me/passkeys"): frozenset({409}),
    ("POST", "/api/me/passkeys/options"): frozenset({409}),
    ("POST", "/api/me/passkeys/challenge"): frozenset({409}),
    ("DELETE", "/api/me/passkeys/{passkey}"): frozenset({404, 409}),
    ("PUT", "/api/roles/{role}/factor"): frozenset({409}),
    ("POST", "/api/setup"): frozenset({429, 503}),
    ("POST", "/api/enrol"): frozenset({404, 410, 429, 503}),
    ("POST", "/clients/prometheus/read"): frozenset({400}),
    ("GET", "/socket.io/"): frozenset({400, 404}),
    ("POST", "/socket.io/"): frozenset({400}),
    ("PUT", "/api/client-drivers"): frozenset({404}),
    ("POST", "/api/me/factor"): frozenset({409}),
    ("POST", "/api/me/factor/remove"): frozenset({409}),
    ("POST", "/api/me/tokens"): frozenset({409}),
    ("POST", "/api/displays"): frozenset({409}),
    ("POST", "/api/audit/hubs"): frozenset({409}),
    ("POST", "/api/heads"): frozenset({401, 429, 503}),
    ("PATCH", "/api/me/passkeys/{passkey}"): frozenset({404}),
    ("DELETE", "/api/me/oidc"): frozenset({409}),
    ("DELETE", "/api/people/{person}/oidc"): frozenset({409}),
    ("POST", "/api/displays/open"): frozenset({401, 429}),
    ("POST", "/api/people"): frozenset({409}),
    ("PATCH", "/api/people/{person}"): frozenset({409}),
    ("DELETE", "/api/people/{person}"): frozenset({409}),
    ("DELETE", "/api/people/{person}/factor"): frozenset({409}),
    ("POST", "/api/roles"): frozenset({409}),
    ("PUT", "/api/roles/{role}"): frozenset({409}),
    ("DELETE", "/api/roles/{role}"): frozenset({409}),
    ("POST", "/api/gateways/{gateway}/revoke"): frozenset({409}),
    ("POST", "/api/gateways/{gateway}/reconnect"): frozenset({409}),
    ("POST", "/api/gateways/{gateway}/second"): frozenset({409}),
    ("POST", "/api/rollouts"): frozenset({409}),
    ("POST", "/api/support-bundle"): frozenset({409, 500}),
    ("POST", "/api/rollouts/stop"): frozenset({409}),
    ("POST", "/api/sites/{site}/descriptions"): frozenset({409}),
    ("POST", "/api/sites/{site}/descriptions/{number}/restore"): frozenset({409}),
    ("POST", "/api/sites/{site}/alarms/{alarm}/act"): frozenset({409}),
    ("PUT", "/api/sites/{site}/alarms/{alarm}"): frozenset({409}),
    ("DELETE", "/api/sites/{site}/alarms/{alarm}"): frozenset({409}),
    ("POST", "/api/sites/{site}/recordings"): frozenset({409}),
    ("GET", "/api/sites/{site}/recordings/{recording}/file"): frozenset({409}),
    ("GET", "/api/sites/{site}/films/{recording}/file"): frozenset({409}),
    ("GET", "/api/sites/{site}/films/{recording}/picture"): frozenset({409}),
    ("POST", "/api/sites/{site}/notes"): frozenset({409}),
    ("PUT", "/api/sites/{site}/notes/{note}"): frozenset({409}),
    ("POST", "/api/sites/{site}/missions"): frozenset({409}),
    ("POST", "/api/sites/{site}/missions/{mission}/start"): frozenset({409}),
    ("POST", "/api/sites/{site}/mission-runs/act"): frozenset({409}),
    ("POST", "/api/sites/{site}/proposals"): frozenset({409}),
    ("DELETE", "/api/sites/{site}/proposals/{proposal}"): frozenset({409}),
    ("PUT", "/api/sites/{site}/request-groups/{group}"): frozenset({409}),
    ("POST", "/api/sites/{site}/request-groups/{group}/submit"): frozenset({409}),
    ("POST", "/api/sites/{site}/request-groups/{group}/withdraw"): frozenset({409}),
    ("POST", "/api/sites/{site}/request-groups/{group}/approve"): frozenset({409}),
    ("POST", "/api/sites/{site}/request-groups/{group}/cancel"): frozenset({409}),
    ("POST", "/api/sites/{site}/request-groups/{group}/retry"): frozenset({409}),
    ("GET", "/api/sites/{site}/night/forecast"): frozenset({409}),
    ("GET", "/api/sites/{site}/night/week"): frozenset({409}),
    ("POST", "/api/sites/{site}/night/short"): frozenset({409}),
    ("POST", "/api/sites/{site}/night/arm"): frozenset({409}),
    ("POST", "/api/sites/{site}/night/disarm"): frozenset({409}),
    ("POST", "/api/me/rules"): frozenset({409}),
    ("POST", "/api/me/push"): frozenset({409}),
    ("POST", "/api/ways"): frozenset({409}),
    ("PUT", "/api/ways/{way}"): frozenset({409}),
}


class ApiDescription:
    """The route that gives the description, to those who manage the hub."""

    def __init__(self) -> None:
        """Describe nothing yet: the first request does, when all routes are there."""
        # Made once, and the same for all: the routes do not change while the hub runs.
        self._said: dict[str, Any] | None = None

    def make_router(self) -> APIRouter:
        """Give the route."""
        router = APIRouter(route_class=GuardedRoute)
        router.get("/api/openapi.json")(self.description)
        return router

    def description(self, request: Request) -> dict[str, Any]:
        """Describe the API."""
        if self._said is None:
            self._said = describe_api(request.app)
        return self._said


def describe_api(app: FastAPI) -> dict[str, Any]:
    """Describe every route of ``app`` but the pages (OpenAPI 3.1)."""
    said = app.openapi()
    said["info"] = {
        "title": "Talaia hub",
        "version": __version__,
        "description": "Times ending in `_us` are microseconds since the epoch (UTC). What changes"
        " something is sent as JSON from a page of the hub's own origin.",
        "license": {"name": "Apache-2.0", "identifier": "Apache-2.0"},
    }
    schemas = said.setdefault("components", {}).setdefault("schemas", {})
    schemas[_PROBLEM] = ProblemShape.model_json_schema()
    # FastAPI's own form of a 422, which is never sent; see `problems`.
    for unused in ("HTTPValidationError", "ValidationError"):
        schemas.pop(unused, None)
    said["components"]["securitySchemes"] = _SCHEMES
    for path, methods in said["paths"].items():
        for method, operation in methods.items():
            _complete_operation(operation, method.upper(), path)
    return said


def needs_in_words(method: str, path: str) -> str:
    """Say in a sentence what a route takes."""
    return _NEEDS[need_of_route(method, path)]


def _complete_operation(operation: dict[str, Any], method: str, path: str) -> None:
    need = need_of_route(method, path)
    operation["x-talaia-need"] = need.name.lower()
    operation["description"] = (
        f"{operation.get('description', '').strip()}\n\nNeeds: {_NEEDS[need]}".strip()
    )
    if need is AccessNeed.OPEN:
        operation["security"] = []
    elif need is AccessNeed.CLIENT:
        operation["security"] = [{_TOKEN: []}]
    else:
        schemes = [_SESSION, _TOKEN] if need in BY_SCRIPT else [_SESSION]
        operation["security"] = [{scheme: []} for scheme in schemes]
    for status in sorted(_error_statuses(need, method, path, body="requestBody" in operation)):
        operation["responses"][str(status)] = _error_answer(status)
    operation["responses"] = dict(sorted(operation["responses"].items()))


def _error_statuses(need: AccessNeed, method: str, path: str, *, body: bool) -> frozenset[int]:
    """Give the statuses by which a route may say no."""
    statuses = set(_ANYONE)
    if need is not AccessNeed.OPEN:
        # Nobody signed in, no right, too much asked, or a database that cannot tell.
        statuses |= {401, 403, 429, 503}
    if method != "GET":
        # `RequestGuard` looks where a page comes from, and at the type of the body.
        statuses |= {403, 415}
    # What a path or a channel names may not be there, or not for this person.
    if "{" in path or path.endswith("/history"):
        statuses.add(404)
    if not body:
        statuses.discard(400)
    return frozenset(statuses) | _BESIDES.get((method, path), frozenset())


def _error_answer(status: int) -> dict[str, Any]:
    answer: dict[str, Any] = {
        "description": _SAID[status],
        "content": {
            "application/problem+json": {"schema": {"$ref": f"#/components/schemas/{_PROBLEM}"}}
        },
    }
    if status in {429, 503}:
        answer["headers"] = {
            "Retry-After": {"description": "Seconds.", "schema": {"type": "integer"}}
        }
    return answer
