"""A hub that is not there: answers the dashboard with made-up values, for page development.

Run from the repository's root with ``PYTHONPATH=src``:
``python web/mock/mock_hub.py --port 8765``. Sign in with any name and the password ``demo``; a
name that starts with ``guest`` or ``admin`` gets that role, ``slow`` is throttled, and whoever has
set up a second factor needs the code 123456. ``POST /mock?online=false`` takes the
site offline, ``?mute=true`` stops its values, ``?cut=true`` drops every socket.
"""

from __future__ import annotations

import argparse
import asyncio
import contextlib
import secrets
import time
from pathlib import Path
from typing import TYPE_CHECKING, Any

import uvicorn
from accounts_side import CODE, Accounts, router
from boards_side import router as boards_router
from described import site_json
from fastapi import FastAPI, Request, Response, WebSocket, WebSocketDisconnect
from fastapi.responses import FileResponse, JSONResponse
from fleet_side import fleet_router, fleet_rows
from scene_side import scene_router
from seen_side import router as seen_router
from socket_side import Browser, media
from world import World, anomalies, events, history, outliers, statistics

from talaia.model.yaml_text.load import read_site

if TYPE_CHECKING:
    from collections.abc import AsyncIterator, Awaitable, Callable

    from talaia.model.site import Site

ROOT = Path(__file__).resolve().parents[2]
STATIC = ROOT / "src" / "talaia" / "web" / "static"
POLICY = (
    "default-src 'self'; img-src 'self' blob: data:; object-src 'none'; base-uri 'none'; "
    "frame-ancestors 'none'"
)
COOKIE = "mock"


def problem(status: int, code: str, message: str, **headers: str) -> JSONResponse:
    """Answer no."""
    return JSONResponse({"code": code, "message": message}, status, headers or None)


def build(site: Site) -> FastAPI:
    """Put the mock together."""
    world = World(site)
    accounts = Accounts(site)
    people: dict[str, str] = {}
    browsers: set[Browser] = set()

    async def run() -> None:
        while True:
            world.step(0.05)
            for browser in tuple(browsers):
                browser.tick()
            await asyncio.sleep(0.05)

    @contextlib.asynccontextmanager
    async def life(_app: FastAPI) -> AsyncIterator[None]:
        task = asyncio.create_task(run())
        yield
        task.cancel()

    app = FastAPI(lifespan=life)

    @app.middleware("http")
    async def guard(
        request: Request, following: Callable[[Request], Awaitable[Response]]
    ) -> Response:
        free = ("/api/login", "/api/setup", "/mock")
        path = request.url.path
        if path.startswith("/api") and path not in free and who(request.cookies) is None:
            return problem(401, "nobody", "Sign in first.")
        request.state.who = who(request.cookies) or ""
        response = await following(request)
        response.headers["content-security-policy"] = POLICY
        return response

    def who(cookies: dict[str, str]) -> str | None:
        return people.get(cookies.get(COOKIE, ""))

    @app.post("/api/login")
    async def login(request: Request) -> Response:
        asked = await request.json()
        name = str(asked.get("name", ""))
        if name == "slow":
            return problem(429, "throttled", "Too many tries.", **{"retry-after": "30"})
        if asked.get("password") != "demo":
            return problem(401, "wrong", "Name or password is wrong.")
        if accounts.me(name)["factor"] and asked.get("code") != CODE:
            return problem(401, "factor", f"enter the code; here it is {CODE}")
        accounts.note(name, "login")
        token = secrets.token_hex(16)
        people[token] = name
        response = JSONResponse(accounts.me(name))
        response.set_cookie(COOKIE, token, httponly=True, samesite="strict")
        return response

    @app.post("/api/logout")
    async def logout(request: Request) -> Response:
        people.pop(request.cookies.get(COOKIE, ""), None)
        return Response(status_code=204)

    @app.post("/api/setup")
    async def setup(request: Request) -> Response:
        asked = await request.json()
        if asked.get("token") != "token":
            return problem(403, "forbidden", "This set-up link is used or too old.")
        return Response(status_code=204)

    @app.get("/api/me")
    async def me(request: Request) -> dict[str, Any]:
        return accounts.me(who(request.cookies) or "")

    @app.get("/api/sites")
    async def sites(request: Request) -> list[dict[str, Any]]:
        if who(request.cookies) == "empty":
            return []
        return fleet_rows(world)

    @app.get("/api/sites/{name}")
    async def one(name: str, request: Request) -> Response:
        if name not in {row["site"] for row in fleet_rows(world)}:
            return problem(404, "unknown", f"There is no site {name}.")
        detail = site_json(world, accounts.permissions(who(request.cookies) or ""))
        if name != site.site:
            detail |= {"site": name, "name": name.title(), "devices": []}
        return JSONResponse(detail)

    @app.get("/api/devices")
    async def devices(request: Request) -> dict[str, Any]:
        name = who(request.cookies) or ""
        rows = [
            {
                "site": site.site, "site_name": site.name, "device": key, "name": device.name,
                "kind": device.kind, "online": world.online, "rights": accounts.rights(name, key),
                "public": device.visibility == "public", "signals": len(device.signals), "stale": 0,
            }
            for key, device in site.devices.items()
        ]  # fmt: skip
        return {"devices": [row for row in rows if row["rights"] or row["public"]]}

    app.include_router(router(accounts))
    app.include_router(seen_router())
    app.include_router(boards_router(lambda request: request.state.who))
    app.include_router(scene_router(world))
    app.include_router(fleet_router(world))

    @app.get("/api/sites/{name}/anomalies")
    async def watched() -> dict[str, Any]:
        return anomalies()

    @app.post("/api/sites/{name}/anomalies/forgiven")
    async def forgiven() -> dict[str, bool]:
        return {"learned": True}

    @app.get("/api/sites/{name}/history")
    async def past(request: Request) -> dict[str, Any]:
        ask = request.query_params
        return {
            "series": [
                history(world, one, int(ask["from_us"]), int(ask["to_us"]), int(ask["width"]))
                for one in ask.getlist("channel")
            ]
        }

    @app.get("/api/sites/{name}/statistics")
    async def counted(request: Request) -> dict[str, Any]:
        ask = request.query_params
        return {
            "statistics": [
                statistics(world, one, int(ask["from_us"]), int(ask["to_us"]))
                for one in ask.getlist("channel")
            ]
        }

    @app.get("/api/sites/{name}/outliers")
    async def far_out(request: Request) -> dict[str, Any]:
        return {"outliers": [outliers(one) for one in request.query_params.getlist("channel")]}

    @app.get("/api/sites/{name}/export")
    async def taken(request: Request) -> Response:
        ask = request.query_params
        lines = ["time," + ",".join(ask.getlist("channel")), ask["from_us"] + ",made up"]
        headers = {"content-disposition": f'attachment; filename="mock.{ask["format"]}"'}
        return Response("\n".join(lines), media_type="text/csv", headers=headers)

    @app.get("/api/sites/{name}/events")
    async def happened(from_us: int = 0, to_us: int = 2**53, limit: int = 100) -> dict[str, object]:
        return events(from_us, to_us, limit)

    @app.post("/mock")
    async def tamper(
        *, online: bool | None = None, mute: bool | None = None, cut: bool = False
    ) -> dict[str, bool]:
        if online is not None:
            world.online, world.since = online, time.time()
        for browser in tuple(browsers):
            if mute is not None:
                browser.mute = mute
            browser.site_news()
            if cut:
                await browser.socket.close()
        return {"online": world.online}

    @app.websocket("/ws")
    async def everything(socket: WebSocket) -> None:
        name = who(socket.cookies)
        if name is None:
            await socket.close(4401)
            return
        await socket.accept()
        browser = Browser(socket, name, accounts.role_of(name), world, browsers)
        browsers.add(browser)
        try:
            await browser.run()
        finally:
            browsers.discard(browser)

    @app.websocket("/ws/media/unblurred")
    @app.websocket("/ws/media")
    async def pictures(socket: WebSocket) -> None:
        if who(socket.cookies) is None:
            await socket.close(4401)
            return
        await socket.accept()
        with contextlib.suppress(WebSocketDisconnect):
            await media(socket, world)

    @app.get("/{path:path}")
    async def page(path: str) -> Response:
        file = STATIC / path
        if ".." not in path and file.is_file():
            return FileResponse(file)
        return FileResponse(STATIC / "index.html")

    return app


def main() -> None:
    """Serve until Ctrl-C."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--port", type=int, default=8765)
    parser.add_argument("--site", type=Path, default=ROOT / "examples" / "agv" / "site.yaml")
    asked = parser.parse_args()
    uvicorn.run(
        build(read_site(asked.site)), host="127.0.0.1", port=asked.port, log_level="warning"
    )


if __name__ == "__main__":
    main()
