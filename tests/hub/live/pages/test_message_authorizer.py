"""What goes out: everyone listens while everything happens, and gets what is theirs, no more."""

from __future__ import annotations

from typing import get_args

import pytest

from talaia.hub.policy import TO_BROWSER, AccessNeed
from talaia.wire import browser, frames
from talaia.wire.columns import unpack_columns

from ...everyone.messages import DEVICES
from ...everyone.routes import meets
from ...everyone.story import (
    LISTENERS,
    SIGNALS,
    STREAM,
    WATCHED,
    everything,
    hidden,
    listen,
    number,
    secrets_from,
    sees_channel,
    settle,
)
from ...everyone.world import ACTORS, DESCRIPTIONS, NOW, holds

# Told to everyone who may know; each of the others answers one page.
BROADCAST = {
    browser.SiteUpdate,
    browser.LeaseUpdate,
    browser.DriveUpdate,
    browser.TwinUpdate,
    browser.StopUpdate,
    browser.HeldStopUpdate,
    browser.CommandUpdate,
    browser.DeviceUpdate,
    browser.AlarmUpdate,
    browser.SightingUpdate,
    browser.EventUpdate,
    browser.InterlockUpdate,
}
# A sighting is for those who may see the camera's pictures, and no camera of this world is public.
NEEDS = {**TO_BROWSER, browser.SightingUpdate: AccessNeed.VIEW}
# About a site, not about a device.
OF_SITES = {browser.SiteUpdate, browser.InterlockUpdate}
# For the page alone that asked, or that holds the lease: here the operator's.
ACTING = {browser.TickUpdate, browser.ResetTokenUpdate}
# What a guest may hear of at all, written by hand.
FOR_GUESTS = {
    browser.Greeting,
    browser.SiteUpdate,
    # That something is locked, not why, nor who overrides it.
    browser.InterlockUpdate,
    # Of signals that are public.
    browser.AnomalyUpdate,
    browser.Subscribed,
    browser.Values,
    browser.PagePong,
    browser.RequestError,
    # Of their own session.
    browser.SessionUpdate,
    browser.SessionEnded,
}


def about_of(message) -> str:
    device = getattr(message, "device", "") or getattr(message, "camera", "").partition("/")[0]
    return f"{message.site}/{device}" if device else message.site


def signal_of(message: browser.AnomalyUpdate) -> str:
    return message.address.partition("/")[2]


def wrong_in(each) -> list[str]:
    """List what a listener heard and should not have."""
    found = []
    for message in each.messages:
        need = NEEDS.get(type(message), AccessNeed.NEVER)
        if isinstance(message, browser.Values):
            found += _wrong_values(each.actor, message)
        elif need is AccessNeed.SESSION:
            continue
        elif isinstance(message, browser.AnomalyUpdate):
            if not sees_channel(each.actor, about_of(message), signal_of(message)):
                found.append(f"{each.actor} heard {message}")
        elif not meets(need, each.actor, about_of(message)):
            found.append(f"{each.actor} heard {message}")
    secrets = secrets_from(each.actor)
    found += [
        f"{each.actor} was sent {secret!r}"
        for frame in each.frames
        for secret in secrets
        if secret in frame
    ]
    return found


def _wrong_values(actor: str, message: browser.Values) -> list[str]:
    columns = unpack_columns(message)
    seen = set(columns.value[columns.value == columns.value].tolist())
    open_to = {
        number(about, signal)
        for about in DEVICES
        for signal in SIGNALS
        if sees_channel(actor, about, signal)
    }
    words = {hidden(about) for about in DEVICES if sees_channel(actor, about, "words")}
    return [
        f"{actor} was sent {value!r}"
        for value in [*(seen - open_to), *(set(columns.texts.values()) - words)]
    ]


@pytest.fixture
async def heard(world):
    """Everyone, after everything has happened."""
    listeners = [await listen(world, actor) for actor in LISTENERS]
    await settle(listeners)
    await everything(world, listeners)
    return listeners


async def test_everyone_hears_what_is_theirs_and_nothing_else(world, heard) -> None:
    for each in heard:
        assert wrong_in(each) == []
    # Nothing is held back either: each piece of news came to everyone who may know.
    for kind in BROADCAST:
        for about in DESCRIPTIONS if kind in OF_SITES else DEVICES:
            got = {
                each.actor
                for each in heard
                if any(
                    isinstance(message, kind) and about_of(message) == about
                    for message in each.messages
                )
            }
            entitled = {actor for actor in LISTENERS if meets(NEEDS[kind], actor, about)}
            assert (kind, about, got) == (kind, about, entitled)
    for about in DEVICES:
        for signal in WATCHED:
            got = {
                each.actor
                for each in heard
                for message in each.messages
                if isinstance(message, browser.AnomalyUpdate)
                and (about_of(message), signal_of(message)) == (about, signal)
            }
            entitled = {actor for actor in LISTENERS if sees_channel(actor, about, signal)}
            assert (about, signal, got) == (about, signal, entitled)
    for kind in ACTING:
        got = {each.actor for each in heard if any(type(m) is kind for m in each.messages)}
        assert (kind, got) == (kind, {"operator"})
    guest = next(each for each in heard if each.actor == "guest")
    assert {type(message) for message in guest.messages} <= FOR_GUESTS
    neighbour = next(each for each in heard if each.actor == "neighbour")
    assert {
        about_of(message)
        for message in neighbour.messages
        if NEEDS[type(message)] in {AccessNeed.VIEW, AccessNeed.USE}
    } == {"agv/power"}
    values = [message for message in guest.messages if isinstance(message, browser.Values)]
    assert any(value.value for value in values)
    await _end(world, heard)
    produced = {type(message) for each in heard for message in each.messages}
    assert produced == set(get_args(browser.ToBrowser))


async def _end(world, heard) -> None:
    """End a session, the last thing there is to hear."""
    admin = next(each for each in heard if each.actor == "admin")
    cookie = {"Cookie": await world.hub.cookie("admin")}
    await (await world.client("nobody")).post("/api/logout", headers=cookie)
    await admin.page.closed()


async def test_nobody_reads_over_http_what_is_not_theirs(world, heard) -> None:
    await world.hub.hub.audit.log.wait_written()
    for actor in ACTORS:
        client = await world.client(actor)
        listed = await client.get("/api/devices")
        if listed.status_code == 200:
            seen = {f"{each['site']}/{each['device']}" for each in listed.json()["devices"]}
            assert seen == {about for about in DEVICES if holds(actor, "see", about)}
        bodies = [listed.content, (await client.get("/api/sites")).content]
        for site in DESCRIPTIONS:
            bodies.append((await client.get(f"/api/sites/{site}")).content)
            bodies.append((await client.get(f"/api/sites/{site}/events?limit=1000")).content)
        for secret in secrets_from(actor):
            assert not any(secret in body for body in bodies), (actor, secret)
        # And what is theirs is there.
        for about in DEVICES:
            if holds(actor, "view", about):
                assert any(hidden(about).encode() in body for body in bodies), (actor, about)


async def test_history_gives_each_channel_to_those_who_may_see_it(world, heard) -> None:
    for actor in ACTORS:
        client = await world.client(actor)
        for about in DEVICES:
            site, _, device = about.partition("/")
            for signal in SIGNALS:
                query = {"channel": f"{device}/{signal}", "from_us": NOW, "to_us": NOW + 1}
                answer = await client.get(f"/api/sites/{site}/history", params=query)
                may = sees_channel(actor, about, signal)
                expected = 200 if may else 401 if actor in {"nobody", "revoked"} else 404
                assert (actor, about, signal, answer.status_code) == (
                    actor,
                    about,
                    signal,
                    expected,
                )
                if may and signal != "words":
                    assert set(answer.json()["series"][0]["v"]) == {number(about, signal)}


async def test_picture_reaches_those_who_look_at_its_stream_only(world) -> None:
    looking = {
        about: await world.viewer("operator", about, STREAM) for about in ("agv/base", "agv/power")
    }
    # One wants to know what is seen, too, and what models tell.
    await looking["agv/base"].say(browser.BoxesRequest(on=True, overlays=True))
    await world.gateways["agv"].hear(
        frames.StreamSubscription, lambda watch: watch.boxes == ["base/eye"]
    )
    camera = await world.hub.camera()
    for about in looking:
        picture = frames.PictureFrame(
            stream=f"{about.partition('/')[2]}/{STREAM}",
            seq=1,
            time_us=1,
            mono_us=1,
            width=2,
            height=2,
            data=hidden(about).encode(),
        )
        thing = frames.DetectedObject(
            label=hidden(about), score=0.5, left=0.0, top=0.0, right=1.0, bottom=1.0
        )
        stream = picture.stream
        await camera.say(frames.DetectedBoxes(stream=stream, seq=1, time_us=1, things=[thing]))
        likely = frames.ClassLikelihood(label=hidden(about), share=0.5)
        layer = frames.OverlayLayer(
            rows=0, columns=0, runs=b"", near=None, far=None, poses=[], likely=[likely]
        )
        await camera.say(
            frames.ModelOverlay(stream=stream, seq=1, time_us=1, model="room", layer=layer)
        )
        await camera.say(picture)
    kinds = set()
    for about, viewer in looking.items():
        shot = await viewer.hear(browser.CameraPicture)
        assert shot.data == hidden(about).encode()
        kinds.add(type(shot))
        assert not any(isinstance(each, browser.CameraPicture) for each in viewer.heard)
    boxes = await looking["agv/base"].hear(browser.CameraPictureBoxes)
    assert [thing.label for thing in boxes.things] == [hidden("agv/base")]
    overlay = await looking["agv/base"].hear(browser.CameraPictureOverlay)
    assert [likely.label for likely in overlay.layer.likely] == [hidden("agv/base")]
    kinds |= {type(boxes), type(overlay)}
    assert not looking["agv/power"].heard
    # With those of the other sockets, every outbound type was produced by these tests or by those
    # of topics (`test_topic_sockets`).
    topics = set(get_args(browser.TopicToBrowser))
    assert kinds | topics | set(get_args(browser.ToBrowser)) == set(TO_BROWSER)


async def test_gate_that_stands_open_outbound_is_found(world, monkeypatch) -> None:
    monkeypatch.setattr(
        "talaia.hub.live.pages.message_authorizer.MessageAuthorizer.may_get", lambda *_about: True
    )
    listeners = [await listen(world, actor) for actor in LISTENERS]
    await settle(listeners)
    await everything(world, listeners)
    found = {each.actor: wrong_in(each) for each in listeners}
    assert {actor for actor, wrong in found.items() if wrong} == set(LISTENERS) - {
        "operator",
        "admin",
    }


async def test_subscription_that_is_not_cut_to_rights_is_found(world, monkeypatch) -> None:
    monkeypatch.setattr("talaia.hub.live.pages.subscriptions.sees_signal", lambda *_about: True)
    guest = await listen(world, "guest")
    await settle([guest])
    await world.gateways["agv"].samples(("power/shut", NOW, number("agv/power", "shut")))
    await guest.page.hear(browser.Values)
    assert len(wrong_in(guest)) == 2
