"""The API's description, made once in a process for all hubs of the tests with the same routes."""

from __future__ import annotations

import json
from typing import TYPE_CHECKING, Any

from fastapi.routing import iter_route_contexts

from talaia.hub.api.openapi import describe_api

if TYPE_CHECKING:
    from fastapi import FastAPI

# By what is described; as text, so that whoever changes a description has one of their own.
_kept: dict[frozenset[str], str] = {}


def kept_description(app: FastAPI) -> dict[str, Any]:
    """Describe an application as `describe_api` does, which computes seconds."""
    routes = frozenset(
        f"{sorted(context.methods or ())} {context.path}"
        for context in iter_route_contexts(app.router.routes)
    )
    if routes not in _kept:
        _kept[routes] = json.dumps(describe_api(app))
    described: dict[str, Any] = json.loads(_kept[routes])
    return described
