"""People, roles and tokens over a hub that really serves, and sockets that follow each change."""

import asyncio

import pytest
import websockets
from patience import Stopwatch

from talaia.clock import SystemClock
from talaia.hub.auth.permissions import ANY, Grants, Permission, Right
from talaia.wire import browser as page_wire
from talaia.wire.browser import FROM_BROWSER, TO_BROWSER
from talaia.wire.frames import LeaseOp, LeaseRequest, LeaseState

from ...conftest import Peer

PASSWORD = "a password for tests"  # noqa: S105
HOUR_US = 3_600_000_000


async def people_of(admin) -> dict[str, dict]:
    return {each["name"]: each for each in (await admin.get("/api/people")).json()["people"]}


async def roles_of(admin) -> dict[str, dict]:
    return {each["name"]: each for each in (await admin.get("/api/roles")).json()["roles"]}


def may(right, site="*", device="*"):
    return {"right": right, "site": site, "device": device}


async def token_of(client, *permissions, name="script", hours=1) -> dict:
    ends_us = SystemClock().wall_ns() // 1000 + hours * HOUR_US
    asked = {"name": name, "ends_us": ends_us, "permissions": list(permissions)}
    answer = await client.post("/api/me/tokens", json=asked)
    assert answer.status_code == 200, answer.text
    return answer.json()


async def script_socket(hub, token):
    connection = await hub.dial("/ws", {"Authorization": f"Bearer {token}"})
    return hub._keep(Peer(connection, FROM_BROWSER, TO_BROWSER))


async def holding(hub, gateway, name="operator"):
    """Give the page of a person who holds the lease of the base."""
    page = await hub.page(name)
    await page.say(page_wire.PageLease(site="agv", device="base", op=LeaseOp.TAKE))
    asked = await gateway.hear(LeaseRequest)
    await gateway.say(
        LeaseState(device="base", session=asked.session, who=name, epoch=1, remains_ms=3000)
    )
    assert (await page.hear(page_wire.LeaseUpdate, lambda news: news.yours)).holder == name
    return page


async def freed_at_once(page, gateway, change) -> None:
    with Stopwatch() as watch:
        assert (await change).status_code in {200, 204}
        await gateway.hear(LeaseRequest, lambda asked: asked.op is LeaseOp.FREE)
        freed_s = watch.seconds
        assert await page.closed() == 4401
    assert freed_s < 1.0
    assert watch.seconds < 1.5


async def test_admin_adds_changes_and_removes_people(hub) -> None:
    admin = await hub.client("admin")
    asked = {"name": "Ada", "password": "three unrelated words", "role": "operator"}
    made = (await admin.post("/api/people", json=asked)).json()
    assert (made["name"], made["role"], made["disabled"], made["factor"]) == (
        "Ada", "operator", False, False,
    )  # fmt: skip
    again = await admin.post("/api/people", json={**asked, "name": "ADA"})
    assert (again.status_code, again.json()["code"]) == (409, "taken")
    path = f"/api/people/{made['id']}"
    changed = await admin.patch(path, json={"role": "guest", "disabled": True})
    assert (changed.json()["role"], changed.json()["disabled"]) == ("guest", True)
    sign_in = {"name": "ada", "password": "three unrelated words"}
    assert (await (await hub.client()).post("/api/login", json=sign_in)).status_code == 401
    await admin.patch(path, json={"disabled": False, "password": "some other new words"})
    assert (await (await hub.client()).post("/api/login", json=sign_in)).status_code == 401
    sign_in["password"] = "some other new words"  # noqa: S105
    assert (await (await hub.client()).post("/api/login", json=sign_in)).status_code == 200
    assert (await people_of(admin))["Ada"]["sessions"] == 1
    assert (await admin.delete(path)).status_code == 204
    assert (await admin.delete(path)).status_code == 404
    assert "Ada" not in await people_of(admin)


@pytest.mark.parametrize(
    "asked",
    [
        {"name": "ada", "password": "short", "role": "guest"},
        {"name": "ada", "password": "password1", "role": "guest"},
        {"name": "ada", "password": "three unrelated words", "role": "root"},
        {"name": " ada", "password": "three unrelated words", "role": "guest"},
        {"name": "a\u202eda", "password": "three unrelated words", "role": "guest"},
        {"name": "a\u0000da", "password": "three unrelated words", "role": "guest"},
        {"name": "ada", "password": "three unrelated words", "role": "guest", "id": "1"},
        {"name": "\ufdfa" * 60, "password": "three unrelated words", "role": "guest"},
    ],
)
@pytest.mark.asyncio(loop_scope="module")
async def test_person_that_breaks_a_rule_is_refused(shared_hub, asked) -> None:
    answer = await (await shared_hub.client("admin")).post("/api/people", json=asked)
    assert (answer.status_code, answer.json()["code"]) == (422, "invalid")


async def test_last_admin_stays_one(hub) -> None:
    admin = await hub.client("admin")
    path = f"/api/people/{(await people_of(admin))['admin']['id']}"
    for asked in ({"role": "operator"}, {"disabled": True}):
        answer = await admin.patch(path, json=asked)
        assert (answer.status_code, answer.json()["code"]) == (409, "last_admin")
    answer = await admin.delete(path)
    assert (answer.status_code, answer.json()["code"]) == (409, "last_admin")
    assert (await people_of(admin))["admin"]["role"] == "admin"
    other = (await people_of(admin))["operator"]
    await admin.patch(f"/api/people/{other['id']}", json={"role": "admin"})
    assert (await admin.patch(path, json={"role": "guest"})).json()["role"] == "guest"


async def test_of_two_admins_who_demote_each_other_one_stays(hub) -> None:
    admin = await hub.client("admin")
    found = await people_of(admin)
    await admin.patch(f"/api/people/{found['guest']['id']}", json={"role": "admin"})
    second = await hub.client("guest")
    answers = await asyncio.gather(
        admin.patch(f"/api/people/{found['guest']['id']}", json={"role": "guest"}),
        second.patch(f"/api/people/{found['admin']['id']}", json={"role": "guest"}),
    )
    assert sum(answer.status_code == 200 for answer in answers) == 1


@pytest.mark.asyncio(loop_scope="module")
async def test_nobody_but_an_admin_manages(shared_hub) -> None:
    for name in ("operator", "guest"):
        client = await shared_hub.client(name)
        for method, path, body in (
            ("GET", "/api/people", None),
            ("POST", "/api/people", {"name": "x", "password": PASSWORD, "role": "admin"}),
            ("PATCH", "/api/people/1", {"role": "admin"}),
            ("GET", "/api/roles", None),
            ("PUT", "/api/roles/2", {"name": "operator", "permissions": [may("admin")]}),
            ("GET", "/api/openapi.json", None),
        ):
            answer = await client.request(method, path, json=body)
            assert answer.status_code == 403, (method, path)


@pytest.mark.parametrize("path", ["0", "-1", "x", "9" * 40, "1e3", "%00", "１"])
@pytest.mark.asyncio(loop_scope="module")
async def test_person_or_role_that_is_not_there_is_said_so(shared_hub, path) -> None:
    admin = await shared_hub.client("admin")
    assert (await admin.patch(f"/api/people/{path}", json={})).status_code == 404
    assert (await admin.delete(f"/api/people/{path}/factor")).status_code == 404
    asked = {"name": "night", "permissions": []}
    assert (await admin.put(f"/api/roles/{path}", json=asked)).status_code == 404
    assert (await admin.delete(f"/api/me/tokens/{path}")).status_code == 404


async def test_change_of_role_frees_the_lease_and_closes_the_page_within_a_second(
    hub, gateway
) -> None:
    admin = await hub.client("admin")
    person = (await people_of(admin))["operator"]["id"]
    page = await holding(hub, gateway)
    change = admin.patch(f"/api/people/{person}", json={"role": "guest"})
    await freed_at_once(page, gateway, change)


async def test_person_who_is_disabled_or_removed_drives_no_more(hub, gateway) -> None:
    admin = await hub.client("admin")
    person = (await people_of(admin))["operator"]["id"]
    page = await holding(hub, gateway)
    change = admin.patch(f"/api/people/{person}", json={"disabled": True})
    await freed_at_once(page, gateway, change)
    await admin.patch(f"/api/people/{person}", json={"disabled": False})
    hub._cookies.clear()
    page = await holding(hub, gateway)
    await freed_at_once(page, gateway, admin.delete(f"/api/people/{person}"))


async def test_session_that_is_ended_drives_no_more(hub, gateway) -> None:
    admin = await hub.client("admin")
    person = (await people_of(admin))["operator"]["id"]
    page = await holding(hub, gateway)
    change = admin.delete(f"/api/people/{person}/sessions")
    await freed_at_once(page, gateway, change)


async def test_permissions_that_are_edited_reach_open_pages_within_a_second(hub, gateway) -> None:
    admin = await hub.client("admin")
    role = (await roles_of(admin))["operator"]["id"]
    page = await holding(hub, gateway)
    asked = {"name": "operator", "permissions": [may("view")]}
    await freed_at_once(page, gateway, admin.put(f"/api/roles/{role}", json=asked))
    me = (await (await hub.client("operator")).get("/api/me")).json()
    assert me["permissions"] == [may("view")]


async def test_change_by_another_program_reaches_open_pages_too(hub) -> None:
    page = await hub.page("operator")
    await hub.people.set_password("operator", "hash")
    assert await page.closed() == 4401


async def test_role_that_was_made_holds_exactly_its_permissions(hub, gateway) -> None:
    admin = await hub.client("admin")
    asked = {"name": "night shift", "permissions": [may("use", "agv", "base")]}
    made = await admin.post("/api/roles", json={**asked, "permissions": asked["permissions"] * 2})
    assert made.json()["permissions"] == asked["permissions"]
    ada = {"name": "ada", "password": PASSWORD, "role": "night shift"}
    assert (await admin.post("/api/people", json=ada)).status_code == 200
    client = await hub.client("ada")
    devices = {
        each["device"]: each for each in (await client.get("/api/devices")).json()["devices"]
    }
    assert devices["base"]["rights"] == ["view", "use"]
    assert all(
        each["rights"] == [] and each["public"] for d, each in devices.items() if d != "base"
    )
    page = await hub.page("ada")
    await page.say(page_wire.PageLease(site="agv", device="base", op=LeaseOp.TAKE))
    await gateway.hear(LeaseRequest, lambda ask: ask.device == "base")
    role = made.json()["id"]
    answer = await admin.delete(f"/api/roles/{role}")
    assert (answer.status_code, answer.json()["code"]) == (409, "in_use")
    person = (await people_of(admin))["ada"]["id"]
    await admin.delete(f"/api/people/{person}")
    assert (await admin.delete(f"/api/roles/{role}")).status_code == 204


async def test_seeded_roles_keep_their_names_and_admin_its_permissions(hub) -> None:
    admin = await hub.client("admin")
    roles = await roles_of(admin)
    assert [name for name in roles if roles[name]["seeded"]] == ["guest", "operator", "admin"]
    assert roles["admin"]["people"] == 1
    for name, asked in (
        ("admin", {"name": "admin", "permissions": []}),
        ("guest", {"name": "visitor", "permissions": []}),
    ):
        answer = await admin.put(f"/api/roles/{roles[name]['id']}", json=asked)
        assert (answer.status_code, answer.json()["code"]) == (409, "seeded")
    answer = await admin.delete(f"/api/roles/{roles['guest']['id']}")
    assert (answer.status_code, answer.json()["code"]) == (409, "seeded")
    for name in ("Admin", "OPERATOR"):
        answer = await admin.post("/api/roles", json={"name": name, "permissions": []})
        assert (answer.status_code, answer.json()["code"]) == (409, "taken")
    odd = {"name": "odd", "permissions": [may("use", "../x")]}
    assert (await admin.post("/api/roles", json=odd)).status_code == 422


async def test_token_has_at_most_the_rights_of_its_person_at_each_use(hub, gateway) -> None:
    admin, operator = await hub.client("admin"), await hub.client("operator")
    made = await token_of(operator, may("use", "agv", "base"))
    assert made["token"].startswith("tal_")
    script = await hub.client()
    script.headers["Authorization"] = f"Bearer {made['token']}"
    me = (await script.get("/api/me")).json()
    assert me["permissions"] == [may("use", "agv", "base")]
    assert (await script.get("/api/sites/agv")).status_code == 200
    role = (await roles_of(admin))["operator"]["id"]
    asked = {"name": "operator", "permissions": [may("view")]}
    await admin.put(f"/api/roles/{role}", json=asked)
    me = (await script.get("/api/me")).json()
    assert me["permissions"] == [may("view", "agv", "base")]
    (listed,) = (await operator.get("/api/me/tokens")).json()["tokens"]
    assert listed["used_us"] > 0
    assert "token" not in listed


async def test_token_manages_nothing(hub) -> None:
    admin = await hub.client("admin")
    made = await token_of(admin, may("use"))
    script = await hub.client()
    script.headers["Authorization"] = f"Bearer {made['token']}"
    for method, path, body in (
        ("GET", "/api/people", None),
        ("GET", "/api/roles", None),
        ("GET", "/api/audit", None),
        ("GET", "/api/me/sessions", None),
        ("DELETE", "/api/me/sessions", None),
        ("GET", "/api/me/tokens", None),
        ("POST", "/api/me/tokens", {"name": "x", "ends_us": 1, "permissions": []}),
        ("POST", "/api/me/password", {"old": PASSWORD, "new": "another password"}),
        ("POST", "/api/me/factor", {"password": PASSWORD}),
        ("POST", "/api/logout", None),
    ):
        answer = await script.request(method, path, json=body)
        assert answer.status_code == 403, (method, path)
    answer = await admin.post(
        "/api/me/tokens",
        json={"name": "x", "ends_us": 2**53, "permissions": [may("view")]},
    )
    assert answer.status_code == 422
    ends_us = SystemClock().wall_ns() // 1000 + HOUR_US
    asked = {"name": "x", "ends_us": ends_us, "permissions": [may("admin")]}
    assert (await admin.post("/api/me/tokens", json=asked)).status_code == 422


async def test_token_is_refused_more_rights_than_its_person_has(hub) -> None:
    guest = await hub.client("guest")
    ends_us = SystemClock().wall_ns() // 1000 + HOUR_US
    asked = {"name": "x", "ends_us": ends_us, "permissions": [may("view", "agv", "base")]}
    answer = await guest.post("/api/me/tokens", json=asked)
    assert (answer.status_code, answer.json()["code"]) == (403, "forbidden")


async def test_token_that_is_revoked_or_whose_person_is_disabled_is_dead_at_once(
    hub, gateway
) -> None:
    admin, operator = await hub.client("admin"), await hub.client("operator")
    made = await token_of(operator, may("use"))
    socket = await script_socket(hub, made["token"])
    assert (await socket.hear(page_wire.Greeting)).who == "operator"
    assert (await operator.delete(f"/api/me/tokens/{made['id']}")).status_code == 204
    assert await socket.closed() == 4401
    script = await hub.client()
    script.headers["Authorization"] = f"Bearer {made['token']}"
    assert (await script.get("/api/me")).status_code == 401
    made = await token_of(operator, may("use"))
    socket = await script_socket(hub, made["token"])
    await socket.hear(page_wire.Greeting)
    person = (await people_of(admin))["operator"]["id"]
    await admin.patch(f"/api/people/{person}", json={"disabled": True})
    assert await socket.closed() == 4401


async def test_token_ends_with_the_password_of_its_person_whoever_changes_it(hub, gateway) -> None:
    admin, operator = await hub.client("admin"), await hub.client("operator")
    mine = await token_of(operator, may("use"))
    of_admin = await token_of(admin, may("use"))
    socket = await script_socket(hub, mine["token"])
    await socket.hear(page_wire.Greeting)
    changed = {"old": PASSWORD, "new": "another long password"}
    assert (await operator.post("/api/me/password", json=changed)).status_code == 204
    assert await socket.closed() == 4401
    assert (await operator.get("/api/me/tokens")).json()["tokens"] == []
    second = await token_of(operator, may("use"))
    person = (await people_of(admin))["operator"]["id"]
    reset = await admin.patch(f"/api/people/{person}", json={"password": "one more password"})
    assert reset.status_code == 200
    for text, answer in ((mine, 401), (second, 401), (of_admin, 200)):
        script = await hub.client()
        script.headers["Authorization"] = f"Bearer {text['token']}"
        assert (await script.get("/api/me")).status_code == answer


async def test_token_of_someone_else_cannot_be_revoked(hub) -> None:
    made = await token_of(await hub.client("operator"), may("view"))
    admin = await hub.client("admin")
    assert (await admin.delete(f"/api/me/tokens/{made['id']}")).status_code == 404


async def test_script_that_also_brings_a_cookie_is_taken_for_a_page(hub) -> None:
    made = await token_of(await hub.client("operator"), may("view"))
    headers = {"Authorization": f"Bearer {made['token']}", "Cookie": await hub.cookie("operator")}
    with pytest.raises(websockets.InvalidStatus) as refused:
        await hub.dial("/ws", headers)
    assert refused.value.response.status_code == 403


async def test_every_change_is_written_down_without_a_secret(hub) -> None:
    admin, operator = await hub.client("admin"), await hub.client("operator")
    asked = {"name": "ada", "password": "three unrelated words", "role": "guest"}
    person = (await admin.post("/api/people", json=asked)).json()["id"]
    await admin.patch(
        f"/api/people/{person}", json={"role": "operator", "password": "new words 12"}
    )
    await admin.delete(f"/api/people/{person}/sessions")
    role = (
        await admin.post("/api/roles", json={"name": "night", "permissions": [may("view", "agv")]})
    ).json()["id"]
    await admin.put(f"/api/roles/{role}", json={"name": "day", "permissions": [may("use", "agv")]})
    await admin.delete(f"/api/roles/{role}")
    await admin.delete(f"/api/people/{person}")
    made = await token_of(operator, may("view"))
    await operator.delete(f"/api/me/tokens/{made['id']}")
    await operator.post("/api/me/password", json={"old": PASSWORD, "new": "another password"})
    await hub.hub.audit.log.wait_written()
    rows = (await admin.get("/api/audit", params={"limit": 100})).json()["rows"]
    said = {row["kind"]: (row["who"], row["message"]) for row in rows}
    assert said["person added"] == ("admin", "ada (guest)")
    assert said["person changed"] == ("admin", "ada: role guest -> operator, new password")
    assert said["person signed out"] == ("admin", "ada")
    assert said["role added"] == ("admin", "night: view agv/*")
    assert said["role changed"] == ("admin", "night: view agv/* -> day: use agv/*")
    assert said["role removed"] == ("admin", "day")
    assert said["person removed"] == ("admin", "ada (operator)")
    assert said["token made"] == ("operator", "script: view */*")
    assert said["token revoked"] == ("operator", "script")
    assert said["password changed"] == ("operator", "")
    secrets = (PASSWORD, "three unrelated", "new words", "another password", made["token"][4:])
    assert not [row for row in rows if any(secret in row["message"] for secret in secrets)]


def test_what_a_token_leaves_is_never_more_than_either() -> None:
    person = Grants(frozenset({Permission(Right.USE, "agv"), Permission(Right.VIEW, ANY, "dome")}))
    for asked, left in (
        ({Permission(Right.ADMIN)}, person.permissions),
        ({Permission(Right.VIEW, "agv", "base")}, {Permission(Right.VIEW, "agv", "base")}),
        ({Permission(Right.USE, "moon")}, {Permission(Right.VIEW, "moon", "dome")}),
        ({Permission(Right.USE, "moon", "base")}, set()),
        (set(), set()),
    ):
        assert person.limited_to(frozenset(asked)).permissions == left
    assert person.covers(Permission(Right.VIEW, "agv"))
    assert not person.covers(Permission(Right.VIEW))
    assert not person.covers(Permission(Right.USE, "agv2"))
