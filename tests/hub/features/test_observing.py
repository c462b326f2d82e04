"""Requests from asking to their end: by people of each kind, over REST, the link and the socket."""

from __future__ import annotations

import asyncio
import time
from pathlib import Path

import pytest
from patience import until_answered

from talaia.model.observing.plan import Plan, PlannedBlock, VetoCause, WhyNot
from talaia.model.observing.states import ObservationState
from talaia.wire import browser as page_wire
from talaia.wire.frames import (
    NightArmRequest,
    NightDisarmRequest,
    NightPlan,
    NightState,
    ObservationAck,
    ObservationUpdate,
    RequestRevision,
    RequestSync,
)
from talaia.wire.gateway_messages.relayed_fields import NightPhase

SITE = "observatory"
DESCRIPTION = (Path(__file__).parents[3] / "examples" / "observatory" / "site.yaml").read_text()
AT = f"/api/sites/{SITE}"
PROPOSAL = {"id": "STARS-1", "title": "Stars", "hours_allocated": 2.0, "share": 0.5}


def asked(**changed) -> dict[str, object]:
    now_us = time.time_ns() // 1000
    one = {
        "target": {"type": "ICRS", "name": "M 42", "ra": 83.82, "dec": -5.39},
        "configurations": [{"exposure": 60.0, "count": 10}],
        "windows": [{"start_us": now_us, "end_us": now_us + 86_400_000_000}],
    }
    return {"proposal": "STARS-1", "name": "Orion", "requests": [one], **changed}


@pytest.fixture
async def observatory(hub):
    """A hub with an observatory, and a proposal of which the operator is a member."""
    hub.keys[SITE] = await hub.hub.gateways.registry.new_key(SITE)
    hub.dome = await hub.gateway(key=hub.keys[SITE])
    await hub.dome.hello(DESCRIPTION, site=SITE)
    admin = await hub.client("admin")
    assert (await admin.post(f"{AT}/proposals", json=PROPOSAL)).status_code == 201
    member = {"name": "operator", "role": "member"}
    answer = await admin.put(f"{AT}/proposals/STARS-1/members", json=member)
    assert answer.status_code == 204
    return hub


async def test_a_request_is_asked_for_sent_observed_and_told_of(observatory) -> None:
    hub, dome = observatory, observatory.dome
    operator, page = await hub.client("operator"), await hub.page("operator")
    await dome.say(RequestRevision(revision=0))
    answer = await operator.post(f"{AT}/request-groups", json=asked())
    assert answer.status_code == 201, answer.text
    group = answer.json()
    (request,) = group["requests"]
    assert (request["state"], group["may"]) == ("PENDING", ["withdraw", "cancel"])
    # 10 · (60 + 5) s, and what leads to the first.
    assert request["charge_s"] == 650 + 9 + 3 + 20
    sync = await dome.hear(RequestSync, lambda one: one.groups)
    assert (sync.groups[0].requests[0].id, sync.proposals[0].id) == (request["id"], "STARS-1")
    assert (sync.piece, sync.pieces) == (0, 1)
    await dome.say(RequestRevision(revision=sync.revision))
    for number, state in ((1, ObservationState.IN_PROGRESS), (2, ObservationState.COMPLETED)):
        report = ObservationUpdate(
            number=number, id="obs-1", request=request["id"], state=state, time=time.time(),
            frames_done=[5 * number], block_s=350.0 * number, files=[f"{number}.fits"],
        )  # fmt: skip
        # Its acknowledgement was lost: it comes once more.
        for _ in range(2):
            await dome.say(report)
            assert (await dome.hear(ObservationAck)).number == number
    told = await page.hear(page_wire.ObservingRequestUpdate)
    assert (told.site, told.request) == (SITE, request["id"])
    found = (await operator.get(f"{AT}/requests/{request['id']}")).json()
    assert [line["after"] for line in found["log"]] == ["PENDING", "COMPLETED"]
    (observed,) = found["observations"]
    assert (observed["files"], observed["charge_s"]) == (["1.fits", "2.fits"], 700.0)
    (proposal,) = (await operator.get(f"{AT}/proposals")).json()["proposals"]
    assert (proposal["used_s"], proposal["promised_s"]) == (700.0, 0.0)
    # It is no news to the gateway that it did so itself.
    newer = [one for one in dome.heard if isinstance(one, RequestSync)]
    assert [one for one in newer if one.revision > sync.revision] == []
    kinds = {
        row["kind"] for row in (await (await hub.client("admin")).get("/api/audit")).json()["rows"]
    }
    assert {"proposal added", "proposal member", "request submitted", "request completed"} <= kinds


async def test_what_is_not_one_s_own_is_as_if_it_were_not_there(observatory) -> None:
    hub = observatory
    operator, guest = await hub.client("operator"), await hub.client("guest")
    admin = await hub.client("admin")
    # Operators see the site; of this proposal the admin alone is told.
    closed = {**PROPOSAL, "id": "SECRET", "needs_approval": True}
    await admin.post(f"{AT}/proposals", json=closed)
    await admin.put(f"{AT}/proposals/SECRET/members", json={"name": "admin", "role": "member"})
    made = await admin.post(f"{AT}/request-groups", json=asked(proposal="SECRET"))
    group = made.json()
    for client in (operator, guest):
        assert (await client.get(f"{AT}/request-groups/{group['id']}")).status_code == 404
        number = group["requests"][0]["id"]
        assert (await client.get(f"{AT}/requests/{number}")).status_code == 404
        assert (await client.get(f"{AT}/requests")).json()["requests"] == []
    answer = await operator.post(f"{AT}/request-groups", json=asked(proposal="SECRET"))
    unknown = await operator.post(f"{AT}/request-groups", json=asked(proposal="NONE"))
    assert (answer.status_code, unknown.status_code) == (422, 422)
    assert answer.text == unknown.text.replace("NONE", "SECRET")
    # An open one is seen by whoever may view the site, and asked for by its members alone.
    await admin.put(f"{AT}/proposals/SECRET", json={"hours_allocated": 1.0, "is_open": True})
    assert (await operator.get(f"{AT}/request-groups/{group['id']}")).json()["may"] == []
    assert (await guest.get(f"{AT}/request-groups/{group['id']}")).status_code == 404
    answer = await operator.post(f"{AT}/request-groups", json=asked(proposal="SECRET"))
    assert answer.status_code == 403
    answer = await operator.post(f"{AT}/request-groups/{group['id']}/cancel", json={})
    assert answer.status_code == 403
    # Of its plan everyone who may view the site sees when, and members what.
    number = group["requests"][0]["id"]
    plan = Plan(
        made_at=1.0, night_start=2.0, night_end=9.0,
        blocks=(PlannedBlock(request=number, start=3.0, end=4.0, reason="high"),),
    )  # fmt: skip
    await admin.put(f"{AT}/proposals/SECRET", json={"hours_allocated": 1.0})
    reason = WhyNot(request=number, cause=VetoCause.SUN, until=5.0, sentence="the Sun is up")
    page = await hub.page("operator")
    await hub.dome.say(NightPlan(plan=plan, why_not=[reason]))
    assert (await page.hear(page_wire.NightPlanUpdate)).blocks == 1
    (block,) = (await operator.get(f"{AT}/night")).json()["plan"]["blocks"]
    assert (block["start_us"], block["request"], block["target"], block["reason"]) == (
        3_000_000, "", "", "",
    )  # fmt: skip
    (block,) = (await admin.get(f"{AT}/night")).json()["plan"]["blocks"]
    assert (block["request"], block["target"]) == (number, "M 42")
    (row,) = (await admin.get(f"{AT}/requests", params={"text": "m 42"})).json()["requests"]
    assert row["why_not"]["message"] == "the Sun is up"
    assert (await guest.get(f"{AT}/night")).status_code == 403


async def test_what_needs_approval_waits_for_it_and_goes_back_with_a_reason(observatory) -> None:
    hub = observatory
    operator, admin = await hub.client("operator"), await hub.client("admin")
    await admin.put(
        f"{AT}/proposals/STARS-1", json={"hours_allocated": 2.0, "needs_approval": True}
    )
    made = (await operator.post(f"{AT}/request-groups", json=asked(draft=True))).json()
    at = f"{AT}/request-groups/{made['id']}"
    assert (made["waits"], made["may"]) == (False, ["edit", "submit", "cancel"])
    changed = (await operator.put(at, json=asked(draft=True, name="Orion again"))).json()
    assert changed["name"] == "Orion again"
    waits = (await operator.post(f"{at}/submit", json={})).json()
    assert (waits["waits"], waits["requests"][0]["state"]) == (True, "DRAFT")
    assert (await operator.put(at, json=asked(draft=True))).status_code == 409
    assert (await operator.post(f"{at}/approve", json={})).status_code == 403
    listed = await admin.get(f"{AT}/requests", params={"waiting": True})
    assert [row["group"] for row in listed.json()["requests"]] == [made["id"]]
    back = (await admin.post(f"{at}/withdraw", json={"why": "too long"})).json()
    assert (back["waits"], back["submitted_us"]) == (False, 0)
    assert (await admin.post(f"{at}/approve", json={})).status_code == 409
    await operator.post(f"{at}/submit", json={})
    approved = (await admin.post(f"{at}/approve", json={"why": "good"})).json()
    assert (approved["requests"][0]["state"], approved["approved_by"]) == ("PENDING", "admin")
    again = (await operator.post(f"{at}/clone")).json()
    assert (again["requests"][0]["state"], again["mine"]) == ("DRAFT", True)
    ended = (await operator.post(f"{at}/cancel", json={"why": "clouds"})).json()
    assert (ended["requests"][0]["state"], ended["may"]) == ("CANCELED", [])
    assert (await operator.post(f"{at}/cancel", json={})).status_code == 409


@pytest.mark.parametrize(
    ("changed", "why"),
    [
        ({"priority": 21.0}, "priority 21 is more than this proposal may ask"),
        ({"urgency": "RAPID_RESPONSE"}, "this proposal may not ask for RAPID_RESPONSE"),
        ({"requests": 2}, "a SINGLE group has one request, not 2"),
        ({"exposure": 3000.0}, "the proposal has 2.00 h left"),
        ({"window": (2, 1)}, "a window ends before it begins"),
        ({"window": (1, 2)}, "its last window is over"),
    ],
    ids=str,
)
async def test_what_does_not_fit_is_refused_in_words(observatory, changed, why) -> None:
    operator = await observatory.client("operator")
    body = asked()
    if "exposure" in changed:
        body["requests"][0]["configurations"][0]["exposure"] = changed.pop("exposure")
    if "window" in changed:
        start, end = changed.pop("window")
        body["requests"][0]["windows"] = [{"start_us": start, "end_us": end}]
    if "requests" in changed:
        changed = {"requests": body["requests"] * 2}
    answer = await operator.post(f"{AT}/request-groups", json={**body, **changed})
    assert (answer.status_code, answer.json()["code"]) == (422, "refused")
    assert why in answer.json()["message"]


async def test_the_night_is_armed_by_right_and_the_gateway_s_answer_is_shown(observatory) -> None:
    hub, dome = observatory, observatory.dome
    operator, page = await hub.client("operator"), await hub.page("operator")
    guest = await hub.client("guest")
    assert (await guest.post(f"{AT}/night/arm", json={})).status_code == 403
    assert (await operator.post(f"{AT}/night/arm", json={"until_us": 1})).status_code == 422

    async def answer(kind, **state):
        asked_for = await dome.hear(kind)
        assert asked_for.who == "operator"
        await dome.say(NightState(answer_to=asked_for.id, **state))

    answering = asyncio.create_task(
        answer(NightArmRequest, phase=NightPhase.WAITING, armed_by="operator", since=7.0)
    )
    armed = (await operator.post(f"{AT}/night/arm", json={})).json()
    await answering
    assert (armed["refused"], armed["state"]["phase"]) == ("", "waiting")
    told = await page.hear(page_wire.NightUpdate)
    assert (told.site, told.phase, told.armed_by) == (SITE, "waiting", "operator")
    assert not hasattr(told, "answer_to")
    # A page that comes later is told as it comes.
    assert (await (await hub.page("admin")).hear(page_wire.NightUpdate)).since == 7.0
    answering = asyncio.create_task(
        answer(NightDisarmRequest, phase=NightPhase.DISARMED, refused="parking already")
    )
    ended = (await operator.post(f"{AT}/night/disarm", json={"why": "fog"})).json()
    await answering
    assert ended["refused"] == "parking already"
    rows = (await (await hub.client("admin")).get("/api/audit", params={"kind": "night"})).json()
    assert [(row["kind"], row["good"], row["message"]) for row in rows["rows"]] == [
        ("night disarmed", False, "parking already"),
        ("night armed", True, ""),
    ]
    await dome.close()
    await page.hear(page_wire.SiteUpdate, lambda one: not one.online)
    assert (await operator.post(f"{AT}/night/arm", json={})).status_code == 409


async def test_a_site_without_a_night_takes_no_proposals(hub, gateway) -> None:
    admin = await hub.client("admin")
    answer = await admin.post("/api/sites/agv/proposals", json=PROPOSAL)
    assert (answer.status_code, answer.json()["code"]) == (409, "no_night")
    assert (await admin.get("/api/sites/agv/proposals")).json()["observes"] is False


async def test_before_it_is_handed_in_it_is_said_what_it_costs_and_when_it_can_be(
    observatory,
) -> None:
    operator = await observatory.client("operator")
    answer = await operator.post(f"{AT}/request-groups/validate", json=asked(priority=30.0))
    assert answer.status_code == 200, answer.text
    said = answer.json()
    assert (said["charge_s"], said["left_s"], said["person_left_s"]) == (682.0, 7200.0, None)
    (problem,) = said["problems"]
    assert problem.startswith("priority 30 is more")
    (outlook,) = said["requests"]
    assert "best on" in outlook["message"]
    assert len(outlook["curve"]["times_us"]) == len(outlook["curve"]["altitude"]) > 10
    assert (await operator.get(f"{AT}/requests")).json()["requests"] == []


async def test_a_file_becomes_drafts_that_can_be_handed_in_as_they_come_back(observatory) -> None:
    operator = await observatory.client("operator")
    window = asked()["requests"][0]["windows"][0]
    body = {
        "kind": "csv", "proposal": "STARS-1", "window": window,
        "text": "name,ra,dec,exposure\nM 42,05:35:17,-05:23:28,30\nM 1,x,22,30\n",
    }  # fmt: skip
    read = (await operator.post(f"{AT}/request-groups/import", json=body)).json()
    assert read["problems"] == [{"where": "line 3, ra", "message": "expected a number, found 'x'"}]
    (group,) = read["groups"]
    answer = await operator.post(f"{AT}/request-groups", json={**group, "draft": False})
    assert answer.status_code == 201, answer.text
    assert answer.json()["requests"][0]["target"]["name"] == "M 42"
    # On a busy machine the first one takes longer than one question waits.

    async def is_planned() -> bool:
        nonlocal answer
        answer = await operator.get(f"{AT}/night/forecast")
        return answer.status_code != 429

    await until_answered(is_planned)
    forecast = answer.json()
    assert forecast["plan"]["night_start_us"] < forecast["plan"]["night_end_us"]
    named = [one["target"] for one in [*forecast["plan"]["blocks"], *forecast["reasons"]]]
    assert named == ["M 42"]
    known = (await operator.get(f"{AT}/night/week")).json()
    assert known["made_us"] == forecast["plan"]["made_us"]
    week = known["nights"]
    assert len(week) == 7
    # Whoever types a request is told its chance beside what waits.
    said = (await operator.post(f"{AT}/request-groups/validate", json=asked())).json()
    assert (said["forecast_us"], said["forecast_nights"]) == (known["made_us"], 7)
    assert 0.0 <= said["requests"][0]["tonight"] <= said["requests"][0]["week"] <= 1.0
    assert all(night["start_us"] < night["end_us"] for night in week)
    assert {one["target"] for night in week for one in night["chances"]} <= {"M 42"}
    assert sum(night["planned"] for night in week) == sum(len(one["chances"]) for one in week)
