"""Sign-in by a provider that tells the truth, and by one that lies; over real sockets."""

from __future__ import annotations

import dataclasses
import json

import pytest

from talaia.hub.auth.oidc_settings import read_oidc_settings
from talaia.hub.errors import CannotStart

from ...conftest import PASSWORD, RunningHub
from ...fake_provider import ANOTHER_KEY, CLIENT, SECRET, serve_provider


@pytest.fixture
async def provider():
    async with serve_provider() as provider:
        yield provider


@pytest.fixture
def start(settings, history, provider, tmp_path):
    """Make hubs that know the provider; what is given changes the file."""

    def make(**more: object) -> RunningHub:
        (tmp_path / "secret").write_text(f"{SECRET}\n")
        asked = {
            "issuer": provider.issuer,
            "client_id": CLIENT,
            "client_secret_file": "secret",
            "label": "the house",
            "groups": {"chiefs": "admin", "pilots": "operator"},
            "new_people": True,
            **more,
        }
        file = tmp_path / "oidc.yaml"
        # JSON is YAML.
        file.write_text(json.dumps(asked))
        return RunningHub(dataclasses.replace(settings, oidc=file), history)

    return make


async def code_of(answer) -> tuple[int, str]:
    return answer.status_code, answer.json()["code"]


async def begin(client, path: str = "/api/login/oidc", returns: str = "/home") -> str:
    answer = await client.post(path, json={"returns": returns})
    assert answer.status_code == 200, answer.text
    return answer.json()["url"]


async def finish(client, back: dict):
    return await client.post("/api/login/oidc/finish", json=back)


async def sign_in(hub, provider):
    client = await hub.client()
    answer = await finish(client, provider.sign_in(await begin(client)))
    return client, answer


async def test_first_sign_in_makes_an_account_with_the_role_of_the_group_and_each_later_one_follows(
    start, provider
) -> None:
    async with start() as hub:
        await hub.populate()
        client, answer = await sign_in(hub, provider)
        assert answer.json() == {"purpose": "sign_in", "returns": "/home"}
        me = (await client.get("/api/me")).json()
        assert (me["name"], me["role"], me["password"]) == ("ada", "operator", False)
        # Another name there is the same person here.
        provider.claims |= {"preferred_username": "countess", "groups": ["chiefs"]}
        again, answer = await sign_in(hub, provider)
        assert answer.status_code == 200, answer.text
        me = (await again.get("/api/me")).json()
        assert (me["name"], me["role"]) == ("ada", "admin")
        # The rights of before have ended with the role.
        assert (await client.get("/api/me")).status_code == 401
        provider.claims["groups"] = ["cooks"]
        _, answer = await sign_in(hub, provider)
        assert await code_of(answer) == (403, "provider")


async def test_no_password_opens_an_account_that_has_none_until_an_admin_gives_one(
    start, provider
) -> None:
    async with start() as hub:
        await hub.populate()
        client, _ = await sign_in(hub, provider)
        anybody = await hub.client()
        for password in ("", "ada", PASSWORD):
            asked = {"name": "ada", "password": password}
            assert (await anybody.post("/api/login", json=asked)).status_code == 401
        own = await client.post("/api/me/password", json={"old": "", "new": "quite another one"})
        assert await code_of(own) == (409, "no_password")
        admin = await hub.client("admin")
        people = {
            one["name"]: one["id"] for one in (await admin.get("/api/people")).json()["people"]
        }
        given = {"password": "quite another password"}
        assert (await admin.patch(f"/api/people/{people['ada']}", json=given)).status_code == 200
        asked = {"name": "ada", **given}
        assert (await anybody.post("/api/login", json=asked)).status_code == 200


async def test_name_alone_takes_nobodys_account_and_its_person_connects_it(start, provider) -> None:
    provider.claims["preferred_username"] = "Admin"
    async with start() as hub:
        await hub.populate()
        _, answer = await sign_in(hub, provider)
        assert await code_of(answer) == (403, "provider")
        admin = await hub.client("admin")
        url = await begin(admin, "/api/me/oidc/connect", "/account")
        done = await finish(admin, provider.sign_in(url))
        assert done.json() == {"purpose": "connect", "returns": "/account"}
        # The group would make an operator of the last admin.
        client, answer = await sign_in(hub, provider)
        assert answer.status_code == 200, answer.text
        me = (await client.get("/api/me")).json()
        assert (me["name"], me["role"], me["password"]) == ("admin", "admin", True)
        # It is connected with one person here.
        operator = await hub.client("operator")
        url = await begin(operator, "/api/me/oidc/connect")
        assert await code_of(await finish(operator, provider.sign_in(url))) == (403, "provider")


async def test_lies_of_a_token_let_nobody_in_and_the_truth_does(start, provider) -> None:
    async with start(domains=["uni.example"]) as hub:
        await hub.populate()
        provider.claims |= {"email": "ada@UNI.example", "email_verified": True}
        for lies in (
            {"iss": "https://evil.example"},
            {"aud": "another client"},
            {"aud": [CLIENT, "another"]},
            {"azp": "another"},
            {"nonce": "another"},
            {"nonce": None},
            {"exp": 1},
            {"exp": None},
            {"exp": "9999999999"},
            {"iat": 1},
            {"iat": 9_999_999_999},
            {"sub": None},
            {"sub": ["1"]},
            {"groups": None},
            {"groups": {"pilots": True}},
            {"preferred_username": None},
            {"preferred_username": "a\nb"},
            {"email_verified": False},
            {"email_verified": None},
            {"email_verified": "true"},
            {"email": "ada@not-uni.example"},
            {"email": "ada@uni.example.evil.example"},
        ):
            provider.lies = lies
            client, answer = await sign_in(hub, provider)
            assert await code_of(answer) == (403, "provider"), lies
            assert (await client.get("/api/me")).status_code == 401
        provider.lies = {}
        assert (await sign_in(hub, provider))[1].status_code == 200


async def test_token_that_nobody_has_signed_or_somebody_else_has_lets_nobody_in(
    start, provider
) -> None:
    async with start() as hub:
        await hub.populate()
        provider.algorithm = "none"
        assert await code_of((await sign_in(hub, provider))[1]) == (403, "provider")
        provider.algorithm, provider.key = "RS256", ANOTHER_KEY
        assert await code_of((await sign_in(hub, provider))[1]) == (403, "provider")


async def test_answer_is_good_once_in_the_browser_that_asked_and_from_the_provider_that_was_asked(
    start, provider
) -> None:
    async with start() as hub:
        await hub.populate()
        mine, theirs = await hub.client(), await hub.client()
        back = provider.sign_in(await begin(mine))
        await begin(theirs)
        # A thief's answer in somebody's browser, and the other way round.
        assert await code_of(await finish(theirs, back)) == (403, "provider")
        assert await code_of(await finish(await hub.client(), back)) == (403, "provider")
        assert (await finish(mine, back)).status_code == 200
        assert await code_of(await finish(mine, back)) == (403, "provider")
        # A code that was used, with a new state.
        again = await begin(mine)
        replay = {**provider.sign_in(again), "code": back["code"]}
        assert await code_of(await finish(mine, replay)) == (403, "provider")
        # A code of one sign-in in another: its verifier does not fit.
        one, other = provider.sign_in(await begin(mine)), await begin(theirs)
        swapped = {**provider.sign_in(other), "code": one["code"]}
        assert await code_of(await finish(theirs, swapped)) == (403, "provider")
        mixed = {**provider.sign_in(await begin(mine)), "iss": "https://evil.example"}
        assert await code_of(await finish(mine, mixed)) == (403, "provider")
        named = {**provider.sign_in(await begin(mine)), "iss": provider.issuer}
        assert (await finish(mine, named)).status_code == 200
        refused = {"state": provider.sign_in(await begin(mine))["state"], "error": "access_denied"}
        assert await code_of(await finish(mine, refused)) == (403, "provider")


async def test_provider_that_always_names_itself_must_and_one_of_another_name_is_not_asked(
    start, provider
) -> None:
    provider.discovery = {"authorization_response_iss_parameter_supported": True}
    async with start() as hub:
        await hub.populate()
        assert await code_of((await sign_in(hub, provider))[1]) == (403, "provider")
    for lie in ({"issuer": "https://evil.example"}, {"token_endpoint": "http://evil.example/t"}):
        provider.discovery = lie
        async with start() as hub:
            client = await hub.client()
            answer = await client.post("/api/login/oidc", json={})
            assert await code_of(answer) == (502, "provider"), lie


async def test_person_without_a_password_confirms_by_a_fresh_sign_in_of_their_own(
    start, provider
) -> None:
    provider.claims["groups"] = ["chiefs"]
    async with start() as hub:
        await hub.populate()
        client, _ = await sign_in(hub, provider)
        fresh = hub.hub.people.sessions._confirmations
        person = {"name": "eve", "password": "three unrelated words", "role": "guest"}

        async def come_back() -> tuple[int, str]:
            fresh._given.clear()
            url = await begin(client, "/api/me/oidc/confirm")
            assert "prompt=login" in url
            assert "max_age=300" in url
            done = await finish(client, provider.sign_in(url))
            asked = await client.post("/api/people", json=person)
            return done.status_code, asked.json().get("code", "done")

        # Long ago, not said when, and somebody else.
        for lies in ({"auth_time": 1}, {"auth_time": None}, {"sub": "2"}):
            provider.lies = lies
            assert await come_back() == (403, "confirm"), lies
        provider.lies = {}
        assert await come_back() == (200, "done")


async def test_a_sign_in_of_long_ago_there_or_of_no_time_confirms_nothing_but_a_new_account(
    start, provider
) -> None:
    provider.claims["groups"] = ["chiefs"]
    async with start() as hub:
        await hub.populate()
        person = {"name": "eve", "password": "three unrelated words", "role": "guest"}
        provider.lies = {"auth_time": None}
        # New: nobody can have left anything of it open.
        client, _ = await sign_in(hub, provider)
        assert (await client.post("/api/people", json=person)).status_code == 200
        for lies in ({"auth_time": None}, {"auth_time": 1}):
            provider.lies = lies
            client, _ = await sign_in(hub, provider)
            asked = await client.post("/api/people", json={**person, "name": "eva"})
            assert await code_of(asked) == (403, "confirm"), lies
        provider.lies = {}
        client, _ = await sign_in(hub, provider)
        asked = await client.post("/api/people", json={**person, "name": "eva"})
        assert asked.status_code == 200


async def test_an_account_is_disconnected_by_its_person_or_an_admin_and_never_left_without_a_way_in(
    start, provider
) -> None:
    async with start() as hub:
        await hub.populate()
        admin = await hub.client("admin")
        operator, elsewhere = await hub.client("operator"), await hub.client("operator")
        assert await code_of(await operator.delete("/api/me/oidc")) == (409, "missing")
        await finish(operator, provider.sign_in(await begin(operator, "/api/me/oidc/connect")))
        assert (await operator.get("/api/me/oidc")).json() == {"connected": True}
        # A page that was left open takes nothing away.
        hub.hub.people.sessions._confirmations._given.clear()
        assert await code_of(await operator.delete("/api/me/oidc")) == (403, "confirm")
        await operator.post("/api/me/confirm", json={"password": PASSWORD})
        assert (await operator.delete("/api/me/oidc")).status_code == 204
        assert (await operator.get("/api/me/oidc")).json() == {"connected": False}
        assert (await elsewhere.get("/api/me")).status_code == 401
        # The same subject is somebody new now.
        client, _ = await sign_in(hub, provider)
        people = {each["name"]: each for each in (await admin.get("/api/people")).json()["people"]}
        assert (people["ada"]["provider"], people["operator"]["provider"]) == (True, False)
        assert await code_of(await client.delete("/api/me/oidc")) == (409, "no_password")
        path = f"/api/people/{people['ada']['id']}"
        assert await code_of(await admin.delete(f"{path}/oidc")) == (409, "no_password")
        await admin.post("/api/me/confirm", json={"password": PASSWORD})
        given = {"password": "quite another password"}
        assert (await admin.patch(path, json=given)).status_code == 200
        client, _ = await sign_in(hub, provider)
        assert (await admin.delete(f"{path}/oidc")).status_code == 204
        assert (await client.get("/api/me")).status_code == 401
        assert await code_of(await admin.delete(f"{path}/oidc")) == (409, "missing")
        assert await code_of(await admin.delete("/api/people/999/oidc")) == (404, "unknown")


async def test_who_is_disabled_stays_out_and_the_role_asks_no_factor_of_who_the_provider_has_let_in(
    start, provider
) -> None:
    async with start() as hub:
        await hub.populate()
        client, _ = await sign_in(hub, provider)
        admin = await hub.client("admin")
        roles = {one["name"]: one["id"] for one in (await admin.get("/api/roles")).json()["roles"]}
        asked = await admin.put(f"/api/roles/{roles['operator']}/factor", json={"required": True})
        assert asked.status_code == 200
        assert (await client.get("/api/me")).json()["factor_missing"] is False
        assert (await client.get("/api/sites")).status_code == 200
        people = {
            one["name"]: one["id"] for one in (await admin.get("/api/people")).json()["people"]
        }
        await admin.patch(f"/api/people/{people['ada']}", json={"disabled": True})
        assert await code_of((await sign_in(hub, provider))[1]) == (403, "provider")


@pytest.mark.pure
@pytest.mark.parametrize(
    ("text", "said"),
    [
        ("issuer: http://login.example", "no https address"),
        ("issuer: https://login.example?x=1", "no https address"),
        ("issuer: https://login.example\nrole: ''", "neither groups nor role"),
        ("issuer: https://login.example\nrolle: guest", "rolle"),
        ("issuer: https://login.example\ndomains: ['@uni.example']", "domains"),
        ("[", "talaia docs openid-connect"),
    ],
)
def test_file_that_asks_for_what_is_not_safe_is_refused_by_name(tmp_path, text, said) -> None:
    file = tmp_path / "oidc.yaml"
    more = "" if text == "[" else "\nclient_id: talaia\nclient_secret_file: secret"
    more += "" if "role" in text or text == "[" or "rolle" in text else "\nrole: guest"
    file.write_text(text + more)
    with pytest.raises(CannotStart, match=said):
        read_oidc_settings(file)
