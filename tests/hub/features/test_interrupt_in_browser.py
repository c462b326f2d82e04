"""Who acts on a dome is told in a dialog, in a real Chromium, and may be interrupted."""

from __future__ import annotations

from pathlib import Path

import pytest
from msgspec.structs import replace
from playwright.async_api import expect

from talaia.model.yaml_text.load import dump_site, read_site
from talaia.wire import frames
from talaia.wire.frames import CommandPhase

from ..chromium import sign_in

pytestmark = [pytest.mark.browser, pytest.mark.timeout(120)]
EXAMPLE = read_site(Path(__file__).parents[3] / "examples" / "observatory" / "site.yaml")
WHY = "Ada is acting on Dome: Close (since 4 s)"


async def test_the_page_says_who_acts_and_asks_before_it_interrupts(
    chromium, hub, tmp_path
) -> None:
    site = replace(EXAMPLE, site="agv", interlocks={}, enclosures={}, alarms={}, night=None)
    gateway = await hub.gateway()
    await gateway.hello(description=dump_site(site))
    page = await sign_in(chromium, hub, "admin", to="/sites/agv/devices/dome")
    await expect(page.get_by_text("This does not close or park by itself")).to_be_visible()
    # Everybody who sees the dome sees who acts on it, in the words of the refusal.
    hers = frames.CommandState(
        id="hers", device="dome", command="close", phase=CommandPhase.RUNNING, who="Ada",
        acting="Ada is acting on Dome: Close", acting_s=4.0,
    )  # fmt: skip
    await gateway.say(hers)
    acts = page.locator("t-device-holder")
    await expect(acts).to_contain_text("Ada is acting on Dome: Close (since ")
    viewer = await sign_in(chromium, hub, "operator", to="/sites/agv/devices/dome")
    await expect(viewer.locator("t-device-holder")).to_contain_text("Ada is acting on Dome: Close")
    for name, width, height in (("desktop", 1440, 900), ("phone", 390, 844)):
        await viewer.set_viewport_size({"width": width, "height": height})
        await viewer.screenshot(path=tmp_path / f"acting-{name}.png")
    assert viewer.errors == []
    await page.get_by_role("button", name="Open…").click()
    await page.get_by_role("button", name="Open", exact=True).click()
    ask = await gateway.hear(frames.CommandRequest)
    refused = frames.CommandState(
        id=ask.id, device="dome", command="open", phase=CommandPhase.REFUSED, message=WHY,
        blocked_by="hers",
    )  # fmt: skip
    await gateway.say(refused)
    dialog = page.get_by_role("dialog")
    await expect(page.get_by_text(WHY).last).to_be_visible()
    await expect(dialog).to_be_visible()
    for name, size in (("desktop", (1440, 900)), ("phone", (390, 844))):
        await page.set_viewport_size({"width": size[0], "height": size[1]})
        await page.screenshot(path=tmp_path / f"interrupt-{name}.png")
    await page.get_by_role("button", name="Interrupt").click()
    again = await gateway.hear(frames.CommandRequest)
    assert (again.command, again.over) == ("open", "hers")
    await expect(dialog).to_have_count(0)
    await gateway.say(replace(hers, acting="", message="interrupted by admin (Dome: Open)"))
    await expect(acts).not_to_contain_text("is acting on")
    await gateway.say(replace(refused, id=again.id))
    await page.get_by_role("button", name="Leave it").click()
    await expect(dialog).to_have_count(0)
    await page.screenshot(path=tmp_path / "after.png")
    assert page.errors == []
