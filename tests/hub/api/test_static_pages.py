"""The dashboard's files: what is served, how long it keeps, and that nothing else is."""

import gzip

import httpx
import pytest
from fastapi import FastAPI

from talaia.hub.api.guarded_routes import add_guarded, set_guards
from talaia.hub.api.static_pages import Pages


@pytest.fixture
async def client(tmp_path):
    folder = tmp_path / "static"
    (folder / "assets").mkdir(parents=True)
    (folder / "index.html").write_text("<!doctype html><title>Talaia</title>")
    (folder / "assets" / "app-1234.js").write_text("let a = 1")
    (folder / "assets" / "app-1234.js.gz").write_bytes(gzip.compress(b"let a = 1"))
    (tmp_path / "secret.txt").write_text("secret")
    app = FastAPI()
    set_guards(app)
    add_guarded(app, Pages(folder).make_router())
    transport = httpx.ASGITransport(app)
    async with httpx.AsyncClient(transport=transport, base_url="http://hub") as client:
        yield client


@pytest.mark.parametrize("path", ["/", "/home", "/sites/agv/actuate", "/index.html"])
async def test_every_page_is_the_one_page_and_is_asked_for_anew(client, path) -> None:
    answer = await client.get(path)
    assert "<title>Talaia" in answer.text
    assert answer.headers["cache-control"] == "no-cache"


async def test_asset_keeps_for_ever_and_comes_packed(client) -> None:
    answer = await client.get("/assets/app-1234.js")
    assert answer.text == "let a = 1"
    assert answer.headers["content-encoding"] == "gzip"
    assert "immutable" in answer.headers["cache-control"]
    assert answer.headers["content-type"].startswith("text/javascript")
    plain = await client.get("/assets/app-1234.js", headers={"Accept-Encoding": "identity"})
    assert "content-encoding" not in plain.headers
    assert plain.text == "let a = 1"


@pytest.mark.parametrize(
    "path",
    [
        "/%2e%2e%2fsecret.txt",
        "/assets/%2e%2e/%2e%2e/secret.txt",
        "/assets/none.js",
        "/..%5csecret.txt",
        "/%2e%2e%2fsecret.txt%00.js",
        "/api/none",
    ],
)
async def test_nothing_else_is_served(client, path) -> None:
    answer = await client.get(path)
    assert answer.status_code == 404
    assert "secret" not in answer.text
