"""Passkeys over a hub that really serves, by a passkey of our own that also answers wrongly."""

from __future__ import annotations

import asyncio

import pyotp
import pytest

from talaia.clock import SECOND, SystemClock
from talaia.hub.auth.passkey_ceremony import RegisteredPasskey
from talaia.hub.store.accounts.passkeys import Passkeys
from talaia.hub.store.accounts.people import People

from ...conftest import PASSWORD
from ...soft_passkey import SoftPasskey


@pytest.fixture
def at_name(hub):
    """Make clients that reach the hub by a name: browsers make no passkeys for an IP address."""

    async def open_client(name: str = ""):
        client = await hub.client(name)
        origin = f"http://localhost:{hub.port}"
        client.headers.update({"Host": f"localhost:{hub.port}", "Origin": origin})
        client.origin = origin
        return client

    return open_client


async def code_of(answer) -> tuple[int, str]:
    return answer.status_code, answer.json()["code"]


async def with_passkey(client, name: str = "key") -> tuple[SoftPasskey, list[str]]:
    key = SoftPasskey()
    asked = (await client.post("/api/me/passkeys/options", json={})).json()["options"]
    made = key.create(asked, client.origin)
    answer = await client.post("/api/me/passkeys", json={"name": name, "credential": made})
    assert answer.status_code == 200, answer.text
    return key, answer.json()["recovery"]


async def sign_in_options(client, **said) -> dict:
    answer = await client.post("/api/login/passkey/options", json=said)
    assert answer.status_code == 200, answer.text
    return answer.json()["options"]


async def sign_in(client, credential: dict):
    return await client.post("/api/login/passkey", json={"credential": credential})


def by_name(name: str = "operator") -> dict:
    return {"name": name, "password": PASSWORD}


async def test_passkey_signs_in_without_name_and_password_when_its_device_has_verified_the_person(
    at_name,
) -> None:
    client = await at_name("operator")
    key, recovery = await with_passkey(client)
    assert len(recovery) == 10
    elsewhere = await at_name()
    assert await code_of(await elsewhere.post("/api/login", json=by_name())) == (401, "factor")
    options = await sign_in_options(elsewhere)
    assert options["userVerification"] == "required"
    # Whoever asks is told of nobody's keys.
    assert options["allowCredentials"] == []
    answer = await sign_in(elsewhere, key.get(options, elsewhere.origin))
    assert answer.status_code == 200, answer.text
    assert (answer.json()["name"], answer.json()["factor"]) == ("operator", True)
    assert (await elsewhere.get("/api/me")).status_code == 200


async def test_passkey_that_verifies_nobody_is_a_second_factor_and_no_first(at_name) -> None:
    client = await at_name("operator")
    key, _ = await with_passkey(client)
    elsewhere = await at_name()
    alone = key.get(await sign_in_options(elsewhere), elsewhere.origin, verified=False)
    assert await code_of(await sign_in(elsewhere, alone)) == (401, "factor")
    wrong = await elsewhere.post(
        "/api/login/passkey/options", json={"name": "operator", "password": "not it at all"}
    )
    assert await code_of(wrong) == (401, "wrong")
    options = await sign_in_options(elsewhere, **by_name())
    assert len(options["allowCredentials"]) == 1
    answer = await sign_in(elsewhere, key.get(options, elsewhere.origin, verified=False))
    assert answer.status_code == 200, answer.text


async def test_answer_is_good_once_for_its_own_hub_origin_key_and_purpose(at_name) -> None:
    client = await at_name("operator")
    key, _ = await with_passkey(client)
    admins, _ = await with_passkey(await at_name("admin"))
    elsewhere = await at_name()

    async def refused(make) -> None:
        # A right one forgets the wrong ones before it.
        right = key.get(await sign_in_options(elsewhere), elsewhere.origin)
        assert (await sign_in(elsewhere, right)).status_code == 200
        options = await sign_in_options(elsewhere)
        answer = await sign_in(elsewhere, make(options))
        assert await code_of(answer) == (401, "factor"), answer.text

    await refused(lambda asked: key.get(asked, "https://evil.example"))
    await refused(lambda asked: key.get(asked, elsewhere.origin, host="evil.example"))
    await refused(lambda asked: key.get({"challenge": "AAAA"}, elsewhere.origin))
    await refused(lambda asked: {**key.get(asked, elsewhere.origin), "id": "AAAA", "rawId": "AAAA"})
    await refused(lambda _asked: {"id": key.id.hex(), "response": {"clientDataJSON": "§"}})
    # Signed by somebody else's key in the name of this one.
    stranger = SoftPasskey()
    stranger.id = key.id
    await refused(lambda asked: stranger.get(asked, elsewhere.origin))
    # After the operator's password the admin's key does not open.
    after = await sign_in_options(elsewhere, **by_name())
    other = await sign_in(elsewhere, admins.get(after, elsewhere.origin))
    assert await code_of(other) == (401, "factor")
    # What was asked to confirm, or to make a key, signs nobody in.
    for path in ("/api/me/passkeys/challenge", "/api/me/passkeys/options"):
        asked = (await client.post(path, json={})).json()["options"]
        taken = await sign_in(elsewhere, key.get(asked, elsewhere.origin))
        assert await code_of(taken) == (401, "factor")
    fresh = await at_name()
    once = key.get(await sign_in_options(fresh), fresh.origin)
    assert (await sign_in(fresh, once)).status_code == 200
    assert await code_of(await sign_in(fresh, once)) == (401, "factor")


async def test_copy_of_a_key_that_counts_is_found_by_its_count(at_name) -> None:
    client = await at_name("operator")
    key, _ = await with_passkey(client)
    for count, status in ((7, 200), (7, 401), (3, 401), (0, 401), (8, 200)):
        key.count = count
        elsewhere = await at_name()
        answer = await sign_in(elsewhere, key.get(await sign_in_options(elsewhere), client.origin))
        assert answer.status_code == status, count


async def test_passkeys_are_listed_renamed_and_removed_by_their_person_alone(at_name) -> None:
    operator, admin = await at_name("operator"), await at_name("admin")
    key, _ = await with_passkey(operator, "phone")
    _, more = await with_passkey(operator, "ring")
    # Recovery codes come with the first factor, and are not made anew behind one's back.
    assert more == []
    listed = (await operator.get("/api/me/passkeys")).json()
    assert [each["name"] for each in listed["passkeys"]] == ["phone", "ring"]
    assert {each["host"] for each in listed["passkeys"]} == {"localhost"}
    assert (listed["codes"], listed["possible"]) == (False, True)
    mine = listed["passkeys"][0]["id"]
    named = {"name": "old\nphone"}
    assert (await admin.patch(f"/api/me/passkeys/{mine}", json=named)).status_code == 404
    assert (await operator.patch(f"/api/me/passkeys/{mine}", json=named)).status_code == 204
    listed = (await operator.get("/api/me/passkeys")).json()
    assert [each["name"] for each in listed["passkeys"]] == ["old\\nphone", "ring"]
    assert (await admin.delete(f"/api/me/passkeys/{mine}")).status_code == 404
    assert (await operator.delete(f"/api/me/passkeys/{mine}")).status_code == 204
    elsewhere = await at_name()
    options = await sign_in_options(elsewhere)
    answer = await sign_in(elsewhere, key.get(options, elsewhere.origin))
    assert await code_of(answer) == (401, "factor")
    # The other is still asked for.
    assert await code_of(await elsewhere.post("/api/login", json=by_name())) == (401, "factor")


async def test_by_an_ip_address_no_passkey_is_begun_and_none_is_of_a_foreign_origin(
    hub, at_name
) -> None:
    numbered = await hub.client("operator")
    asked = await numbered.post("/api/me/passkeys/options", json={})
    assert await code_of(asked) == (409, "no_name")
    assert (await numbered.get("/api/me/passkeys")).json()["possible"] is False
    client, key = await at_name("operator"), SoftPasskey()
    options = (await client.post("/api/me/passkeys/options", json={})).json()["options"]
    made = key.create(options, "https://evil.example")
    answer = await client.post("/api/me/passkeys", json={"name": "key", "credential": made})
    assert await code_of(answer) == (422, "invalid")


async def test_lost_passkey_is_replaced_by_a_recovery_code_or_taken_away_by_an_admin(
    at_name,
) -> None:
    client = await at_name("operator")
    _, recovery = await with_passkey(client)
    elsewhere = await at_name()
    coded = {**by_name(), "code": recovery[0]}
    assert (await elsewhere.post("/api/login", json=coded)).status_code == 200
    admin = await at_name("admin")
    people = (await admin.get("/api/people")).json()["people"]
    number = next(each["id"] for each in people if each["name"] == "operator")
    assert (await admin.delete(f"/api/people/{number}/factor")).status_code == 204
    assert (await elsewhere.post("/api/login", json=by_name())).status_code == 200


async def test_codes_that_are_removed_leave_the_passkeys_and_their_recovery_codes(at_name) -> None:
    client = await at_name("operator")
    _, recovery = await with_passkey(client)
    offer = (await client.post("/api/me/factor", json={"password": PASSWORD})).json()
    totp, now_s = pyotp.TOTP(offer["secret"]), SystemClock().wall_ns() // SECOND
    done = await client.post("/api/me/factor/confirm", json={"code": totp.at(now_s - 30)})
    recovery = done.json()["recovery"]
    removal = {"password": PASSWORD, "code": totp.at(now_s)}
    assert (await client.post("/api/me/factor/remove", json=removal)).status_code == 204
    elsewhere = await at_name()
    assert await code_of(await elsewhere.post("/api/login", json=by_name())) == (401, "factor")
    coded = {**by_name(), "code": recovery[0]}
    assert (await elsewhere.post("/api/login", json=coded)).status_code == 200


async def test_passkeys_work_on_every_database_and_of_two_that_add_one_key_one_does(
    database,
) -> None:
    clock = SystemClock()
    user = await People(database, clock).add_person("ada", "hash", "guest")
    kept = Passkeys(database, clock)
    key = RegisteredPasskey("a" * 1300, "b" * 1300, 5)
    adding = (kept.add_passkey(user, "phone", "hub.example", key) for _ in range(2))
    made = await asyncio.gather(*adding, return_exceptions=True)
    assert sorted(isinstance(each, Exception) for each in made) == [False, True]
    found = await kept.find_passkey(key.credential_id)
    assert found.key == key
    used = await asyncio.gather(*(kept.mark_passkey_used(found, 6) for _ in range(3)))
    assert sorted(used) == [False, False, True]
    assert (await People(database, clock).find_by_id(user)).factor
    assert await kept.remove_passkey(user, found.id, keep_one=False) == "phone"
    assert not (await People(database, clock).find_by_id(user)).factor
