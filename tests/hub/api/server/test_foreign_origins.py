"""Pages of others: what they send on a person's behalf changes nothing and tells them nothing."""

from __future__ import annotations

import httpx
import pytest
import pytest_asyncio
import websockets
from patience import PATIENCE_S
from shared_trust import usual_trust

HOSTILE = {
    "another site": "https://evil.test",
    "no origin at all": None,
    "a sandboxed page": "null",
    "a host that ends like ours": "http://127.0.0.1.evil.test:{port}",
    "another port of this host": "http://127.0.0.1:{other}",
    "the same host, the other scheme": "https://127.0.0.1:{port}",
    "in capitals": "HTTP://127.0.0.1:{port}",
}


pytestmark = pytest.mark.asyncio(loop_scope="module")


@pytest.fixture
def hub(shared_hub):
    """Nothing here changes anything, which is what is tried."""
    return shared_hub


@pytest_asyncio.fixture(scope="module", loop_scope="module")
async def gateway(shared_hub):
    gateway = await shared_hub.gateway()
    await gateway.hello()
    return gateway


def spelt(hub, origin: str) -> str:
    return origin.format(port=hub.port, other=hub.port + 1)


@pytest.mark.parametrize("which", HOSTILE)
@pytest.mark.parametrize(
    "path", ["/ws", "/ws/media?site=agv&stream=camera/front", "/ws/topic?site=agv&topic=/scan"]
)
async def test_hostile_origin_opens_no_socket_though_the_cookie_is_right(
    hub, gateway, which, path
) -> None:
    headers = {"Cookie": await hub.cookie("admin")}
    if HOSTILE[which] is not None:
        headers["Origin"] = spelt(hub, HOSTILE[which])
    with pytest.raises(websockets.InvalidStatus) as refused:
        await hub.dial(path, headers)
    response = refused.value.response
    assert response.status_code == 403
    assert response.headers["X-Content-Type-Options"] == "nosniff"
    assert b'"origin"' in response.body


async def test_socket_of_another_host_name_is_refused_before_the_upgrade(hub) -> None:
    with pytest.raises(websockets.InvalidStatus) as refused:
        await websockets.connect(
            f"ws://127.0.0.1:{hub.port}/ws",
            additional_headers={
                "Host": "evil.test",
                "Origin": "http://evil.test",
                "Cookie": await hub.cookie("admin"),
            },
            proxy=None,
        )
    assert refused.value.response.status_code in {400, 421}


FORMS = {
    "a form": {"Content-Type": "application/x-www-form-urlencoded"},
    "a form with files": {"Content-Type": "multipart/form-data; boundary=x"},
    "text that is JSON": {"Content-Type": "text/plain"},
    "JSON in disguise": {"Content-Type": "text/plain; application/json"},
    "no type": {},
}


@pytest.mark.parametrize("which", FORMS)
async def test_what_a_form_of_another_site_can_send_changes_nothing(hub, which) -> None:
    cookie = await hub.cookie("admin")
    async with httpx.AsyncClient(
        base_url=hub.origin, timeout=PATIENCE_S, verify=usual_trust()
    ) as page:
        for origin in ("https://evil.test", "null", hub.origin):
            answer = await page.post(
                "/api/gateways/codes",
                content=b'{"site":"agv"}',
                headers={**FORMS[which], "Origin": origin, "Cookie": cookie},
            )
            assert answer.status_code in {403, 415}
    assert (await (await hub.client("admin")).get("/api/gateways")).json()["codes"] == []


@pytest.mark.parametrize("which", HOSTILE)
async def test_json_of_a_hostile_origin_changes_nothing(hub, which) -> None:
    headers = {"Cookie": await hub.cookie("admin")}
    if HOSTILE[which] is not None:
        headers["Origin"] = spelt(hub, HOSTILE[which])
    async with httpx.AsyncClient(
        base_url=hub.origin, timeout=PATIENCE_S, verify=usual_trust()
    ) as page:
        for method, path in (
            ("POST", "/api/gateways/codes"),
            ("POST", "/api/logout"),
            ("DELETE", "/api/gateways/codes/1"),
            ("PUT", "/api/gateways/codes"),
        ):
            answer = await page.request(method, path, json={"site": "agv"}, headers=headers)
            assert answer.status_code == 403, (method, path)
        mine = {"Cookie": headers["Cookie"]}
        assert (await page.get("/api/gateways", headers=mine)).json()["codes"] == []


@pytest.mark.parametrize("site", ["cross-site", "same-site", "none"])
async def test_browser_that_names_another_site_and_no_origin_changes_nothing(hub, site) -> None:
    headers = {"Cookie": await hub.cookie("admin"), "Sec-Fetch-Site": site}
    async with httpx.AsyncClient(
        base_url=hub.origin, timeout=PATIENCE_S, verify=usual_trust()
    ) as page:
        answer = await page.post("/api/gateways/codes", json={"site": "agv"}, headers=headers)
    assert answer.status_code == 403


async def test_our_own_page_may_ask_with_origin_or_with_fetch_metadata(hub) -> None:
    cookie = await hub.cookie("admin")
    async with httpx.AsyncClient(
        base_url=hub.origin, timeout=PATIENCE_S, verify=usual_trust()
    ) as page:
        for headers in ({"Origin": hub.origin}, {"Sec-Fetch-Site": "same-origin"}):
            answer = await page.post(
                "/api/gateways/codes", json={"site": "agv"}, headers={**headers, "Cookie": cookie}
            )
            assert answer.status_code == 200


@pytest.mark.parametrize("site", ["cross-site", "same-site"])
async def test_page_of_another_site_cannot_even_read_the_api(hub, site) -> None:
    headers = {"Cookie": await hub.cookie("admin"), "Sec-Fetch-Site": site}
    async with httpx.AsyncClient(
        base_url=hub.origin, timeout=PATIENCE_S, verify=usual_trust()
    ) as page:
        for path in ("/api/me", "/api/audit/export", "/api/sites"):
            assert (await page.get(path, headers=headers)).status_code == 403
        # A link from a mail or another site still opens the page.
        assert (await page.get("/home", headers=headers)).status_code in {200, 503}


async def test_no_get_changes_anything_and_no_method_is_overridden(hub) -> None:
    admin = await hub.client("admin")
    override = {"X-HTTP-Method-Override": "DELETE", "X-Method-Override": "POST"}
    for path in ("/api/logout", "/api/gateways/codes", "/api/gateways/1/revoke", "/api/enrol"):
        answer = await admin.get(path, headers=override, params={"_method": "POST"})
        assert answer.status_code in {404, 405}, path
    assert (await admin.get("/api/me")).status_code == 200


async def test_no_answer_lets_another_origin_read_it(hub) -> None:
    admin = await hub.client("admin")
    for origin in ("https://evil.test", "null"):
        answer = await admin.get("/api/me", headers={"Origin": origin})
        assert "access-control-allow-origin" not in answer.headers
        assert answer.headers["cross-origin-resource-policy"] == "same-origin"
