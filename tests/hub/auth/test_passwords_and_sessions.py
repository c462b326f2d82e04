"""Passwords, the throttle, permissions and sessions."""

import asyncio
import dataclasses

import pytest
from hypothesis import given, strategies as st

from talaia.clock import SECOND, HandClock
from talaia.hub.auth.passwords import Passwords, check_name, check_password, name_key
from talaia.hub.auth.permissions import Grants, Permission, Right
from talaia.hub.auth.throttle import Throttle
from talaia.hub.errors import NameTaken, UnknownRole, WeakPassword
from talaia.hub.store.accounts.people import People
from talaia.hub.store.accounts.sessions import Sessions

MINUTE = 60 * SECOND


async def test_password_fits_its_hash_and_no_other() -> None:
    passwords = Passwords(4)
    kept = await passwords.hash_password("correct horse")
    assert await passwords.verify_password("correct horse", kept)
    assert not await passwords.verify_password("correct horsf", kept)
    for guess in ("correct horse", "nobody", ""):
        assert not await passwords.verify_password(guess, None)


async def test_nothing_of_a_long_password_is_cut() -> None:
    passwords = Passwords(4)
    long = "ü" * 100
    kept = await passwords.hash_password(long + "a")
    assert await passwords.verify_password(long + "a", kept)
    assert not await passwords.verify_password(long + "b", kept)
    assert not await passwords.verify_password(long, kept)
    assert not await passwords.verify_password((long + "a") * 1000, kept)


async def test_default_cost_is_twelve(tmp_path) -> None:
    from talaia.hub.settings import Settings

    kept = await Passwords(Settings(data=tmp_path).password_cost).hash_password("correct horse")
    assert kept.startswith("$2b$12$")


@pytest.mark.parametrize("password", ["", "seven77", "x" * 1025])
def test_password_too_short_or_too_long_is_refused(password) -> None:
    with pytest.raises(WeakPassword):
        check_password(password)


@pytest.mark.parametrize("name", ["", " ada", "ada ", "a\nb", "a\u202eb", "x" * 65])
def test_name_that_could_deceive_is_refused(name) -> None:
    with pytest.raises(WeakPassword):
        check_name(name)


def test_names_are_compared_without_case_and_form() -> None:
    assert name_key("ÀDA") == name_key("a\u0300da")


def test_first_tries_are_free_and_then_the_wait_grows_and_ends() -> None:
    throttle = Throttle()
    waits = []
    now = 0
    for _ in range(14):
        now += throttle.wait_ns("ada", "1.2.3.4", now)
        throttle.count_attempt("ada", "1.2.3.4", now)
        waits.append(throttle.wait_ns("ada", "1.2.3.4", now) // SECOND)
    assert waits[:5] == [0, 0, 0, 0, 1]
    assert waits[4:] == sorted(waits[4:])
    assert waits[-1] == 60


def test_wait_for_a_person_holds_from_every_address() -> None:
    throttle = Throttle()
    for at in range(200):
        throttle.count_attempt("ada", f"10.0.0.{at}", 0)
    assert throttle.wait_ns("ada", "10.0.1.1", 0) > 0
    assert throttle.wait_ns("bob", "10.0.1.1", 0) == 0


def test_wait_for_an_address_holds_for_every_person() -> None:
    throttle = Throttle()
    for at in range(200):
        throttle.count_attempt(f"person {at}", "10.0.0.1", 0)
    assert throttle.wait_ns("ada", "10.0.0.1", 0) > 0


def test_nobody_is_locked_out_for_good() -> None:
    throttle = Throttle()
    for _ in range(1000):
        throttle.count_attempt("ada", "10.0.0.1", 0)
    assert throttle.wait_ns("ada", "10.0.0.1", 0) <= MINUTE
    assert throttle.wait_ns("ada", "10.0.0.1", 16 * MINUTE) == 0


def test_success_forgets_the_wrong_tries() -> None:
    throttle = Throttle()
    for _ in range(5):
        throttle.count_attempt("ada", "10.0.0.1", 0)
    throttle.clear_attempts("ada", "10.0.0.1")
    assert throttle.wait_ns("ada", "10.0.0.1", 0) == 0


def test_throttle_keeps_a_bounded_number_of_names() -> None:
    throttle = Throttle()
    for at in range(30_000):
        throttle.count_attempt(f"person {at}", f"address {at}", 0)
    assert [len(table) for table in throttle._tries.values()] == [10_000, 10_000, 0]


places = st.sampled_from(["*", "a", "b"])
permissions = st.builds(Permission, st.sampled_from(Right), places, places)


@given(st.frozensets(permissions), st.sampled_from(["a", "b"]), st.sampled_from(["a", "b"]))
def test_a_right_includes_the_lesser_ones(held, site, device) -> None:
    grants = Grants(held)
    rights = grants.rights_on(site, device)
    # Those that include one another; the others stand beside.
    assert rights == [Right.VIEW, Right.USE, Right.ADMIN][: len(rights)]


@given(st.frozensets(permissions), st.sampled_from(Right), st.sampled_from(["a", "b"]))
def test_right_on_the_whole_site_is_a_right_on_each_device(held, right, site) -> None:
    grants = Grants(held)
    if grants.has_right(right, site):
        assert grants.has_right(right, site, "a")
        assert grants.has_right(right, site, "b")


@given(st.frozensets(permissions), st.sampled_from(Right), st.sampled_from(["a", "b"]))
def test_the_devices_of_a_right_are_those_on_which_a_person_has_it(held, right, site) -> None:
    grants = Grants(held)
    named = grants.devices(right, site)
    for device in ("a", "b", "c"):
        assert grants.has_right(right, site, device) == (named is None or device in named)


@pytest.fixture
def clock() -> HandClock:
    return HandClock()


@pytest.fixture
def people(database, clock) -> People:
    return People(database, clock)


@pytest.fixture
def sessions(database, clock, settings) -> Sessions:
    short = dataclasses.replace(settings, idle_s=600.0, life_s=3600.0)
    return Sessions(database, clock, short)


async def test_name_is_taken_once_in_any_case(people) -> None:
    await people.add_person("Ada", "hash", "admin")
    with pytest.raises(NameTaken):
        await people.add_person("ADA", "hash", "guest")
    with pytest.raises(UnknownRole, match="admin, guest, operator"):
        await people.add_person("Bob", "hash", "root")
    found = await people.find_by_name("aDa")
    assert (found.name, found.role) == ("Ada", "admin")


async def test_session_brings_the_rights_of_the_role(people, sessions) -> None:
    token, alive = await sessions.start_session(
        await people.add_person("ada", "hash", "operator"), "::1"
    )
    assert await sessions.find_session(token) == alive
    who = alive.who
    assert who.grants.has_right(Right.USE, "anywhere")
    assert not who.grants.has_right(Right.ADMIN, "anywhere")
    assert await sessions.find_session(token + "x") is None
    assert await sessions.find_session(who.session) is None


async def test_session_ends_when_it_is_not_used(people, sessions, clock) -> None:
    token, _ = await sessions.start_session(await people.add_person("ada", "hash", "guest"), "::1")
    for _ in range(5):
        clock.advance(9 * MINUTE)
        assert await sessions.find_session(token) is not None
    clock.advance(11 * MINUTE)
    assert await sessions.find_session(token) is None


async def test_session_ends_after_its_life_however_much_it_is_used(people, sessions, clock) -> None:
    token, _ = await sessions.start_session(await people.add_person("ada", "hash", "guest"), "::1")
    for _ in range(6):
        clock.advance(9 * MINUTE)
        assert await sessions.find_session(token) is not None
    clock.advance(7 * MINUTE)
    assert await sessions.find_session(token) is None


async def test_all_sessions_of_a_person_end_together(people, sessions) -> None:
    ada = await people.add_person("ada", "hash", "guest")
    tokens = [(await sessions.start_session(ada, "::1"))[0] for _ in range(3)]
    await sessions.end_all(ada)
    assert [await sessions.find_session(token) for token in tokens] == [None] * 3


async def test_change_of_role_is_seen_in_the_session(people, sessions) -> None:
    token, before = await sessions.start_session(
        await people.add_person("ada", "hash", "operator"), "::1"
    )
    await people.set_role("ada", "guest")
    after = await sessions.find_session(token)
    assert after.who != before.who
    assert after.who.grants == Grants()


async def test_of_two_who_set_up_at_once_exactly_one_wins(people) -> None:
    token = await people.offer_setup(60.0)
    assert await people.set_up("wrong", "eve", "hash") is None
    won = await asyncio.gather(*(people.set_up(token, f"ada {at}", "hash") for at in range(5)))
    assert sum(each is not None for each in won) == 1
    assert await people.offer_setup(60.0) is None


async def test_setup_token_grows_old(people, clock) -> None:
    token = await people.offer_setup(60.0)
    assert await people.may_set_up(token)
    clock.advance(61 * SECOND)
    assert not await people.may_set_up(token)
    assert await people.set_up(token, "ada", "hash") is None
