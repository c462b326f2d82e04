"""Rules of alerts in a real Chromium: tried on the last notices, kept, changed and removed."""

from __future__ import annotations

import pytest
from playwright.async_api import expect

from talaia.hub.live.observing.alert_folder import AlertFolder

from ..chromium import sign_in
from .test_alert_notices import AT, SITE, notice, observatory  # noqa: F401 - a fixture
from .test_night_in_browser import keep

pytestmark = [pytest.mark.browser, pytest.mark.timeout(240)]


async def test_a_rule_is_tried_kept_changed_and_removed(observatory, chromium, tmp_path):  # noqa: F811
    hub = observatory
    folder = AlertFolder(tmp_path, hub.hub.core.sites, hub.hub.alert_notices.intake)
    (tmp_path / "1.xml").write_bytes(notice("bright", 1))
    (tmp_path / "2.xml").write_bytes(notice("faint", 2, signif=3.0))
    await folder.read_files()
    page = await sign_in(chromium, hub, "operator", to=f"/sites/{SITE}/proposals")
    await page.get_by_role("link", name="Alert rules").click()
    rules = page.locator("t-page-alert-rules")
    await rules.get_by_role("button", name="New rule").click()
    form = page.locator("t-alert-rule-form")
    await expect(form.get_by_text("It is tried once everything")).to_be_visible()
    await form.get_by_label("Called").fill("Bursts")
    preview = form.locator("t-alert-rule-preview")
    await expect(preview).to_contain_text("Of the last 2 notices 2 would have become requests")
    await form.get_by_label("Its parameters say").fill("Rate_Signif is 7")
    await expect(form.get_by_text("is no condition")).to_be_visible()
    await form.get_by_label("Its parameters say").fill("Rate_Signif >= 7")
    await expect(preview).to_contain_text("Of the last 2 notices 1 would have become requests")
    await expect(preview).to_contain_text("Rate_Signif is 3, not at least 7")
    await form.locator("[name=filter-0]").select_option("R")
    await keep(page, "alert-rules")
    await form.get_by_role("button", name="Keep", exact=True).click()
    await expect(rules).to_contain_text("Rate_Signif at least 7")
    await expect(rules).to_contain_text("asks in the name of operator")
    await rules.get_by_role("button", name="Change Bursts").click()
    await expect(form.get_by_label("Its parameters say")).to_have_value("Rate_Signif >= 7")
    await expect(form.locator("[name=filter-0]")).to_have_value("R")
    await form.get_by_label("The rule is active").uncheck()
    await form.get_by_role("button", name="Keep", exact=True).click()
    await expect(rules.locator("t-status").first).to_contain_text("off")
    await rules.get_by_role("button", name="Remove Bursts").click()
    await rules.get_by_role("button", name="Remove", exact=True).click()
    await expect(rules).to_contain_text("No notice becomes a request of this proposal yet")
    client = await hub.client("operator")
    kept = await client.get(f"{AT}/proposals/BURSTS/alert-rules")
    assert kept.json()["rules"] == []
    assert page.errors == []


async def test_who_leads_no_proposal_changes_no_rule(observatory, chromium):  # noqa: F811
    page = await sign_in(chromium, observatory, "admin")
    await page.goto(f"{observatory.origin}/sites/{SITE}/alertrules")
    rules = page.locator("t-page-alert-rules")
    await expect(rules.get_by_text("No rules")).to_be_visible()
    await expect(rules.get_by_role("button", name="New rule")).to_have_count(0)
