"""An evening's walk: asked for, armed, watched, rained on, resumed, and told of in the morning.

All of it is real: the simulated observatory, its gateway, the hub with its database, a mail server
and a page in Chromium. What the hardware did is read from the simulator's own ledger. Only waiting
is short: everything moves twenty times as fast, and the rules let go after a second.
"""

from __future__ import annotations

import asyncio
import re
import time
from collections import Counter
from collections.abc import AsyncIterator, Awaitable, Callable
from pathlib import Path
from typing import Any

import httpx
import pytest
from msgspec.structs import replace
from patience import ASK_S, PATIENCE_MS
from ports import free_port
from shared_trust import usual_trust

from talaia.hub import accounts
from talaia.hub.settings import Settings
from talaia.model.units import astronomy
from talaia.model.yaml_text.load import dump_site, load_site
from talaia.sim.observatory.night import longitude_of_night

from .conftest import launching, need_ros2
from .mail_server import Mailbox, mail_server
from .observatory import EXAMPLE, Observatory
from .stack import PASSWORD, Process, until

pytestmark = [pytest.mark.robot, pytest.mark.browser]
SITE = "observatory"
AT = f"/api/sites/{SITE}"
HOUR_US = 3_600_000_000
FRAMES = 3
Answer = Callable[[], Awaitable[Any]]


@pytest.fixture
async def mailbox() -> AsyncIterator[Mailbox]:
    async with mail_server() as mailbox:
        yield mailbox


def described() -> str:
    """Give the example with rules that let go after a second, and without focus and centring."""
    site = load_site(EXAMPLE.read_text())
    assert site.night is not None
    rules = {
        name: replace(rule, dwell=1.0, when=tuple(replace(each, dwell=None) for each in rule.when))
        for name, rule in site.interlocks.items()
    }
    # Those two have tests of their own.
    times = replace(
        site.night.times, unpark=0.0, acquire=0.0, settle=0.5, readout=0.5, focus_run=0.0
    )
    night = replace(site.night, focuser=None, centring=None, times=times)
    return dump_site(replace(site, interlocks=rules, night=night))


def group(name: str, hours_east: float) -> dict[str, object]:
    """Ask for some frames of what culminates in so many hours."""
    now = time.time()
    hours = astronomy.sidereal_hours(astronomy.julian_day(now), longitude_of_night(now))
    one = {
        "target": {
            "type": "ICRS", "name": name, "ra": (hours + hours_east) % 24 * 15, "dec": 40.0
        },
        "configurations": [{"exposure": 20.0, "count": FRAMES, "filter": "R"}],
        "windows": [
            {"start_us": round(now * 1e6) - HOUR_US, "end_us": round(now * 1e6) + 5 * HOUR_US}
        ],
    }  # fmt: skip
    return {"proposal": "STARS-1", "name": name, "requests": [one]}


async def sign_in(address: str, name: str) -> httpx.AsyncClient:
    client = httpx.AsyncClient(
        base_url=address, headers={"Origin": address}, timeout=60, verify=usual_trust()
    )
    (await client.post("/api/login", json={"name": name, "password": PASSWORD})).raise_for_status()
    return client


async def prepare(address: str, mail_port: int) -> httpx.AsyncClient:
    """Make a proposal of which ada is a member, and have her told of nights; give her session."""
    admin, ada = await sign_in(address, "admin"), await sign_in(address, "ada")
    proposal = {"id": "STARS-1", "title": "Stars", "hours_allocated": 20.0, "share": 1.0}
    assert (await admin.post(f"{AT}/proposals", json=proposal)).status_code == 201
    member = {"name": "ada", "role": "member"}
    answer = await admin.put(f"{AT}/proposals/STARS-1/members", json=member)
    assert answer.status_code == 204, answer.text
    way = {
        "name": "Mail", "kind": "mail", "host": "127.0.0.1", "port": mail_port,
        "security": "none", "sender": "talaia@example.org",
    }  # fmt: skip
    made = await admin.post("/api/ways", json=way)
    assert made.status_code == 201, made.text
    rule = {"site": SITE, "way": made.json()["id"], "target": "ada@example.org", "nights": True}
    added = await ada.post("/api/me/rules", json={**rule, "group_s": 0})
    assert added.status_code == 201, added.text
    await admin.aclose()
    return ada


async def rows(ada: httpx.AsyncClient) -> list[dict[str, Any]]:
    answer = await ada.get(f"{AT}/requests")
    answer.raise_for_status()
    return answer.json()["requests"]


async def pictures(ada: httpx.AsyncClient) -> dict[str, list[str]]:
    """Name the pictures of each request that the archive has."""
    return {
        row["target"]: [
            frame["name"]
            for frame in (await ada.get(f"{AT}/requests/{row['id']}/frames")).json()["frames"]
        ]
        for row in await rows(ada)
    }


async def comes(ask: Answer, holds: Callable[[Any], bool], what: str) -> Any:
    """Ask again and again until the answer is as it should be."""
    deadline = time.monotonic() + PATIENCE_MS / 1000
    while not holds(answer := await ask()):
        assert time.monotonic() < deadline, (what, answer)
        await asyncio.sleep(ASK_S)
    return answer


async def test_an_evening_is_asked_for_armed_watched_rained_on_resumed_and_told_by_mail(
    tmp_path: Path, mailbox: Mailbox, chromium: str
) -> None:
    need_ros2()
    port = free_port()
    address = f"http://localhost:{port}"
    settings = Settings(
        data=tmp_path / "hub", host="127.0.0.1", port=port, plain=True, password_cost=4
    )
    for name, role in (("admin", "admin"), ("ada", "operator")):
        await accounts.create_user(settings, name, PASSWORD, role)
    key = await accounts.create_gateway(settings, SITE)
    site = Observatory(tmp_path, described(), speed=20)
    (tmp_path / "key").write_text(key)
    words = ["-m", "talaia", "hub", "--data", str(tmp_path / "hub"), "--plain"]
    words += ["--host", "127.0.0.1", "--port", str(port), "--notify-network", "127.0.0.0/8"]
    try:
        hub = Process(words, tmp_path / "hub.log", {})
        site.parts.append(hub)
        await site.parts[0].says("ready")
        await hub.says("ready")
        gateway = site.start_gateway("--hub", f"ws://127.0.0.1:{port}")
        await gateway.says("linked to")
        ada = await prepare(address, mailbox.port)
        await walk(site, ada, mailbox, chromium)
        await ada.aclose()
    finally:
        site.close()


async def walk(site: Observatory, ada: httpx.AsyncClient, mailbox: Mailbox, program: str) -> None:
    from playwright.async_api import async_playwright, expect

    expect.set_options(timeout=PATIENCE_MS)
    async with async_playwright() as play:
        chromium = await play.chromium.launch(**launching(program))
        page = await chromium.new_page()
        page.set_default_timeout(PATIENCE_MS)
        errors: list[str] = []
        page.on("pageerror", lambda error: errors.append(str(error)))
        address = str(ada.base_url)
        await page.goto(f"{address}/login")
        await page.get_by_label("Name").fill("ada")
        await page.get_by_label("Password").fill(PASSWORD)
        await page.get_by_role("button", name="Sign in", exact=True).click()
        await page.wait_for_url("**/home")
        await page.goto(f"{address}/sites/{SITE}/night")
        state = page.locator("t-night-state")
        # She arms the night; nothing is asked for, so the roof stays closed.
        await page.get_by_role("button", name="Arm…").click()
        await page.get_by_role("button", name="Arm", exact=True).click()
        await expect(state).to_contain_text("Armed by ada")
        assert {each["said"] for each in truths(site)} <= {"closed"}

        for name, hours in (("Alpha", 0.3), ("Beta", 0.8), ("Gamma", 1.3)):
            answer = await ada.post(f"{AT}/request-groups", json=group(name, hours))
            assert answer.status_code == 201, answer.text
        await expect(state).to_contain_text("Observing")
        # The first picture of the evening is in the archive.
        await comes(lambda: pictures(ada), lambda found: any(found.values()), "a picture")

        site.order("weather rain")
        await expect(state).to_contain_text("Rain")
        await until(lambda: truths(site)[-1]["said"] == "closed", what="the roof closes")
        # Who looks now is told of each what became of it, or why it waits.
        for row in await rows(ada):
            assert row["state"] == "COMPLETED" or row["why_not"]["message"], row
        before = len(truths(site))
        site.order("weather clear")
        await until(
            lambda: "open" in {each["said"] for each in truths(site)[before:]}, what="it reopens"
        )
        await comes(
            lambda: rows(ada),
            lambda found: {row["state"] for row in found} == {"COMPLETED"},
            "all are observed",
        )
        # Each exposure of the sky that was read out has come, once, to the request it was for. (One
        # that ended in the moment of the rain was not counted, and is there all the same.)
        read_out = Counter(
            each["asked"].split()[-1]
            for each in site.ledger()
            if each["phase"] == "done" and " light " in each["asked"]
        )
        assert set(read_out) == {"Alpha", "Beta", "Gamma"}
        assert min(read_out.values()) >= FRAMES
        found = await comes(
            lambda: pictures(ada),
            lambda each: {name: len(set(files)) for name, files in each.items()} == read_out,
            f"all pictures: {read_out}",
        )
        assert sum(map(len, found.values())) == read_out.total()

        # It is morning: the time that the night was armed for is over.
        over = {"until_us": round((time.time() + 2) * 1e6)}
        answer = await ada.post(f"{AT}/night/arm", json=over)
        assert answer.json()["refused"] == "", answer.text
        await expect(state).to_contain_text("Disarmed")
        over_now = "Observatory: the night is over (info)"
        await until(lambda: over_now in mailbox.to("ada"), what="the morning's report")
        assert errors == []
        await chromium.close()
    assert truths(site)[-1]["said"] == "closed"
    (told,) = [mail for mail in mailbox.mails if mail.subject == over_now]
    assert "3 requests observed, 9 frames: " in told.text
    # Where a sensor's value is late, as on a machine that does much else, that breaks it off, too;
    # if it does so just before the rain, the rain has nothing left to break off.
    assert re.search(r"broken off \d+ times?: .*(Rain|no value newer than)", told.text)


def truths(site: Observatory) -> list[dict[str, Any]]:
    """Give how the shutter really stood, in order."""
    return site.asked("dome", "truth")
