"""Interlocks, from gateway to pages, and who may override them."""

from pathlib import Path

import pytest

from talaia.wire import browser as page_wire, frames

EXAMPLE = (Path(__file__).parents[4] / "examples" / "agv" / "site.yaml").read_text()
GUARDED = EXAMPLE.replace(
    "\ninterlocks:\n",
    """
interlocks:
  slope:
    name: Too steep
    when: [{signal: base/speed, above: 1}]
    refuse: [base/wander]
    slow: {base/drive: 0.4}
    longest_override: 600
""",
)


@pytest.fixture
async def guarded(hub):
    """A gateway whose description has an interlock."""
    gateway = await hub.gateway()
    await gateway.hello(GUARDED)
    return gateway


def state(**more) -> frames.InterlockState:
    return frames.InterlockState(interlock="slope", locked=True, unsafe=True, **more)


def override(seconds: float, reason: str = "ramp test") -> page_wire.PageOverride:
    return page_wire.PageOverride(site="agv", interlock="slope", reason=reason, seconds=seconds)


async def test_every_change_reaches_every_page_and_one_that_comes_later(hub, guarded) -> None:
    page = await hub.page("operator")
    await guarded.say(state(why="Speed: no value yet"))
    await page.hear(page_wire.InterlockUpdate, lambda news: "no value" in news.why)
    await guarded.say(state(why="Speed is above 1 m/s", for_ms=60_000))
    news = await page.hear(page_wire.InterlockUpdate, lambda news: "above" in news.why)
    assert (news.name, news.locked, news.unsafe) == ("Too steep", True, True)
    assert (news.refuses, news.targets) == (["Vehicle base: Wander about"], ["base/wander"])
    assert (news.slows, news.slowed) == (["Vehicle base: driving to 40\u202f%"], ["base/drive"])
    assert news.longest_s == 0
    later = await (await hub.page("admin")).hear(page_wire.InterlockUpdate)
    assert later.why == news.why
    assert abs(later.since_us - news.since_us) < 2_000_000
    assert later.longest_s == 600


async def test_commands_of_a_device_are_named_to_those_who_may_see_them(hub, guarded) -> None:
    # Its speed is public, and by that a guest knows of the vehicle.
    guest = await hub.page("guest")
    await guarded.say(state(why="Speed is above 1 m/s"))
    news = await guest.hear(page_wire.InterlockUpdate)
    # That it is locked, and neither which of its commands nor that it drives.
    assert (news.name, news.locked) == ("Too steep", True)
    assert (news.refuses, news.targets, news.slows, news.slowed) == ([], [], [], [])


async def test_only_an_admin_overrides_with_a_reason_and_within_the_bound(hub, guarded) -> None:
    operator, admin = await hub.page("operator"), await hub.page("admin")
    await operator.say(override(60))
    assert (await operator.hear(page_wire.RequestError)).code == "forbidden"
    for bad in (override(601), override(60, " ")):
        await admin.say(bad)
        assert (await admin.hear(page_wire.RequestError)).code == "invalid"
    await admin.say(override(60))
    asked = await guarded.hear(frames.OverrideRequest)
    assert (asked.interlock, asked.who, asked.reason) == ("slope", "admin", "ramp test")
    assert asked.seconds == 60


async def test_an_override_is_shown_with_who_why_and_for_how_long(hub, guarded) -> None:
    page = await hub.page("operator")
    await guarded.say(state(overridden_by="admin", reason="ramp test", override_ms=60_000))
    news = await page.hear(page_wire.InterlockUpdate)
    assert (news.overridden_by, news.reason) == ("gateway: admin", "ramp test")
    # In the name of whoever asked for it here.
    await (admin := await hub.page("admin")).say(override(60))
    await guarded.hear(frames.OverrideRequest)
    await guarded.say(state(overridden_by="admin", reason="ramp test", override_ms=60_000))
    await admin.hear(page_wire.InterlockUpdate, lambda news: news.overridden_by == "admin")
    assert 50_000 <= news.override_ms <= 60_000


async def test_nothing_is_queued_for_a_gateway_that_is_away(hub, guarded) -> None:
    admin = await hub.page("admin")
    await guarded.close()
    await admin.hear(page_wire.SiteUpdate, lambda news: not news.online)
    await admin.say(override(60))
    assert (await admin.hear(page_wire.RequestError)).code == "offline"
