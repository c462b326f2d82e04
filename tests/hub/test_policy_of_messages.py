"""Every message of a page × every kind of person × own and foreign objects.

By turns they come to the hub that leads, and to another one before it.
"""

from __future__ import annotations

import itertools
from typing import get_args

import pytest
import websockets

from talaia.hub.policy import FROM_BROWSER, SOCKETS, AccessNeed
from talaia.wire import browser, frames

from .everyone.messages import ASKS, TRIALS
from .everyone.routes import meets
from .everyone.world import SESSIONLESS, SIGNED_IN, holds

_NUMBERS = itertools.count(1000)


async def problem_of(page, message) -> str:
    """Say a message; give the code it is refused with, or nothing."""
    await page.say(message)
    # Everyone sees this site: the answer says that what came before was looked at.
    number = next(_NUMBERS)
    await page.say(browser.Subscribe(sub=number, site="agv", channels=[]))
    await page.hear(browser.Subscribed, lambda answer: answer.sub == number)
    about = type(message).__struct_config__.tag
    codes = [
        each.code
        for each in page.heard
        if isinstance(each, browser.RequestError) and each.about == about
    ]
    page.heard.clear()
    return codes[0] if codes else ""


async def reached(gateway) -> set[type]:
    """Tell what people's asking has brought to a gateway since the last time."""
    number = next(_NUMBERS)
    await gateway.say(frames.Beat(n=number, mono_us=1))
    # Goes down behind everything else.
    await gateway.hear(frames.BeatReply, lambda reply: reply.n == number)
    asked = {type(each) for each in gateway.heard if isinstance(each, ASKS)}
    gateway.heard.clear()
    return asked


async def differences(world, kind: type) -> list[str]:
    """Let everyone say a message about everything; list what is not as its line says."""
    trial, need, found = TRIALS[kind], FROM_BROWSER[kind], []
    for actor in SIGNED_IN:
        page = await world.page(actor, at=next(world.doors))
        for about in trial.objects:
            site, _, device = about.partition("/")
            mark = f"{actor} {about}"
            code = await problem_of(page, trial.make(site, device, mark))
            arrived = {name: await reached(each) for name, each in world.gateways.items()}
            came = set().union(*arrived.values())
            if meets(need, actor, about):
                wanted, brings = "", {trial.reaches} if trial.reaches else set()
                if brings and arrived[site] != brings:
                    found.append(f"{mark}: its own gateway got {arrived[site]}")
            else:
                wanted = "forbidden" if holds(actor, "see", about) else "unknown"
                brings = set()
            if code != wanted:
                found.append(f"{mark}: {code or 'done'} instead of {wanted or 'done'}")
            if came != brings:
                found.append(f"{mark}: {came} reached a gateway instead of {brings}")
        await page.close()
        for gateway in world.gateways.values():
            # What a page held is given back when it goes; that is no answer to a message.
            await reached(gateway)
    return found


def test_every_message_is_tried_and_no_trial_is_left_over() -> None:
    assert set(TRIALS) == set(get_args(browser.FromBrowser))
    # A picture's or a topic's socket is looked at when it opens, below.
    others = {*get_args(browser.MediaFromBrowser), browser.TopicFromBrowser}
    assert set(TRIALS) | others == set(FROM_BROWSER)


@pytest.mark.asyncio(loop_scope="module")
@pytest.mark.parametrize("kind", TRIALS, ids=lambda kind: kind.__name__)
async def test_message_does_for_everyone_what_its_line_says(shared_world, kind) -> None:
    assert await differences(shared_world, kind) == []


async def test_gate_that_stands_open_is_found(world, monkeypatch) -> None:
    monkeypatch.setattr("talaia.hub.live.pages.message_authorizer.allows", lambda *_about: True)
    found = await differences(world, browser.PageDrive)
    assert any(each.startswith("guest agv/base: done instead of forbidden") for each in found)
    assert any(each.startswith("neighbour agv/base: ") for each in found)


async def test_line_that_is_too_weak_is_found(world, monkeypatch) -> None:
    # The hub reads one table, the trial another: as if the line were changed by mistake.
    weak = {**FROM_BROWSER, browser.PageCommand: AccessNeed.SEE}
    monkeypatch.setattr("talaia.hub.live.pages.message_authorizer.FROM_BROWSER", weak)
    found = await differences(world, browser.PageCommand)
    assert {each.partition(":")[0] for each in found} == {
        "guest agv/base",
        "neighbour agv/base",
        "token agv/base",
    }


@pytest.mark.asyncio(loop_scope="module")
@pytest.mark.parametrize("path", SOCKETS, ids=lambda path: path)
@pytest.mark.parametrize("actor", SESSIONLESS, ids=lambda actor: actor)
async def test_no_socket_opens_without_a_living_session(shared_world, path, actor) -> None:
    client = await shared_world.client(actor)
    headers = {"Origin": shared_world.hub.origin} if path.startswith("/ws") else {}
    if client.cookies:
        headers["Cookie"] = f"talaia={client.cookies['talaia']}"
    with pytest.raises(websockets.InvalidStatus) as refused:
        await shared_world.hub.dial(f"{path}?site=agv&stream=base/eye", headers)
    assert refused.value.response.status_code == 401


@pytest.mark.asyncio(loop_scope="module")
@pytest.mark.parametrize("actor", SIGNED_IN, ids=lambda actor: actor)
async def test_pictures_open_to_those_who_may_view_and_to_nobody_else(shared_world, actor) -> None:
    for about in ("agv/base", "agv/power", "agv/camera", "moon/rover"):
        site, device = about.split("/")
        headers = await shared_world.headers(actor)
        path = f"/ws/media?site={site}&stream={device}/eye"
        if holds(actor, "view", about):
            await (await shared_world.hub.dial(path, headers)).close()
        else:
            with pytest.raises(websockets.InvalidStatus) as refused:
                await shared_world.hub.dial(path, headers)
            assert refused.value.response.status_code == 404


@pytest.mark.asyncio(loop_scope="module")
@pytest.mark.parametrize("actor", SIGNED_IN, ids=lambda actor: actor)
async def test_pictures_as_they_are_open_to_those_with_the_right_and_to_nobody_else(
    shared_world, actor
) -> None:
    headers = await shared_world.headers(actor)
    for about in ("agv/base", "agv/power", "agv/camera", "moon/rover"):
        site, device = about.split("/")
        gateway = shared_world.gateways[site]
        path = f"/ws/media/unblurred?site={site}&stream={device}/eye"
        if holds(actor, "admin", about):
            socket = await shared_world.hub.dial(path, headers)
            wanted = f"{device}/eye!unblurred"
            await gateway.hear(
                frames.StreamSubscription, lambda said, wanted=wanted: wanted in said.streams
            )
            await socket.close()
            continue
        seen = holds(actor, "view", about)
        for address, status in ((path, 403 if seen else 404), (path + "!unblurred", 404)):
            with pytest.raises(websockets.InvalidStatus) as refused:
                await shared_world.hub.dial(address, headers)
            assert refused.value.response.status_code == status
        # What others get leaves the gateway blurred, by whatever name it is asked for.
        other = path.replace("/unblurred", "", 1) + "!unblurred"
        with pytest.raises(websockets.InvalidStatus) as refused:
            await shared_world.hub.dial(other, headers)
        assert refused.value.response.status_code == 404


@pytest.mark.asyncio(loop_scope="module")
async def test_who_looked_at_pictures_as_they_are_is_in_the_audit_log(shared_world) -> None:
    headers = await shared_world.headers("keeper")
    path = "/ws/media/unblurred?site=agv&stream=camera/eye"
    await (await shared_world.hub.dial(path, headers)).close()
    # A picture that was asked for blurred is nobody's secret.
    await (await shared_world.hub.dial(path.replace("/unblurred", ""), headers)).close()
    await shared_world.hub.hub.audit.log.wait_written()
    admin = await shared_world.client("admin")
    found = (await admin.get("/api/audit", params={"kind": "unblurred"})).json()["rows"]
    opened = [row for row in found if row["kind"] == "unblurred opened" and row["who"] == "keeper"]
    assert {(row["site"], row["message"]) for row in opened} >= {("agv", "camera/eye")}
    others = {
        (row["who"], row["message"]) for row in found if row["who"] not in {"keeper", "admin"}
    }
    # The admin of one device saw that device's pictures.
    assert others <= {("neighbour", "power/eye")}


@pytest.mark.asyncio(loop_scope="module")
@pytest.mark.parametrize("actor", SIGNED_IN, ids=lambda actor: actor)
async def test_topics_without_a_rule_open_to_admins_of_their_site_and_to_nobody_else(
    shared_world, actor
) -> None:
    for site in ("agv", "moon", "nowhere"):
        headers = await shared_world.headers(actor)
        path = f"/ws/topic?site={site}&topic=/scan"
        if site != "nowhere" and holds(actor, "admin", site):
            await (await shared_world.hub.dial(path, headers)).close()
        else:
            with pytest.raises(websockets.InvalidStatus) as refused:
                await shared_world.hub.dial(path, headers)
            assert refused.value.response.status_code == 404


@pytest.mark.asyncio(loop_scope="module")
async def test_no_person_opens_a_gateways_door(shared_world) -> None:
    for path in ("/gateway/link", "/gateway/media", "/gateway/files"):
        with pytest.raises(websockets.InvalidStatus) as refused:
            await shared_world.hub.dial(path, {"Cookie": await shared_world.hub.cookie("admin")})
        assert refused.value.response.status_code == 401
