"""The mock hub's passkeys, displays, provider of sign-ins and logs of other hubs.

A passkey is kept whatever the browser answers; the provider is there and signs nobody in.
"""

from __future__ import annotations

import secrets
import time
from typing import TYPE_CHECKING, Any

from fastapi import APIRouter, Request, Response

if TYPE_CHECKING:
    from accounts_side import Accounts

DONE = 204
HOUR_US = 3_600 * 10**6


def now_us() -> int:
    """Give the time (µs UTC)."""
    return int(time.time() * 1e6)


def keys_router(accounts: Accounts) -> APIRouter:
    """Give the routes."""
    routes = APIRouter()
    _passkeys(routes, accounts)
    _provider(routes)
    _displays(routes, accounts)
    _hubs(routes, accounts)
    return routes


def _passkeys(routes: APIRouter, accounts: Accounts) -> None:
    rows: list[dict[str, Any]] = [{
        "id": "1", "name": "Phone", "host": "localhost", "created_us": now_us() - 48 * HOUR_US,
        "used_us": now_us() - HOUR_US,
    }]  # fmt: skip

    @routes.get("/api/me/passkeys")
    def passkeys() -> dict[str, Any]:
        return {"passkeys": rows, "codes": False, "possible": True}

    @routes.post("/api/me/passkeys/options")
    @routes.post("/api/me/passkeys/challenge")
    def options() -> dict[str, Any]:
        user = {"id": "bW9jaw", "name": "mock", "displayName": "mock"}
        return {"options": {
            "challenge": secrets.token_urlsafe(32), "rp": {"id": "localhost", "name": "Talaia"},
            "user": user, "pubKeyCredParams": [{"type": "public-key", "alg": -7}],
            "allowCredentials": [], "userVerification": "preferred",
        }}  # fmt: skip

    @routes.post("/api/me/passkeys")
    async def add(request: Request) -> dict[str, Any]:
        name = (await request.json())["name"]
        number = str(next(accounts.numbers))
        row = {"id": number, "name": name, "host": "localhost", "created_us": now_us()}
        rows.append({**row, "used_us": 0})
        return {"id": number, "recovery": []}

    @routes.patch("/api/me/passkeys/{passkey}")
    async def rename(passkey: str, request: Request) -> Response:
        name = (await request.json())["name"]
        for row in rows:
            if row["id"] == passkey:
                row["name"] = name
        return Response(status_code=DONE)

    @routes.delete("/api/me/passkeys/{passkey}")
    def remove(passkey: str) -> Response:
        rows[:] = [row for row in rows if row["id"] != passkey]
        return Response(status_code=DONE)


def _provider(routes: APIRouter) -> None:
    connected = {"operator": True}

    @routes.get("/api/login/oidc")
    def provider() -> dict[str, str]:
        return {"label": "Example University"}

    @routes.post("/api/me/oidc/confirm")
    @routes.post("/api/me/oidc/connect")
    def begin(request: Request) -> dict[str, str]:
        connected[request.state.who] = True
        return {"url": "/account"}

    @routes.get("/api/me/oidc")
    def connection(request: Request) -> dict[str, bool]:
        return {"connected": connected.get(request.state.who, False)}

    @routes.delete("/api/me/oidc")
    def disconnect(request: Request) -> Response:
        connected[request.state.who] = False
        return Response(status_code=DONE)


def _displays(routes: APIRouter, accounts: Accounts) -> None:
    rows: list[dict[str, Any]] = [{
        "id": "1", "name": "Control room", "sites": [accounts.site.site],
        "created_us": now_us() - 48 * HOUR_US, "used_us": now_us() - HOUR_US,
    }]  # fmt: skip

    @routes.get("/api/displays")
    def displays() -> dict[str, Any]:
        return {"displays": rows}

    @routes.post("/api/displays")
    async def add(request: Request) -> dict[str, str]:
        number, asked = str(next(accounts.numbers)), await request.json()
        rows.insert(0, {"id": number, **asked, "created_us": now_us(), "used_us": 0})
        return {"id": number, "token": f"tal_display_{secrets.token_urlsafe(24)}"}

    @routes.delete("/api/displays/{display}")
    def revoke(display: str) -> Response:
        rows[:] = [row for row in rows if row["id"] != display]
        return Response(status_code=DONE)


def _hubs(routes: APIRouter, accounts: Accounts) -> None:
    fits = {
        "id": "1", "name": "Mountain", "key": "ab12cd34ef56ab78", "keep_days": 730,
        "created_us": now_us() - 480 * HOUR_US, "heard_us": now_us() - HOUR_US // 2, "heads": 412,
        "row": 10412, "time_us": now_us() - HOUR_US // 2, "problem": "",
    }  # fmt: skip
    anew = "two heads say different things of row 7120: its log was made anew"
    silent = {**fits, "id": "3", "name": "Valley", "heard_us": now_us() - 30 * HOUR_US}
    rows: list[dict[str, Any]] = [
        fits, {**fits, "id": "2", "name": "Harbour", "row": 7130, "problem": anew}, silent,
    ]  # fmt: skip

    @routes.get("/api/audit/hubs")
    def hubs() -> dict[str, Any]:
        return {"hubs": rows}

    @routes.post("/api/audit/hubs")
    async def add(request: Request) -> dict[str, str]:
        number, asked = str(next(accounts.numbers)), await request.json()
        empty = {"key": "", "heard_us": 0, "heads": 0, "row": 0, "time_us": 0, "problem": ""}
        rows.insert(0, {"id": number, "created_us": now_us(), **asked, **empty})
        return {"id": number, "token": f"tal_heads_{secrets.token_urlsafe(24)}"}

    @routes.delete("/api/audit/hubs/{hub}")
    def remove(hub: str) -> Response:
        rows[:] = [row for row in rows if row["id"] != hub]
        return Response(status_code=DONE)
