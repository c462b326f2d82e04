"""The HTTP API: signing in and out, sites, history, pages, and what stands before them."""

import httpx
import pytest
import websockets
from patience import PATIENCE_S
from shared_trust import usual_trust

from talaia.wire import browser as page_wire
from talaia.wire.frames import Ack

PASSWORD = "a password for tests"  # noqa: S105
NOW = 1_700_000_000_000_000


@pytest.mark.asyncio(loop_scope="module")
async def test_health_says_no_more_than_that_it_answers(shared_hub) -> None:
    answer = await (await shared_hub.client()).get("/api/health")
    assert answer.json() == {"ok": True}


@pytest.mark.asyncio(loop_scope="module")
async def test_everything_else_wants_a_session(shared_hub) -> None:
    client = await shared_hub.client()
    for path in ("/api/me", "/api/sites", "/api/sites/agv", "/api/sites/agv/events"):
        answer = await client.get(path)
        assert (answer.status_code, answer.json()["code"]) == (401, "unauthorized")


async def test_sign_in_tells_who_you_are_and_leaves_a_guarded_cookie(hub) -> None:
    client = await hub.client()
    answer = await client.post("/api/login", json={"name": "Operator", "password": PASSWORD})
    me = answer.json()
    assert (me["name"], me["role"], me["admin"], me["factor"]) == (
        "operator",
        "operator",
        False,
        False,
    )
    assert {each["right"] for each in me["permissions"]} == {"view", "use", "request", "arm"}
    assert me["ends_us"] > me["idle_ends_us"] > 0
    cookie = answer.headers["set-cookie"].lower()
    assert all(word in cookie for word in ("httponly", "samesite=strict", "path=/"))
    assert (await client.get("/api/me")).json()["name"] == "operator"


@pytest.mark.asyncio(loop_scope="module")
async def test_wrong_name_and_wrong_password_look_alike(shared_hub) -> None:
    client = await shared_hub.client()
    answers = [
        await client.post("/api/login", json={"name": name, "password": "wrong password"})
        for name in ("operator", "nobody")
    ]
    assert answers[0].status_code == 401
    assert (answers[0].status_code, answers[0].json()) == (
        answers[1].status_code,
        answers[1].json(),
    )


async def test_too_many_wrong_tries_must_wait(hub) -> None:
    client = await hub.client()
    for _ in range(5):
        await client.post("/api/login", json={"name": "operator", "password": "wrong password"})
    answer = await client.post("/api/login", json={"name": "operator", "password": PASSWORD})
    assert answer.status_code == 429
    assert int(answer.headers["retry-after"]) >= 1
    # Someone else at the same address is not in the way.
    await hub.client("admin")


async def test_log_out_ends_the_session_and_closes_open_sockets(hub) -> None:
    client = await hub.client("operator")
    page = await hub.page("operator")
    assert (await client.post("/api/logout")).status_code == 204
    assert "signed out" in (await page.hear(page_wire.SessionEnded)).reason
    assert await page.closed() == 4401
    cookie = await hub.cookie("operator")
    answer = await (await hub.client()).get("/api/me", headers={"Cookie": cookie})
    assert answer.status_code == 401


async def test_new_role_closes_open_sockets(hub) -> None:
    page = await hub.page("operator")
    await hub.people.set_role("operator", "guest")
    assert "rights have changed" in (await page.hear(page_wire.SessionEnded)).reason
    assert await page.closed() == 4401


async def test_session_of_before_is_dead_after_signing_in_anew(hub) -> None:
    client = await hub.client("operator")
    before = client.cookies["talaia"]
    await client.post("/api/login", json={"name": "admin", "password": PASSWORD})
    assert client.cookies["talaia"] != before
    answer = await (await hub.client()).get("/api/me", headers={"Cookie": f"talaia={before}"})
    assert answer.status_code == 401


async def test_first_start_offers_setup_once(empty_hub) -> None:
    token = empty_hub.hub.people.setup_token
    first, second = await empty_hub.client(), await empty_hub.client()
    wrong = {"token": "wrong", "name": "ada", "password": PASSWORD}
    assert (await first.post("/api/setup", json=wrong)).status_code == 403
    weak = {"token": token, "name": "ada", "password": "short"}
    assert (await first.post("/api/setup", json=weak)).status_code == 422
    asked = {"token": token, "name": "ada", "password": PASSWORD}
    me = (await first.post("/api/setup", json=asked)).json()
    assert (me["name"], me["role"], me["admin"]) == ("ada", "admin", True)
    again = {"token": token, "name": "eve", "password": PASSWORD}
    assert (await second.post("/api/setup", json=again)).status_code == 403
    assert (await first.get("/api/me")).json()["name"] == "ada"


async def test_sites_list_counts_what_one_may_see(hub, gateway) -> None:
    operator = (await (await hub.client("operator")).get("/api/sites")).json()[0]
    guest = (await (await hub.client("guest")).get("/api/sites")).json()[0]
    assert (operator["site"], operator["online"], operator["devices"]) == ("agv", True, 4)
    assert operator["stale"] == operator["signals"]
    assert (guest["devices"], guest["signals"]) == (3, 3)


@pytest.mark.asyncio(loop_scope="module")
async def test_description_is_cut_to_rights(shared_hub, shared_gateway) -> None:
    operator = (await (await shared_hub.client("operator")).get("/api/sites/agv")).json()
    base = operator["devices"][0]
    assert base["rights"] == ["view", "use"]
    assert base["commands"][0]["arguments"][0]["id"] == "active"
    assert base["drive"]["max_reverse"] == 0.22
    pose = next(signal for signal in base["signals"] if signal["id"] == "pose")
    assert pose["channels"] == ["base/pose.x", "base/pose.y", "base/pose.yaw"]
    guest = (await (await shared_hub.client("guest")).get("/api/sites/agv")).json()
    assert [device["id"] for device in guest["devices"]] == ["base", "power", "sensors"]
    assert [signal["id"] for signal in guest["devices"][0]["signals"]] == ["speed"]
    assert guest["devices"][0]["commands"] == []
    assert guest["devices"][0]["drive"] is None


async def test_history_gives_columns_and_null_for_no_number(hub, gateway) -> None:
    await gateway.samples(("base/speed", NOW, 0.5), ("base/speed", NOW + 1, float("nan")))
    await gateway.hear(Ack)
    client = await hub.client("guest")
    query = {"channel": "base/speed", "from_us": NOW, "to_us": NOW + 10}
    answer = await client.get("/api/sites/agv/history", params=query)
    assert answer.json() == {
        "series": [
            {
                "address": "base/speed",
                "kind": "exact",
                "t_us": [NOW, NOW + 1],
                "v": [0.5, None],
                "gaps": [],
            }
        ]
    }


@pytest.mark.parametrize(
    ("query", "status"),
    [
        ({"channel": "base/turn_rate", "from_us": 0, "to_us": 1}, 404),
        ({"channel": "base/speed", "from_us": 1, "to_us": 1}, 422),
        ({"channel": "base/speed", "from_us": "' OR 1=1 --", "to_us": 1}, 422),
        ({"channel": "'; DROP TABLE users; --", "from_us": 0, "to_us": 1}, 404),
        ({"from_us": 0, "to_us": 1}, 422),
    ],
)
@pytest.mark.asyncio(loop_scope="module")
async def test_history_refuses_what_is_wrong_or_not_for_a_guest(
    shared_hub, shared_gateway, query, status
) -> None:
    client = await shared_hub.client("guest")
    answer = await client.get("/api/sites/agv/history", params=query)
    assert answer.status_code == status
    assert answer.headers["content-type"] == "application/problem+json"


async def test_events_are_for_those_who_may_view(hub, gateway) -> None:
    await hub.hub.audit.log.wait_written()
    operator = await (await hub.client("operator")).get("/api/sites/agv/events")
    guest = await (await hub.client("guest")).get("/api/sites/agv/events")
    assert operator.json()["events"][0]["kind"] == "gateway connected"
    assert guest.json()["events"] == []


async def test_events_of_a_window_are_those_and_no_others(hub, gateway) -> None:
    audit = hub.hub.audit.log
    times = [
        audit.append_record(kind, site="agv", device="base").time_us for kind in ("a", "b", "c")
    ]
    await audit.wait_written()
    client = await hub.client("operator")

    async def ask(**wanted: int) -> tuple[list[str], bool]:
        said = (await client.get("/api/sites/agv/events", params=wanted)).json()
        return [event["kind"] for event in said["events"]], said["more"]

    assert await ask(from_us=times[0], to_us=times[2], limit=2) == (["c", "b"], True)
    assert await ask(from_us=times[0], to_us=times[2], limit=3) == (["c", "b", "a"], False)
    assert await ask(to_us=times[0] - 10**9) == ([], False)


async def test_who_may_view_one_device_gets_its_events_however_many_others_there_are(
    hub, gateway
) -> None:
    admin = await hub.client("admin")
    permissions = [{"right": "view", "site": "agv", "device": each} for each in ("power", "old")]
    await admin.post("/api/roles", json={"name": "crew", "permissions": permissions})
    crew = {"name": "ada", "password": PASSWORD, "role": "crew"}
    assert (await admin.post("/api/people", json=crew)).status_code == 200
    audit = hub.hub.audit.log
    # "old" is no device any more.
    for at in range(4):
        audit.append_record(f"low {at}", site="agv", device=("power", "old")[at % 2])
    for _ in range(20):
        audit.append_record("driving", site="agv", device="base")
        audit.append_record("gateway connected", site="agv")
    await audit.wait_written()
    client = await hub.client("ada")

    async def ask(limit: int) -> tuple[list[str], bool]:
        query = {"limit": limit}
        said = (await client.get("/api/sites/agv/events", params=query)).json()
        return [event["kind"] for event in said["events"]], said["more"]

    assert await ask(4) == (["low 3", "low 2", "low 1", "low 0"], False)
    assert await ask(2) == (["low 3", "low 2"], True)


@pytest.mark.asyncio(loop_scope="module")
async def test_unknown_site_is_unknown(shared_hub) -> None:
    client = await shared_hub.client("operator")
    assert (await client.get("/api/sites/moon")).status_code == 404


@pytest.mark.parametrize("path", ["/", "/home", "/api/nothing", "/assets/none.js", "/api/me"])
@pytest.mark.asyncio(loop_scope="module")
async def test_every_answer_carries_the_guarding_headers(shared_hub, path) -> None:
    headers = (await (await shared_hub.client()).get(path)).headers
    policy = headers["content-security-policy"]
    assert "default-src 'self'" in policy
    assert "unsafe" not in policy
    assert f"ws://127.0.0.1:{shared_hub.port}" in policy
    assert headers["x-content-type-options"] == "nosniff"
    assert headers["referrer-policy"] == "no-referrer"
    assert headers["cross-origin-opener-policy"] == "same-origin"
    assert ("no-store" in headers.get("cache-control", "")) == path.startswith("/api")


@pytest.mark.parametrize(
    "path",
    ["/..%2f..%2fsettings.py", "/%2e%2e/%2e%2e/app.py", "/assets/..%5c..%5cx.js", "/a%00.js"],
)
@pytest.mark.asyncio(loop_scope="module")
async def test_no_path_leaves_the_folder_of_the_pages(shared_hub, path) -> None:
    answer = await (await shared_hub.client()).get(path)
    assert answer.status_code in {404, 503} or "<html" in answer.text


@pytest.mark.parametrize(
    "headers",
    [
        {"Origin": "https://evil.test", "Content-Type": "application/json"},
        {"Content-Type": "application/json"},
        {"Origin": "null", "Content-Type": "application/json"},
        {"Content-Type": "text/plain"},
        {"Content-Type": "application/x-www-form-urlencoded"},
        {"Sec-Fetch-Site": "cross-site", "Content-Type": "application/json"},
    ],
)
@pytest.mark.asyncio(loop_scope="module")
async def test_another_origin_changes_nothing(shared_hub, headers) -> None:
    cookie = await shared_hub.cookie("operator")
    async with httpx.AsyncClient(
        base_url=shared_hub.origin, timeout=PATIENCE_S, verify=usual_trust()
    ) as client:
        answer = await client.post(
            "/api/logout", content="{}", headers={**headers, "Cookie": cookie}
        )
        assert answer.status_code in {403, 415}
        assert (await client.get("/api/me", headers={"Cookie": cookie})).status_code == 200


@pytest.mark.asyncio(loop_scope="module")
async def test_host_that_is_not_ours_is_refused(shared_hub) -> None:
    answer = await (await shared_hub.client()).get("/api/health", headers={"Host": "evil.test"})
    assert answer.status_code == 421


@pytest.mark.asyncio(loop_scope="module")
async def test_large_body_is_refused_before_it_is_read(shared_hub) -> None:
    client = await shared_hub.client()
    answer = await client.post(
        "/api/login",
        content=b"x" * (1024 * 1024 + 1),
        headers={"Content-Type": "application/json"},
    )
    assert answer.status_code == 413


@pytest.mark.parametrize(
    "origin",
    ["https://evil.test", None, "null", "http://127.0.0.1.evil.test:{port}", "http://127.0.0.1:1"],
)
@pytest.mark.parametrize(
    "path", ["/ws", "/ws/media?site=agv&stream=camera/front", "/ws/topic?site=agv&topic=/scan"]
)
@pytest.mark.asyncio(loop_scope="module")
async def test_socket_of_another_origin_is_refused_before_the_upgrade(
    shared_hub, shared_gateway, origin, path
) -> None:
    headers = {"Cookie": await shared_hub.cookie("operator")}
    if origin is not None:
        headers["Origin"] = origin.format(port=shared_hub.port)
    with pytest.raises(websockets.InvalidStatus) as refused:
        await shared_hub.dial(path, headers)
    assert refused.value.response.status_code == 403


@pytest.mark.asyncio(loop_scope="module")
async def test_socket_without_a_session_is_refused_before_the_upgrade(shared_hub) -> None:
    for headers in (
        {"Origin": shared_hub.origin},
        {"Origin": shared_hub.origin, "Cookie": "talaia=guessed"},
    ):
        with pytest.raises(websockets.InvalidStatus) as refused:
            await shared_hub.dial("/ws", headers)
        assert refused.value.response.status_code == 401


@pytest.mark.parametrize(
    ("headers", "status"),
    [
        ({}, 401),
        ({"Authorization": "Bearer guessed"}, 401),
        ({"Authorization": "Basic {key}"}, 401),
        ({"Authorization": "Bearer {key}", "Origin": "{origin}"}, 403),
    ],
)
@pytest.mark.parametrize("path", ["/gateway/link", "/gateway/media"])
@pytest.mark.asyncio(loop_scope="module")
async def test_gateway_needs_its_key_and_is_no_page(shared_hub, headers, status, path) -> None:
    said = {
        name: value.format(key=shared_hub.keys["agv"], origin=shared_hub.origin)
        for name, value in headers.items()
    }
    with pytest.raises(websockets.InvalidStatus) as refused:
        await shared_hub.dial(path, said)
    assert refused.value.response.status_code == status


@pytest.mark.asyncio(loop_scope="module")
async def test_cookie_opens_no_gateway_door(shared_hub) -> None:
    with pytest.raises(websockets.InvalidStatus) as refused:
        await shared_hub.dial("/gateway/link", {"Cookie": await shared_hub.cookie("admin")})
    assert refused.value.response.status_code == 401


@pytest.mark.parametrize("frame", [b"", b"\xc1", "{}", "[", b"\x00" * 2000])
@pytest.mark.asyncio(loop_scope="module")
async def test_garbage_from_a_page_closes_its_socket_with_a_code(shared_hub, frame) -> None:
    page = await shared_hub.page("operator")
    await page.connection.send(frame)
    assert await page.closed() == 1002
