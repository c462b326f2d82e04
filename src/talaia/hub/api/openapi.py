"""The HTTP API as OpenAPI: each route with the right it needs and every answer it may give."""

from __future__ import annotations

import copy
import re
from http import HTTPStatus
from typing import TYPE_CHECKING, Any

from talaia import __version__
from talaia.hub.api.shapes import ProblemShape
from talaia.hub.policy import Need, need_of_route

if TYPE_CHECKING:
    from collections.abc import Iterator, Mapping

    from fastapi import FastAPI

__all__ = ["RIGHTS", "describe_api", "operations"]

# What a need is in words.
RIGHTS: Mapping[Need, str] = {
    Need.OPEN: "Nobody has to be signed in.",
    Need.SESSION: "Anyone who is signed in.",
    Need.SEE: "Anyone to whom the site, or something of it, is open.",
    Need.VIEW: "The right `view` on the site.",
    Need.USE: "The right `use` on the site.",
    Need.ADMIN: "The right `admin` on the whole hub.",
}
# Answers beyond those that follow from a route's need, its method and its parameters.
_ALSO: Mapping[tuple[str, str], tuple[int, ...]] = {
    ("POST", "/api/login"): (401, 429),
    ("POST", "/api/setup"): (403, 429),
    ("POST", "/api/gateways/{gateway}/revoke"): (409,),
    ("POST", "/api/gateways/{gateway}/reconnect"): (409,),
    ("POST", "/api/enrol"): (404, 410, 429),
}
# What the shield may say to any request: length, size, name of the host.
_ALWAYS = (411, 413, 421)
_UNSAFE = (403, 415)
_METHODS = frozenset({"get", "post", "put", "patch", "delete"})
_PROBLEM = {"application/problem+json": {"schema": {"$ref": "#/components/schemas/ProblemShape"}}}


def describe_api(app: FastAPI) -> dict[str, Any]:
    """Describe every route of the API; the pages themselves are left out."""
    api = copy.deepcopy(app.openapi())
    api["info"]["version"] = __version__
    schemas = api.setdefault("components", {}).setdefault("schemas", {})
    # FastAPI's own form of a 422, which ours takes the place of.
    for name in ("HTTPValidationError", "ValidationError"):
        schemas.pop(name, None)
    schemas["ProblemShape"] = ProblemShape.model_json_schema()
    api["components"]["securitySchemes"] = {
        "session": {"type": "apiKey", "in": "cookie", "name": "__Host-talaia"}
    }
    for method, path, operation in operations(api):
        need = need_of_route(method, path)
        right = RIGHTS.get(need, "Nobody.")
        operation["description"] = f"{operation.get('description', '')}\n\n*Right:* {right}".strip()
        operation["x-talaia-need"] = need.name.lower()
        if need is not Need.OPEN:
            operation["security"] = [{"session": []}]
        answers = operation["responses"]
        for status in sorted(_statuses(method, path, need, operation)):
            phrase = HTTPStatus(status).phrase
            answers[str(status)] = {"description": phrase, "content": _PROBLEM}
    return api


def operations(api: Mapping[str, Any]) -> Iterator[tuple[str, str, dict[str, Any]]]:
    """Go through the method, the path and the description of each route."""
    for path, said in api["paths"].items():
        for method, operation in said.items():
            if method in _METHODS:
                yield method.upper(), path, operation


def _statuses(method: str, path: str, need: Need, operation: Mapping[str, Any]) -> set[int]:
    statuses = {*_ALWAYS, *_ALSO.get((method, path), ())}
    if method != "GET":
        statuses.update(_UNSAFE)
    if need is not Need.OPEN:
        # Nobody is signed in; they have asked too much at once.
        statuses.update((401, 429))
    if need in {Need.VIEW, Need.USE, Need.ADMIN}:
        statuses.add(403)
    if re.search(r"\{\w+\}", path):
        statuses.add(404)
    if "requestBody" in operation:
        statuses.add(400)
    if "requestBody" in operation or operation.get("parameters"):
        statuses.add(422)
    return statuses
