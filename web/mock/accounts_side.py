"""The mock hub's accounts, roles, gateways and audit log: kept in memory, checked for nothing.

Shapes are the hub's own, so that a page that works here works there.
"""

from __future__ import annotations

import itertools
import secrets
import time
from typing import TYPE_CHECKING, Any

from described import CHOSEN
from fastapi import APIRouter, Request, Response
from fastapi.responses import JSONResponse
from keys_side import keys_router

from talaia.model.units.conversion import units_like
from talaia.model.units.unit import unit_of

if TYPE_CHECKING:
    from talaia.model.site import Site

CODE = "123456"
RECOVERY = 10
QR = (
    '<svg xmlns="http://www.w3.org/2000/svg" viewBox="0 0 9 9"><path d="M1 1h3v3H1zM5 1h3v3H5z'
    'M1 5h3v3H1z" fill="#000"/></svg>'
)


def now_us() -> int:
    """Give the time (µs UTC)."""
    return int(time.time() * 1e6)


class Accounts:
    """Everything an admin manages."""

    def __init__(self, site: Site) -> None:
        """Begin with the seeded roles and a person for each."""
        self.site = site
        self.numbers = itertools.count(10)
        everything = {"site": "*", "device": "*"}
        self.roles: list[dict[str, Any]] = [
            {"id": "1", "name": "guest", "seeded": True, "factor_required": False,
             "permissions": []},
            {"id": "2", "name": "operator", "seeded": True, "factor_required": False,
             "permissions": [{"right": "use", **everything}]},
            {"id": "3", "name": "admin", "seeded": True, "factor_required": False,
             "permissions": [{"right": "admin", **everything}]},
        ]  # fmt: skip
        self.people = [self.person(role["name"], role["name"]) for role in self.roles]
        self.tokens: list[dict[str, Any]] = []
        self.codes: list[dict[str, Any]] = []
        self.rows: list[dict[str, Any]] = []
        self.gateways = [{
            "id": "1", "site": site.site, "name": "", "created_us": now_us(), "revoked_us": 0,
            "seen_us": now_us(), "address": "127.0.0.1", "version": "mock", "online": True,
            "held": [{"address": "192.0.2.7", "version": "", "since_us": now_us()}],
        }]  # fmt: skip

    def person(self, name: str, role: str) -> dict[str, Any]:
        """Make a person."""
        return {
            "id": str(next(self.numbers)), "name": name, "role": role, "disabled": False,
            "factor": False, "created_us": now_us(), "used_us": 0, "sessions": 0,
            "provider": name == "operator",
        }  # fmt: skip

    def role_of(self, name: str) -> str:
        """Let the list decide, or the name's beginning."""
        known = next((one["role"] for one in self.people if one["name"] == name), None)
        begins = next((role for role in ("guest", "admin") if name.startswith(role)), "operator")
        return known or begins

    def permissions(self, name: str) -> list[dict[str, str]]:
        """Give what a person's role holds."""
        role = self.role_of(name)
        return next((one["permissions"] for one in self.roles if one["name"] == role), [])

    def rights(self, name: str, device: str) -> list[str]:
        """List the rights of a person on a device."""
        ranks = ["view", "use", "admin"]
        held = [
            ranks.index(one["right"])
            for one in self.permissions(name)
            if one["site"] in {"*", self.site.site} and one["device"] in {"*", device}
        ]
        return ranks[: max(held) + 1] if held else []

    def me(self, name: str) -> dict[str, Any]:
        """Say who is signed in."""
        found = next((one for one in self.people if one["name"] == name), {})
        given = self.permissions(name)
        return {
            "name": name, "role": self.role_of(name), "factor": bool(found.get("factor")),
            "factor_missing": False, "codes_locked_us": 0, "password": True,
            "admin": any(one["right"] == "admin" and one["site"] == "*" for one in given),
            "idle_ends_us": now_us() + 12 * 3600 * 10**6, "ends_us": now_us() + 24 * 3600 * 10**6,
            "permissions": given,
        }  # fmt: skip

    def note(self, who: str, kind: str, message: str = "", *, good: bool = True) -> None:
        """Add a row to the audit log."""
        self.rows.insert(0, {
            "id": str(len(self.rows) + 1), "time_us": now_us(), "kind": kind, "who": who,
            "address": "127.0.0.1", "site": "", "device": "", "message": message, "good": good,
        })  # fmt: skip


def _found(rows: list[dict[str, Any]], wanted: str) -> dict[str, Any] | None:
    return next((one for one in rows if one["id"] == wanted), None)


def no(status: int, code: str, message: str) -> JSONResponse:
    """Answer no."""
    return JSONResponse({"code": code, "message": message}, status)


GONE = (404, "unknown", "there is no such thing")
DONE = 204


def router(accounts: Accounts) -> APIRouter:
    """Give the routes; who asks stands in the request's state."""
    routes = APIRouter()
    own(routes, accounts)
    admin(routes, accounts)
    routes.include_router(keys_router(accounts))
    return routes


def own(routes: APIRouter, accounts: Accounts) -> None:
    """Add the routes of one's own account."""

    def mine(request: Request) -> dict[str, Any]:
        name = request.state.who
        return next((one for one in accounts.people if one["name"] == name), {})

    @routes.get("/api/me/units")
    async def units() -> JSONResponse:
        return JSONResponse(
            {
                "units": [
                    {
                        "unit": unit,
                        "name": unit_of(unit).name,
                        "sites": ["House vehicle"],
                        "shown": CHOSEN.get(unit, ""),
                        "choices": units_like(unit),
                    }
                    for unit in ("m/s", "rad/s", "°C", "V", "m")
                ]
            }
        )

    @routes.put("/api/me/units", status_code=204)
    async def choose_units(asked: dict[str, dict[str, str]]) -> None:
        CHOSEN.clear()
        CHOSEN.update(asked["shown"])

    @routes.post("/api/me/password")
    async def password(request: Request) -> Response:
        if (await request.json()).get("old") != "demo":
            return no(403, "wrong", "the password is wrong")
        return Response(status_code=DONE)

    @routes.get("/api/me/sessions")
    def sessions(request: Request) -> dict[str, Any]:
        agent = request.headers.get("user-agent", "")
        row = {"created_us": now_us(), "used_us": now_us(), "address": "127.0.0.1"}
        other = "Mozilla/5.0 (iPhone) Version/18.0 Safari/604.1"
        return {"sessions": [
            {"id": "here", **row, "agent": agent, "this": True},
            {"id": "there", **row, "agent": other, "this": False},
        ]}  # fmt: skip

    @routes.delete("/api/me/sessions")
    @routes.delete("/api/me/sessions/{session}")
    def end(session: str = "") -> Response:
        return Response(status_code=DONE)

    @routes.post("/api/me/factor")
    def offer() -> dict[str, str]:
        return {"secret": "MOCKMOCKMOCKMOCK", "uri": "otpauth://totp/mock", "qr": QR}

    @routes.post("/api/me/factor/confirm")
    async def confirm(request: Request) -> Response:
        if (await request.json()).get("code") != CODE:
            return no(403, "factor", f"the code is wrong; here it is {CODE}")
        mine(request)["factor"] = True
        return JSONResponse({"recovery": [secrets.token_hex(5) for _ in range(RECOVERY)]})

    @routes.post("/api/me/factor/remove")
    def remove(request: Request) -> Response:
        mine(request)["factor"] = False
        return Response(status_code=DONE)

    @routes.get("/api/me/tokens")
    def tokens() -> dict[str, Any]:
        return {"tokens": accounts.tokens}

    @routes.post("/api/me/tokens")
    async def token(request: Request) -> dict[str, str]:
        number = str(next(accounts.numbers))
        row = {"id": number, "created_us": now_us(), "used_us": 0, **await request.json()}
        accounts.tokens.insert(0, row)
        return {"id": number, "token": f"tal_{secrets.token_urlsafe(24)}"}

    @routes.delete("/api/me/tokens/{token}")
    def revoke(token: str) -> Response:
        accounts.tokens = [one for one in accounts.tokens if one["id"] != token]
        return Response(status_code=DONE)


def admin(routes: APIRouter, accounts: Accounts) -> None:
    """Add the routes of people, roles, gateways and the audit log."""

    @routes.get("/api/people")
    def people() -> dict[str, Any]:
        return {"people": sorted(accounts.people, key=lambda one: one["name"])}

    @routes.post("/api/people")
    async def add(request: Request) -> Response:
        asked = await request.json()
        if any(one["name"] == asked["name"] for one in accounts.people):
            return no(409, "taken", f"there is a person named {asked['name']} already")
        accounts.people.append(accounts.person(asked["name"], asked["role"]))
        accounts.note(request.state.who, "person added", asked["name"])
        return JSONResponse(accounts.people[-1])

    @routes.patch("/api/people/{person}")
    async def change(person: str, request: Request) -> Response:
        found, asked = _found(accounts.people, person), await request.json()
        if found is None:
            return no(*GONE)
        if found["role"] == "admin" and asked.get("role", "admin") != "admin":
            return no(409, "last_admin", "there has to be one admin who can sign in")
        found.update({key: asked[key] for key in ("role", "disabled") if key in asked})
        accounts.note(request.state.who, "person changed", found["name"])
        return JSONResponse(found)

    @routes.delete("/api/people/{person}")
    def remove(person: str) -> Response:
        accounts.people = [one for one in accounts.people if one["id"] != person]
        return Response(status_code=DONE)

    @routes.delete("/api/people/{person}/{part}")
    def take(person: str, part: str) -> Response:
        found = _found(accounts.people, person) or {}
        found.update(
            {"factor": {"factor": False}, "oidc": {"provider": False}}.get(part, {"sessions": 0})
        )
        return Response(status_code=DONE)

    @routes.get("/api/roles")
    def roles() -> dict[str, Any]:
        names = [one["role"] for one in accounts.people]
        return {"roles": [{**one, "people": names.count(one["name"])} for one in accounts.roles]}

    @routes.post("/api/roles")
    async def make(request: Request) -> dict[str, Any]:
        row = {
            "id": str(next(accounts.numbers)),
            "seeded": False,
            "factor_required": False,
            **await request.json(),
        }
        accounts.roles.append(row)
        return {**row, "people": 0}

    @routes.put("/api/roles/{role}")
    async def give(role: str, request: Request) -> Response:
        found = _found(accounts.roles, role)
        if found is None:
            return no(*GONE)
        found.update(await request.json())
        accounts.note(request.state.who, "role changed", found["name"])
        return JSONResponse({**found, "people": 0})

    @routes.delete("/api/roles/{role}")
    def drop(role: str) -> Response:
        accounts.roles = [one for one in accounts.roles if one["id"] != role]
        return Response(status_code=DONE)

    @routes.get("/api/gateways")
    def gateways() -> dict[str, Any]:
        return {"gateways": accounts.gateways, "codes": accounts.codes}

    @routes.post("/api/gateways/codes")
    async def code(request: Request) -> dict[str, Any]:
        asked, number = await request.json(), str(next(accounts.numbers))
        row = {"id": number, "site": asked["site"], "created_us": now_us()}
        accounts.codes.append({**row, "expires_us": now_us() + 900 * 10**6})
        word = "MOCKM-OCKMO-CKMO"
        command = f"talaia gateway enrol https://hub.example {word} --key-file {asked['site']}.key"
        return {
            "id": number, "code": word, "expires_us": now_us() + 900 * 10**6, "command": command,
            "fingerprint": "00:11:22:33", "qr": QR,
        }  # fmt: skip

    @routes.delete("/api/gateways/codes/{code}")
    def withdraw(code: str) -> Response:
        accounts.codes = [one for one in accounts.codes if one["id"] != code]
        return Response(status_code=DONE)

    @routes.post("/api/gateways/{gateway}/{deed}")
    def deed(gateway: str, deed: str) -> Response:
        found = _found(accounts.gateways, gateway)
        if found is not None and deed == "second":
            found["held"] = []
        if found is not None and deed == "revoke":
            found.update({"revoked_us": now_us(), "online": False})
        return Response(status_code=DONE if deed == "revoke" else 202)

    @routes.get("/api/audit")
    def audit(request: Request) -> dict[str, Any]:
        who = request.query_params.get("who", "")
        return {"rows": [one for one in accounts.rows if who in {"", one["who"]}], "more": False}

    @routes.get("/api/audit/verify")
    def verify() -> dict[str, Any]:
        return {"ok": True, "rows": len(accounts.rows), "broken": 0, "heads": 1, "problem": ""}
