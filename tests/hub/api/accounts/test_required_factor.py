"""A second factor that a role requires, and codes that are locked after many wrong ones."""

from __future__ import annotations

import dataclasses
import ipaddress

import pyotp
import pytest

from talaia.clock import SECOND, HandClock, SystemClock
from talaia.hub.auth.secret_box import Seal
from talaia.hub.policy import BEFORE_FACTOR, ROUTES
from talaia.hub.store.accounts.mfa import LOCK_S, WRONG_CODES, CodeVerdict, SecondFactors
from talaia.hub.store.accounts.people import People

from ...conftest import PASSWORD
from ...mailbox import want_mail

MINUTE = 60 * SECOND


async def code_of(answer) -> tuple[int, str]:
    return answer.status_code, answer.json()["code"]


async def require(admin, role: str, *, required: bool = True):
    roles = {each["name"]: each for each in (await admin.get("/api/roles")).json()["roles"]}
    return await admin.put(f"/api/roles/{roles[role]['id']}/factor", json={"required": required})


async def set_factor(client) -> tuple[pyotp.TOTP, list[str]]:
    offer = (await client.post("/api/me/factor", json={"password": PASSWORD})).json()
    totp = pyotp.TOTP(offer["secret"])
    code = totp.at(SystemClock().wall_ns() // SECOND - 30)
    answer = await client.post("/api/me/factor/confirm", json={"code": code})
    assert answer.status_code == 200, answer.text
    return totp, answer.json()["recovery"]


async def test_who_has_no_factor_where_one_is_required_sets_one_up_before_anything_else(
    hub,
) -> None:
    admin, operator = await hub.client("admin"), await hub.client("operator")
    page = await hub.page("operator")
    assert (await require(admin, "operator")).json()["factor_required"] is True
    # Who is signed in is held up at once, with what they have open.
    await page.closed()
    assert await code_of(await operator.get("/api/sites")) == (403, "factor_required")
    assert (await operator.get("/api/me")).json()["factor_missing"] is True
    anew = await hub.client("operator")
    for method, path in (
        ("GET", "/api/devices"),
        ("POST", "/api/me/tokens"),
        ("POST", "/api/me/password"),
        ("GET", "/api/me/sessions"),
        ("GET", "/api/people"),
    ):
        asked = await anew.request(method, path, json={} if method == "POST" else None)
        assert await code_of(asked) == (403, "factor_required"), path
    with pytest.raises(Exception, match="HTTP 403"):
        await hub.page("operator")
    await set_factor(anew)
    assert (await anew.get("/api/me")).json()["factor_missing"] is False
    assert (await anew.get("/api/sites")).status_code == 200
    # Others are as they were.
    assert (await (await hub.client("guest")).get("/api/sites")).status_code == 200


async def test_factor_that_is_required_cannot_be_removed_by_its_person(hub) -> None:
    admin, operator = await hub.client("admin"), await hub.client("operator")
    _, recovery = await set_factor(operator)
    await require(admin, "operator")
    removal = {"password": PASSWORD, "code": recovery[0]}
    kept = await operator.post("/api/me/factor/remove", json=removal)
    assert await code_of(kept) == (409, "required")
    await require(admin, "operator", required=False)
    removal["code"] = recovery[1]
    assert (await operator.post("/api/me/factor/remove", json=removal)).status_code == 204


async def test_admin_requires_a_factor_of_admins_only_with_one_of_their_own(hub) -> None:
    admin = await hub.client("admin")
    assert await code_of(await require(admin, "admin")) == (409, "no_factor")
    assert (await admin.get("/api/people")).status_code == 200
    await set_factor(admin)
    assert (await require(admin, "admin")).status_code == 200
    assert (await admin.get("/api/people")).status_code == 200
    await hub.hub.audit.log.wait_written()
    rows = (await admin.get("/api/audit", params={"limit": 50})).json()["rows"]
    assert ("second factor required", "role admin") in {(r["kind"], r["message"]) for r in rows}


@pytest.mark.pure
def test_everything_that_is_open_before_the_factor_is_a_route() -> None:
    assert set(ROUTES) >= BEFORE_FACTOR


async def test_many_wrong_codes_lock_codes_for_an_hour_on_every_database(database) -> None:
    clock = HandClock()
    user = await People(database, clock).add_person("ada", "hash", "guest")
    factors = SecondFactors(database, clock, lambda: Seal(b"k" * 32))
    totp = pyotp.TOTP(await factors.offer_factor(user))
    recovery = await factors.confirm_factor(user, totp.at(clock.wall_ns() // SECOND))

    def right() -> str:
        clock.advance(MINUTE)
        return totp.at(clock.wall_ns() // SECOND)

    # A right one between them begins the count anew.
    for _ in range(WRONG_CODES - 1):
        assert await factors.use_code(user, "nothing") is CodeVerdict.WRONG
    assert await factors.use_code(user, right()) is CodeVerdict.RIGHT
    for _ in range(WRONG_CODES - 1):
        assert await factors.use_code(user, "nothing") is CodeVerdict.WRONG
    assert await factors.use_code(user, "nothing") is CodeVerdict.LOCKS
    assert await factors.use_code(user, right()) is CodeVerdict.LOCKED
    # The person has a way in that cannot be guessed.
    assert await factors.use_code(user, recovery[0]) is CodeVerdict.RECOVERY
    clock.advance(LOCK_S * SECOND)
    assert await factors.use_code(user, right()) is CodeVerdict.RIGHT


@pytest.fixture
def settings(settings):
    return dataclasses.replace(settings, notify_networks=(ipaddress.ip_network("127.0.0.0/8"),))


async def test_person_is_told_by_mail_and_at_the_next_sign_in_that_somebody_tried_codes(
    hub, mailbox
) -> None:
    operator = await hub.client("operator")
    await want_mail(hub, mailbox, site="agv", least="critical")
    # Two rules of one address: one mail.
    await want_mail(hub, mailbox, site="agv")
    totp, recovery = await set_factor(operator)
    factors = hub.hub.people.proving._factors
    user = (await hub.people.find_by_name("operator")).id
    for _ in range(WRONG_CODES - 1):
        await factors.use_code(user, "nothing")
    thief = await hub.client()
    asked = {"name": "operator", "password": PASSWORD, "code": "000000"}
    said = await thief.post("/api/login", json=asked)
    assert await code_of(said) == (401, "factor_locked")
    asked["code"] = totp.now()
    assert await code_of(await thief.post("/api/login", json=asked)) == (401, "factor_locked")
    while not mailbox.envelopes:
        mailbox.news.clear()
        await mailbox.news.wait()
    assert mailbox.text().startswith("Wrong codes for your account")
    assert "change your password" in " ".join(mailbox.text().split())
    owner = await hub.client()
    signed = await owner.post("/api/login", json={**asked, "code": recovery[0]})
    assert signed.status_code == 200, signed.text
    assert signed.json()["codes_locked_us"] > 0
    assert (await owner.post("/api/me/factor/seen", json={})).status_code == 204
    assert (await owner.get("/api/me")).json()["codes_locked_us"] == 0
    assert len(mailbox.envelopes) == 1
