"""Headers and cookies of every answer, whatever it says."""

from __future__ import annotations

import pytest
import websockets

from ...everyone.secure_hub import PASSWORD, browsing, secure, trusting
from ...everyone.wires import request, say

LOGIN = {"name": "admin", "password": PASSWORD}


def check(headers, *, tls: bool) -> None:
    policy = headers["content-security-policy"]
    directives = dict(part.strip().partition(" ")[::2] for part in policy.split(";"))
    assert "unsafe" not in policy
    assert "http:" not in policy
    assert directives["default-src"] == "'self'"
    for name in ("object-src", "base-uri", "frame-ancestors"):
        assert directives[name] == "'none'", name
    assert headers["x-content-type-options"] == "nosniff"
    assert headers["referrer-policy"] == "no-referrer"
    assert headers["cross-origin-opener-policy"] == "same-origin"
    assert headers["x-frame-options"] == "DENY"
    assert "camera=()" in headers["permissions-policy"]
    strict = headers.get("strict-transport-security", "")
    assert (strict == "max-age=31536000") == tls
    assert "server" not in headers
    assert "x-powered-by" not in headers


async def test_every_kind_of_answer_carries_the_guarding_headers(hub, monkeypatch) -> None:
    admin, nobody = await hub.client("admin"), await hub.client()
    guest = await hub.client("guest")
    answers = {
        200: await nobody.get("/api/health"),
        204: await guest.post("/api/logout"),
        401: await nobody.get("/api/me"),
        403: await (await hub.client("operator")).get("/api/audit"),
        404: await admin.get("/api/nothing"),
        405: await admin.post("/api/me", json={}),
        413: await nobody.post("/api/login", content=b" " * (1024 * 1024 + 1), headers=JSON),
        415: await nobody.post("/api/login", content=b"x", headers={"Content-Type": "text/plain"}),
        421: await nobody.get("/api/health", headers={"Host": "evil.test"}),
        422: await nobody.post("/api/login", json={}),
    }
    for _ in range(11):
        answers[429] = await nobody.post("/api/enrol", json={"code": "x"})

    def fail(*_: object) -> None:
        raise RuntimeError("a secret of the inside")

    monkeypatch.setattr(hub.hub.audit.log, "find_records", fail)
    answers[500] = await admin.get("/api/audit")
    for status, answer in answers.items():
        assert answer.status_code == status
        check(answer.headers, tls=False)
        assert answer.headers["cache-control"] == "no-store"
    for path in ("/", "/home", "/assets/none.js", "/favicon.ico", "/..%2f..%2fetc/passwd"):
        check((await nobody.get(path)).headers, tls=False)


JSON = {"Content-Type": "application/json"}


async def test_failure_inside_tells_nothing_of_the_inside(hub, monkeypatch) -> None:
    admin = await hub.client("admin")

    def fail(*_: object) -> None:
        raise RuntimeError("a secret of the inside")

    monkeypatch.setattr(hub.hub.audit.log, "find_records", fail)
    answer = await admin.get("/api/audit")
    assert answer.json() == {"code": "failed", "message": "the hub failed; its log says more"}


@pytest.mark.asyncio(loop_scope="module")
async def test_refused_sockets_carry_the_guarding_headers(shared_hub) -> None:
    for path, headers in (
        ("/ws", {"Origin": "https://evil.test"}),
        ("/ws", {"Origin": shared_hub.origin}),
        ("/gateway/link", {}),
        ("/gateway/link", {"Origin": shared_hub.origin}),
        ("/nowhere", {"Origin": shared_hub.origin}),
    ):
        with pytest.raises(websockets.InvalidStatus) as refused:
            await shared_hub.dial(path, headers)
        assert refused.value.response.status_code in {401, 403, 404}
        if path != "/nowhere":
            check(refused.value.response.headers, tls=False)


@pytest.mark.parametrize("path", ["/docs", "/redoc", "/.git/config", "/assets/", "/assets/../"])
@pytest.mark.asyncio(loop_scope="module")
async def test_nothing_of_the_inside_is_listed(shared_hub, path) -> None:
    answer = await (await shared_hub.client("admin")).get(path)
    assert "swagger" not in answer.text.lower()
    assert "index of" not in answer.text.lower()
    assert "repositoryformatversion" not in answer.text


async def test_over_tls_browsers_are_held_to_it_for_a_year(hub_that_stores, settings) -> None:
    async with secure(hub_that_stores, settings) as running, browsing(running) as nobody:
        for path in ("/api/health", "/api/me", "/", "/assets/none.js"):
            check((await nobody.get(path)).headers, tls=True)
        answer = await say(running.port, b"\x00\r\n\r\n", tls=trusting(running))
        assert answer.status == 400
        check(answer.headers, tls=True)


async def test_over_tls_the_cookie_is_bound_to_this_host(hub_that_stores, settings) -> None:
    async with secure(hub_that_stores, settings) as running, browsing(running) as nobody:
        answer = await nobody.post("/api/login", json=LOGIN)
        name, _, rest = answer.headers["set-cookie"].partition("=")
        said = {word.strip().lower() for word in rest.split(";")[1:]}
        assert name.startswith("__Host-")
        assert {"secure", "httponly", "samesite=strict", "path=/"} <= said
        assert not any(word.startswith("domain") for word in said)


async def test_plain_text_to_a_tls_port_is_refused_without_a_downgrade(
    hub_that_stores, settings
) -> None:
    async with secure(hub_that_stores, settings) as running:
        answer = await say(running.port, request(host=f"127.0.0.1:{running.port}"))
        assert answer.status == 0
        with pytest.raises((websockets.InvalidMessage, OSError, EOFError)):
            await running.dial("/ws", {"Origin": running.origin})
