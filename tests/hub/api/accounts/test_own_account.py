"""Own account: password, sessions, second factor, throttle; each over a hub that really serves."""

import asyncio

import pyotp
import pytest
from sqlalchemy import select, text

from talaia.clock import SECOND, HandClock, SystemClock
from talaia.hub.auth.passwords import check_password
from talaia.hub.auth.secret_box import Seal, seal_of
from talaia.hub.auth.throttle import Throttle
from talaia.hub.auth.totp import new_recovery, otp_uri, qr_svg, step_of
from talaia.hub.errors import CannotStart, WeakPassword
from talaia.hub.store.accounts.failed_logins import FailedLogins
from talaia.hub.store.accounts.mfa import CodeVerdict, SecondFactors
from talaia.hub.store.accounts.people import People
from talaia.hub.store.tables import users
from talaia.wire import browser as page_wire

PASSWORD = "a password for tests"  # noqa: S105
OTHER = "quite another password"
MINUTE = 60 * SECOND


async def code_of(answer) -> tuple[int, str]:
    return answer.status_code, answer.json()["code"]


async def with_factor(client) -> tuple[pyotp.TOTP, list[str]]:
    """Set a second factor for the person of ``client``, whose next code is not used yet."""
    offer = (await client.post("/api/me/factor", json={"password": PASSWORD})).json()
    totp = pyotp.TOTP(offer["secret"])
    # The code of the step before: the one of now stays good. A step that ends just then makes it
    # one that is too old, and the next one is not.
    for _ in range(2):
        code = totp.at(SystemClock().wall_ns() // SECOND - 30)
        answer = await client.post("/api/me/factor/confirm", json={"code": code})
        if answer.status_code == 200:
            break
    assert answer.status_code == 200, answer.text
    return totp, answer.json()["recovery"]


def sign_in(name="operator", password=PASSWORD, **more):
    return {"name": name, "password": password, **more}


@pytest.mark.parametrize(
    "password",
    [
        "password",
        "PASSWORD",
        "12345678",
        "iloveyou",
        "trustno1",
        "operator",
        "Operator123",
        "talaia99",
        # Not in any list as they stand, and among the first that guessing programs try.
        "aaaaaaaa",
        "letmein2026",
        "Password2026!",
        "operator-operator",
        "Montserrat1",
        "qwertzuiop12",
        "x" * 64,
    ],
)
def test_common_passwords_and_names_are_refused(password) -> None:
    with pytest.raises(WeakPassword):
        check_password(password, "operator")


@pytest.mark.parametrize(
    "password",
    [
        "a password for tests",
        "ünï¢ödé pass",
        "rain on seven green hills " * 3,
        # Drawn at random, and as short as may be.
        "k7!vq9zt",
        "xK9#mQ2p",
    ],
)
def test_any_character_and_length_is_taken(password) -> None:
    check_password(password, "operator")


async def test_new_password_ends_every_other_session_and_its_sockets(hub) -> None:
    here, there = await hub.client("operator"), await hub.client("operator")
    page = await hub.page("operator")  # of the session there
    asked = {"old": PASSWORD, "new": OTHER}
    assert (await here.post("/api/me/password", json=asked)).status_code == 204
    assert await page.closed() == 4401
    assert (await there.get("/api/me")).status_code == 401
    assert (await here.get("/api/me")).status_code == 200
    anew = await hub.client()
    assert (await anew.post("/api/login", json=sign_in())).status_code == 401
    assert (await anew.post("/api/login", json=sign_in(password=OTHER))).status_code == 200


async def test_new_password_takes_the_old_one_and_a_good_one(hub) -> None:
    client = await hub.client("operator")
    wrong = await client.post("/api/me/password", json={"old": "not it at all", "new": OTHER})
    assert await code_of(wrong) == (403, "wrong")
    weak = await client.post("/api/me/password", json={"old": PASSWORD, "new": "password1"})
    assert await code_of(weak) == (422, "invalid")
    assert (await hub.client("operator")) is not None


async def test_sessions_are_listed_and_ended_one_by_one_or_all(hub) -> None:
    here = await hub.client("operator")
    there = await hub.client("operator")
    page = await hub.page("operator")
    await hub.client("admin")
    listed = (await here.get("/api/me/sessions")).json()["sessions"]
    assert [each["this"] for each in listed].count(True) == 1
    assert len(listed) == 2
    assert all("httpx" in each["agent"] and each["address"] == "127.0.0.1" for each in listed)
    other = next(each["id"] for each in listed if not each["this"])
    assert (await here.delete(f"/api/me/sessions/{other}")).status_code == 204
    assert await page.closed() == 4401
    assert (await there.get("/api/me")).status_code == 401
    assert (await here.delete(f"/api/me/sessions/{other}")).status_code == 404
    third = await hub.client("operator")
    assert (await here.delete("/api/me/sessions")).status_code == 204
    assert (await third.get("/api/me")).status_code == 401
    assert (await here.get("/api/me")).status_code == 200


async def test_session_of_someone_else_cannot_be_ended(hub) -> None:
    admin, operator = await hub.client("admin"), await hub.client("operator")
    (session,) = (await admin.get("/api/me/sessions")).json()["sessions"]
    assert (await operator.delete(f"/api/me/sessions/{session['id']}")).status_code == 404
    assert (await admin.get("/api/me")).status_code == 200


async def test_second_factor_is_asked_for_and_each_code_is_taken_once(hub) -> None:
    client = await hub.client("operator")
    totp, _ = await with_factor(client)
    assert (await client.get("/api/me")).json()["factor"] is True
    fresh = await hub.client()
    needed = await fresh.post("/api/login", json=sign_in())
    assert await code_of(needed) == (401, "factor")
    assert "needed" in needed.json()["message"]
    wrong = await fresh.post("/api/login", json=sign_in(code="000000"))
    assert await code_of(wrong) == (401, "factor")
    code = totp.now()
    assert (await fresh.post("/api/login", json=sign_in(code=code))).status_code == 200
    replayed = await (await hub.client()).post("/api/login", json=sign_in(code=code))
    assert await code_of(replayed) == (401, "factor")
    assert "used already" in replayed.json()["message"]


async def test_wrong_password_tells_nothing_of_the_second_factor(hub) -> None:
    await with_factor(await hub.client("operator"))
    client = await hub.client()
    for code in ("", "000000"):
        answer = await client.post("/api/login", json=sign_in(password="wrong", code=code))  # noqa: S106
        assert await code_of(answer) == (401, "wrong")


async def test_recovery_code_opens_once_however_it_is_typed(hub) -> None:
    _, codes = await with_factor(await hub.client("operator"))
    assert len(set(codes)) == 10
    typed = codes[0].upper().replace("-", " ")
    client = await hub.client()
    assert (await client.post("/api/login", json=sign_in(code=typed))).status_code == 200
    again = await client.post("/api/login", json=sign_in(code=codes[0]))
    assert await code_of(again) == (401, "factor")
    assert (await client.post("/api/login", json=sign_in(code=codes[1]))).status_code == 200


async def test_second_factor_is_removed_with_password_and_code_only(hub) -> None:
    client = await hub.client("operator")
    totp, _ = await with_factor(client)
    again = await client.post("/api/me/factor", json={"password": PASSWORD})
    assert await code_of(again) == (409, "taken")
    asked = {"password": PASSWORD, "code": "000000"}
    refused = await client.post("/api/me/factor/remove", json=asked)
    assert await code_of(refused) == (403, "factor")
    asked = {"password": "wrong", "code": totp.now()}
    refused = await client.post("/api/me/factor/remove", json=asked)
    assert await code_of(refused) == (403, "wrong")
    asked = {"password": PASSWORD, "code": totp.now()}
    assert (await client.post("/api/me/factor/remove", json=asked)).status_code == 204
    assert (await (await hub.client()).post("/api/login", json=sign_in())).status_code == 200


async def test_factor_that_was_not_confirmed_is_not_asked_for(hub) -> None:
    client = await hub.client("operator")
    await client.post("/api/me/factor", json={"password": PASSWORD})
    wrong = await client.post("/api/me/factor/confirm", json={"code": "000000"})
    assert await code_of(wrong) == (403, "factor")
    assert (await client.get("/api/me")).json()["factor"] is False
    await hub.client("operator")


async def test_no_secret_of_a_factor_stands_in_the_database_or_the_audit_log(hub) -> None:
    client = await hub.client("operator")
    totp, codes = await with_factor(client)
    await hub.hub.audit.log.wait_written()
    async with hub.hub.core.database.read() as connection:
        rows = [str(tuple(row)) for row in await connection.execute(select(users))]
        rows += [str(tuple(row)) for row in await connection.execute(text("SELECT * FROM audit"))]
        rows += [
            str(tuple(r)) for r in await connection.execute(text("SELECT * FROM recovery_codes"))
        ]
    assert not [row for row in rows if totp.secret in row or any(code in row for code in codes)]


async def test_factor_works_on_every_database_and_five_who_race_get_one_in(database) -> None:
    clock = HandClock()
    user = await People(database, clock).add_person("ada", "hash", "guest")
    factors = SecondFactors(database, clock, lambda: Seal(b"k" * 32))
    secret = await factors.offer_factor(user)
    totp = pyotp.TOTP(secret)
    now_s = clock.wall_ns() // SECOND
    codes = await factors.confirm_factor(user, totp.at(now_s))
    assert await factors.use_code(user, totp.at(now_s)) is CodeVerdict.REPLAYED
    clock.advance(MINUTE)
    code = totp.at(clock.wall_ns() // SECOND)
    verdicts = await asyncio.gather(*(factors.use_code(user, code) for _ in range(5)))
    assert sorted(each.name for each in verdicts) == ["REPLAYED"] * 4 + ["RIGHT"]
    verdicts = await asyncio.gather(*(factors.use_code(user, codes[3]) for _ in range(5)))
    assert sorted(each.name for each in verdicts) == ["RECOVERY"] + ["WRONG"] * 4
    assert await factors.remove_factor(user)
    assert await factors.use_code(user, codes[4]) is CodeVerdict.WRONG


def test_codes_near_now_are_taken_and_no_others() -> None:
    secret = pyotp.random_base32()
    totp = pyotp.TOTP(secret)
    now = 1_700_000_010
    step = now // 30
    assert [step_of(secret, totp.at(now + 30 * off), now) for off in (-2, -1, 0, 1, 2)] == [
        None, step - 1, step, step + 1, None,
    ]  # fmt: skip
    for odd in ("", "12345", "1234567", "１２３４５６", "-00001", "0x1234", totp.at(now) + "0"):
        assert step_of(secret, odd, now) is None


def test_recovery_codes_hold_120_bits_and_the_picture_no_script() -> None:
    codes = {code for _ in range(50) for code in new_recovery()}
    assert len(codes) == 500
    assert {len(code.replace("-", "")) for code in codes} == {24}
    drawn = qr_svg(otp_uri("A" * 32, "</svg><script>alert(1)</script>"))
    assert drawn.startswith("<svg")
    assert "script" not in drawn
    assert "style" not in drawn


def test_seal_is_bound_to_its_key_and_to_what_it_is_about(tmp_path) -> None:
    seal = seal_of(tmp_path / "seal.key")
    kept = seal.seal_text("secret", "one")
    assert seal_of(tmp_path / "seal.key").open_text(kept, "one") == "secret"
    assert seal.open_text(kept, "two") is None
    assert Seal(b"k" * 32).open_text(kept, "one") is None
    assert seal.open_text("no such thing", "one") is None
    assert (tmp_path / "seal.key").stat().st_mode & 0o777 == 0o600
    (tmp_path / "seal.key").write_bytes(b"short")
    with pytest.raises(CannotStart, match=r"seal\.key holds no key"):
        seal_of(tmp_path / "seal.key")


async def test_flood_of_wrong_tries_does_not_keep_a_known_browser_out(hub) -> None:
    known = await hub.client("operator")
    await known.post("/api/logout")
    stranger = await hub.client()
    statuses = [
        (await stranger.post("/api/login", json=sign_in(password=f"wrong {at}"))).status_code
        for at in range(60)
    ]
    assert statuses.count(401) < 10
    assert set(statuses) == {401, 429}
    assert (await stranger.post("/api/login", json=sign_in())).status_code == 429
    assert (await known.post("/api/login", json=sign_in())).status_code == 200
    # The cookie of one person's browser helps nobody to another's account.
    for at in range(40):
        await known.post("/api/login", json=sign_in("admin", f"wrong {at}"))
    assert (await known.post("/api/login", json=sign_in("admin"))).status_code == 429


async def test_known_browser_is_throttled_too(hub) -> None:
    known = await hub.client("operator")
    statuses = [
        (await known.post("/api/login", json=sign_in(password=f"wrong {at}"))).status_code
        for at in range(20)
    ]
    assert statuses.count(401) < 10


async def test_wrong_tries_outlast_a_restart_and_are_forgotten_in_time(database) -> None:
    clock = HandClock()

    async def started() -> Throttle:
        throttle = Throttle()
        await FailedLogins(database, clock, throttle).bring_back()
        return throttle

    throttle = Throttle()
    tries = FailedLogins(database, clock, throttle)
    for _ in range(8):
        throttle.count_attempt("ada", "10.0.0.1", clock.wall_ns())
        await tries.save_counts()
    left = throttle.wait_ns("ada", "10.0.0.1", clock.wall_ns())
    assert left > 5 * SECOND
    assert (await started()).wait_ns("ada", "10.0.0.1", clock.wall_ns()) == left
    throttle.clear_attempts("ada", "10.0.0.1")
    await tries.save_counts()
    assert (await started()).wait_ns("ada", "10.0.0.1", clock.wall_ns()) == 0
    for _ in range(50):
        throttle.count_attempt("ada", "10.0.0.1", clock.wall_ns())
    await tries.save_counts()
    clock.advance(16 * MINUTE)
    assert (await started()).wait_ns("ada", "10.0.0.1", clock.wall_ns()) == 0


def test_wall_clock_that_is_set_back_makes_nobody_wait_longer() -> None:
    throttle = Throttle()
    for _ in range(50):
        throttle.count_attempt("ada", "10.0.0.1", 10_000 * SECOND)
    assert 0 < throttle.wait_ns("ada", "10.0.0.1", 9_900 * SECOND) <= MINUTE
    assert throttle.wait_ns("ada", "10.0.0.1", 0) == 0


async def test_hundreds_of_wrong_passwords_never_make_anyone_wait_longer_than_a_minute(hub) -> None:
    stranger = await hub.client()
    for at in range(200):
        answer = await stranger.post("/api/login", json=sign_in(password=f"wrong {at}"))
        assert answer.status_code in {401, 429}
        if answer.status_code == 429:
            assert int(answer.headers["retry-after"]) <= 60


async def test_asking_in_the_background_does_not_keep_a_session(hub) -> None:
    client = await hub.client("operator")
    async with hub.hub.core.database.write() as connection:
        await connection.execute(text("UPDATE sessions SET used_us = used_us - 600000000"))
    quiet = await client.get("/api/me", headers={"Talaia-Background": "1"})
    loud = await client.get("/api/me")
    assert loud.json()["idle_ends_us"] - quiet.json()["idle_ends_us"] > 599_000_000
    after = await client.get("/api/me", headers={"Talaia-Background": "1"})
    assert after.json()["idle_ends_us"] - quiet.json()["idle_ends_us"] > 599_000_000


async def test_holder_of_a_lease_is_warned_before_the_session_ends(hub, gateway) -> None:
    page = await hub.page("operator")
    life_us = round(hub.settings.life_s * 1e6)
    now_us = SystemClock().wall_ns() // 1000
    async with hub.hub.core.database.write() as connection:
        await connection.execute(
            text("UPDATE sessions SET created_us = :at"), {"at": now_us - life_us + 60_000_000}
        )
    news = await page.hear(page_wire.SessionUpdate)
    assert not news.idle
    assert abs(news.ends_us - now_us - 60_000_000) < 1_000_000
    async with hub.hub.core.database.write() as connection:
        await connection.execute(text("UPDATE sessions SET created_us = 0"))
    assert "session is over" in (await page.hear(page_wire.SessionEnded)).reason


async def test_touching_the_page_keeps_a_session_that_is_about_to_end(hub) -> None:
    page = await hub.page("operator")
    idle_us = round(hub.settings.idle_s * 1e6)
    now_us = SystemClock().wall_ns() // 1000
    async with hub.hub.core.database.write() as connection:
        await connection.execute(
            text("UPDATE sessions SET used_us = :at"), {"at": now_us - idle_us + 90_000_000}
        )
    assert (await page.hear(page_wire.SessionUpdate)).idle
    await page.say(page_wire.PagePing(n=1, at_ms=0.0))
    await page.hear(page_wire.PagePong)
    await page.say(page_wire.PagePing(n=2, at_ms=0.0, active=True))
    assert (await page.hear(page_wire.SessionUpdate)).ends_us == 0
