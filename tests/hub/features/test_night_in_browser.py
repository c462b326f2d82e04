"""The pages of the night in a real Chromium: a proposal, a request, the night armed."""

from __future__ import annotations

import os
import re
import time
from pathlib import Path

import pytest
from playwright.async_api import expect

from talaia.model.observing.plan import (
    PauseKind,
    Plan,
    PlannedBlock,
    PlannedPause,
    VetoCause,
    WhyNot,
)
from talaia.wire.frames import NightArmRequest, NightPlan, NightState, RequestRevision, RequestSync
from talaia.wire.gateway_messages.relayed_fields import NightPhase

from ..chromium import sign_in

pytestmark = [pytest.mark.browser, pytest.mark.timeout(180)]

SITE = "observatory"
DESCRIPTION = (Path(__file__).parents[3] / "examples" / "observatory" / "site.yaml").read_text()
HOUR = 3600.0


@pytest.fixture
async def observatory(hub):
    """A hub with an observatory whose gateway is there."""
    key = await hub.hub.gateways.registry.new_key(SITE)
    hub.dome = await hub.gateway(key=key)
    await hub.dome.hello(DESCRIPTION, site=SITE)
    return hub


async def keep(page, name: str) -> None:
    """Keep screenshots, wide and narrow and in each theme, where a person asked for them."""
    folder = os.environ.get("TALAIA_PICTURES")
    if not folder:
        return
    for width, (wide, tall) in {"desktop": (1440, 900), "phone": (390, 844)}.items():
        await page.set_viewport_size({"width": wide, "height": tall})
        for theme in ("light", "dark", "night"):
            script = "theme => { document.documentElement.dataset.theme = theme }"
            await page.evaluate(script, theme)
            path = Path(folder) / f"{name}-{width}-{theme}.png"
            await page.screenshot(path=path, full_page=True)
    await page.set_viewport_size({"width": 1440, "height": 900})


async def make_proposal(page, origin: str) -> None:
    """Make a proposal by its form, of which the admin is a member."""
    await page.goto(f"{origin}/sites/{SITE}/proposals")
    await expect(page.get_by_text("make the first one")).to_be_visible()
    await page.get_by_role("button", name="New proposal").click()
    await page.get_by_role("button", name="Keep").click()
    await expect(page.get_by_text("Expected letters, digits")).to_be_visible()
    await page.get_by_label("Id", exact=True).fill("STARS-1")
    await page.get_by_label("Title", exact=True).fill("Stars")
    await page.get_by_label("Share of the time (%)").fill("40")
    await page.get_by_label("Hours in all").fill("20")
    await page.get_by_role("button", name="Keep").click()
    await expect(page.get_by_role("link", name="STARS-1: Stars")).to_be_visible()
    await page.locator("t-proposal-members [name=name]").fill("admin")
    await page.get_by_role("button", name="Add", exact=True).click()
    await expect(page.get_by_text("1 member")).to_be_visible()
    await keep(page, "proposals")


async def ask_for_orion(page, origin: str) -> None:
    """Ask for something by the form: kept as a draft, then submitted."""
    await page.goto(f"{origin}/sites/{SITE}/requests")
    await page.get_by_role("button", name="New request").click()
    form = page.locator("t-request-form")
    await form.get_by_label("Exposure (s)").fill("minute")
    await expect(form.get_by_text("Exposure in s: expected 0.04 to 3600")).to_be_visible()
    await form.get_by_label("Exposure (s)").fill("60")
    await form.locator("[name=target]").fill("M 42")
    await form.locator("[name=ra]").fill("05:35:17")
    await form.locator("[name=dec]").fill("-05:23:28")
    await expect(
        form.get_by_text(re.compile("It may be observed|Best on|Never above"))
    ).to_be_visible()
    # Nothing is kept yet, and the charge is that of 10 frames with their readout, slew and filter.
    outlook = form.locator("t-request-outlook")
    await expect(outlook).to_contain_text("Charged about 11 min 22 s")
    await expect(outlook).to_contain_text("the proposal has 20 h")
    await expect(outlook).to_contain_text("With a clear sky:")
    await form.get_by_label("Priority").fill("30")
    await expect(outlook).to_contain_text("priority 30 is more")
    await form.get_by_label("Priority").fill("10")
    await expect(outlook).not_to_contain_text("priority 30")
    await form.locator("[name=way]").select_option("body")
    await form.locator("[name=body]").select_option("jupiter")
    await expect(outlook.locator("t-night-curve svg").first).to_be_visible()
    await keep(page, "request-planet")
    await form.locator("[name=way]").select_option("stars")
    await expect(outlook.locator("t-night-curve")).to_have_count(0)
    await keep(page, "request-form")
    await form.get_by_role("button", name="Keep as a draft").click()
    detail = page.locator("t-request-detail")
    await expect(detail.get_by_role("heading", name="M 42")).to_be_visible()
    await expect(detail.get_by_text("of its proposal's time")).to_be_visible()
    await detail.get_by_role("button", name="Submit…").click()
    await detail.get_by_role("button", name="Submit", exact=True).click()
    await expect(detail.locator("t-status").first).to_contain_text("pending")
    await keep(page, "requests")


async def import_table(page, origin: str) -> None:
    """Import a table of which a line is wrong: said where, and the rest kept as one draft."""
    await page.goto(f"{origin}/sites/{SITE}/requests")
    await page.get_by_role("button", name="Import…").click()
    form = page.locator("t-request-import")
    await expect(form.get_by_role("button", name="Keep as drafts")).to_be_disabled()
    table = b"name,ra,dec,exposure\nM 35,06:08:54,24:20,30\nM 1,x,22,30\nM 37,05:52:19,32:33,30\n"
    target = {"name": "clusters.csv", "mimeType": "text/csv", "buffer": table}
    await form.locator("[name=file]").set_input_files(target)
    await expect(form.get_by_text("2 requests in 1 group; 1 part could not")).to_be_visible()
    await expect(form.locator(".problems")).to_contain_text("line 3, ra: expected a number")
    await expect(form.get_by_text("M 35, M 37")).to_be_visible()
    # As another program's file it is none, and nothing can be kept.
    await form.locator("[name=kind]").select_option("ekos")
    await expect(form.get_by_text("No request could be read")).to_be_visible()
    await expect(form.get_by_role("button", name="Keep as drafts")).to_be_disabled()
    await form.locator("[name=kind]").select_option("csv")
    await expect(form.get_by_role("button", name="Keep as 1 draft")).to_be_enabled()
    await keep(page, "request-import")
    await form.get_by_role("button", name="Keep as 1 draft").click()
    await expect(page.get_by_role("link", name="M 37")).to_be_visible()
    await expect(page.get_by_role("link", name="M 35")).to_be_visible()


async def test_a_night_is_asked_for_armed_and_watched_by_its_pages(observatory, chromium):
    hub, dome = observatory, observatory.dome
    page = await sign_in(chromium, hub, "admin")
    await make_proposal(page, hub.origin)
    await ask_for_orion(page, hub.origin)
    await import_table(page, hub.origin)
    await dome.say(RequestRevision(revision=0))
    sync = await dome.hear(RequestSync, lambda told: told.groups)
    request = sync.groups[0].requests[0].id

    now = time.time()
    await dome.say(NightState(phase=NightPhase.DISARMED, since=now))
    pauses = (
        PlannedPause(
            kind=PauseKind.FOCUS, start=now + HOUR - 120, end=now + HOUR, reason="another filter: R"
        ),
        PlannedPause(
            kind=PauseKind.FLIP, start=now + 1.5 * HOUR, end=now + 1.5 * HOUR + 98,
            reason="its target passes the meridian",
        ),
    )  # fmt: skip
    block = PlannedBlock(
        request=request, start=now + HOUR, end=now + 2 * HOUR, reason="highest", pauses=pauses
    )
    plan = Plan(
        made_at=now, night_start=now - HOUR, night_end=now + 9 * HOUR, blocks=(block,), value=9.0,
        bound=10.0,
    )  # fmt: skip
    why = WhyNot(
        request=request, cause=VetoCause.ALTITUDE, sentence="it stands too low until 02:40",
        planned_at=now + HOUR,
    )  # fmt: skip
    await dome.say(NightPlan(plan=plan, why_not=[why]))

    await page.goto(f"{hub.origin}/sites/{SITE}/night")
    await expect(
        page.get_by_role("button", name=re.compile("M 42, proposal A STARS-1"))
    ).to_be_visible()
    await expect(page.get_by_text("it stands too low until 02:40")).to_be_visible()
    await expect(page.get_by_text("90 % of what is possible")).to_be_visible()
    await page.get_by_role("button", name="Arm…").click()
    await page.get_by_role("button", name="Arm", exact=True).click()
    asked = await dome.hear(NightArmRequest)
    # For this night: to the end of the plan.
    assert (asked.who, asked.until) == ("admin", pytest.approx(now + 9 * HOUR, abs=1))
    armed = NightState(
        phase=NightPhase.OBSERVING, armed_by="admin", armed_until=asked.until, since=now,
        request=request, step="exposing", frames_done=3, frames=10, answer_to=asked.id,
    )  # fmt: skip
    await dome.say(armed)
    state = page.locator("t-night-state")
    await expect(state).to_contain_text("Observing")
    await expect(state).to_contain_text("Armed by admin")
    await expect(state).to_contain_text("3 of 10 frames")
    await expect(state.get_by_role("button", name="Disarm…")).to_be_visible()
    # By keyboard to the block, whose reason then stands in words.
    await page.get_by_role("button", name=re.compile("M 42, proposal A")).focus()
    await page.keyboard.press("End")
    chosen = page.locator("t-plan-timeline .chosen")
    await expect(chosen).to_contain_text("highest")
    # What comes between its frames stands on the line, in those words, and in the table.
    await expect(chosen).to_contain_text(re.compile("focus run .* another filter: R"))
    await expect(page.locator("t-plan-timeline .pause")).to_have_count(2)
    await page.get_by_text("As a table").click()
    table = page.get_by_role("table", name="Blocks of the night")
    await expect(table).to_contain_text("its target passes the meridian")
    await keep(page, "night")
    await dome.close()
    await expect(page.get_by_text("what is shown is old")).to_be_visible()
    assert page.errors == []


async def test_who_may_not_see_the_site_is_told_so_and_sees_no_plan(observatory, chromium):
    page = await sign_in(chromium, observatory, "guest")
    await page.goto(f"{observatory.origin}/sites/{SITE}/night")
    await expect(page.get_by_text("You may not see the night.")).to_be_visible()
    await expect(page.locator("t-plan-timeline")).to_have_count(0)
