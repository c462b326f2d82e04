"""A night in minutes: asked for and armed by one button, and only where the site is simulated."""

from __future__ import annotations

import asyncio
import time
from dataclasses import replace
from pathlib import Path

import pytest

from talaia.hub.observing.short_night import high_targets
from talaia.wire.frames import NightArmRequest, NightState, RequestRevision, RequestSync
from talaia.wire.gateway_messages.relayed_fields import NightPhase

from ..conftest import settings_in

SITE = "observatory"
DESCRIPTION = (Path(__file__).parents[3] / "examples" / "observatory" / "site.yaml").read_text()
BUTTON = f"/api/sites/{SITE}/night/short"


@pytest.fixture
def settings(tmp_path):
    return replace(settings_in(tmp_path), simulated_sites=(SITE,))


@pytest.mark.parametrize("latitude", [-35.0, 0.0, 42.05, 55.0])
def test_three_targets_stand_high_at_every_hour_of_every_season(latitude: float) -> None:
    for quarter in range(96 * 2):
        # Each quarter of an hour of two nights, three months apart.
        moment = 1.8e9 + quarter % 96 * 900.0 + quarter // 96 * 91 * 86_400.0
        targets = high_targets(latitude, 0.76, moment)
        assert len({target.name for target in targets}) == 3, quarter


async def test_the_button_asks_for_what_is_high_and_arms_for_half_an_hour(hub) -> None:
    key = await hub.hub.gateways.registry.new_key(SITE)
    dome = await hub.gateway(key=key)
    await dome.hello(DESCRIPTION, site=SITE)
    operator = await hub.client("operator")
    # Who may not arm may not do it this way either.
    assert (await (await hub.client("guest")).post(BUTTON)).status_code == 403
    assert (await operator.get(f"/api/sites/{SITE}/night")).json()["simulated"] is True

    async def answer() -> NightArmRequest:
        asked = await dome.hear(NightArmRequest)
        await dome.say(
            NightState(answer_to=asked.id, phase=NightPhase.WAITING, armed_by=asked.who, since=7.0)
        )
        return asked

    answering = asyncio.create_task(answer())
    began = await operator.post(BUTTON)
    assert (began.status_code, began.json()["refused"]) == (200, "")
    assert (await answering).until == pytest.approx(time.time() + 1800, abs=60)
    await dome.say(RequestRevision(revision=0))
    sync = await dome.hear(RequestSync, lambda told: told.groups)
    (group,) = sync.groups
    assert (group.requester, len(group.requests)) == ("operator", 3)
    # Once more: the proposal is there already.
    answering = asyncio.create_task(answer())
    assert (await operator.post(BUTTON)).status_code == 200
    await answering


async def test_a_site_that_nobody_called_simulated_has_no_such_night(hub) -> None:
    gateway = await hub.gateway()
    await gateway.hello()
    admin = await hub.client("admin")
    answer = await admin.post("/api/sites/agv/night/short")
    assert (answer.status_code, answer.json()["code"]) == (409, "not_simulated")
    assert (await admin.get("/api/sites/agv/night")).json()["simulated"] is False
