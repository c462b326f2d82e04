"""Leases, driving, STOP, commands and pictures, from page to gateway and back."""

import asyncio

import msgspec
import pytest
from msgspec.structs import replace

from talaia.clock import SystemClock
from talaia.hub.store.audit import Audit, AuditFilter
from talaia.wire import browser as page_wire, frames
from talaia.wire.frames import CommandPhase, LeaseOp

from ...conftest import DESCRIPTION

LEASE = page_wire.PageLease(site="agv", device="base", op=LeaseOp.TAKE)
DRIVE = page_wire.PageDrive(
    site="agv", device="base", epoch=7, seq=1, tick=3, held_ms=2.0, linear=0.1, angular=0.2
)
STOP = page_wire.PageStop(site="agv", device="base", id="stop-1")
WANDER = page_wire.PageCommand(
    site="agv", device="base", command="wander", id="c-1", args={"active": True}
)


async def take_lease(page, gateway, epoch: int = 7) -> frames.LeaseRequest:
    await page.say(LEASE)
    ask = await gateway.hear(frames.LeaseRequest, lambda ask: ask.op is LeaseOp.TAKE)
    await gateway.say(
        frames.LeaseState(
            device="base",
            session=ask.session,
            who=ask.who,
            epoch=epoch,
            remains_ms=3000,
            asked=ask.session,
        )
    )
    return ask


async def test_lease_is_shown_as_yours_to_the_holder_only(hub, gateway) -> None:
    holder, other = await hub.page("operator"), await hub.page("admin")
    ask = await take_lease(holder, gateway)
    assert ask.who == "operator"
    mine = await holder.hear(page_wire.LeaseUpdate)
    theirs = await other.hear(page_wire.LeaseUpdate)
    assert (mine.yours, mine.epoch, mine.holder) == (True, 7, "operator")
    assert (theirs.yours, theirs.epoch, theirs.holder) == (False, 0, "operator")


async def test_lease_is_told_to_a_page_that_comes_later(hub, gateway) -> None:
    holder = await hub.page("operator")
    await take_lease(holder, gateway)
    await holder.hear(page_wire.LeaseUpdate)
    news = await (await hub.page("admin")).hear(page_wire.LeaseUpdate)
    assert (news.holder, news.yours, news.epoch) == ("operator", False, 0)


async def test_page_hears_how_stop_stands_when_its_gateway_comes_back(hub, gateway) -> None:
    page = await hub.page("operator")
    await gateway.close()
    await page.hear(page_wire.SiteUpdate, lambda news: not news.online)
    again = await hub.gateway()
    await again.hello()
    await again.say(frames.StopState(device="base", latched=True, confirmed=True))
    await again.say(frames.LeaseState(device="base"))
    assert (await page.hear(page_wire.StopUpdate)).latched
    assert (await page.hear(page_wire.LeaseUpdate)).holder == ""


async def test_who_is_refused_the_lease_is_told_who_holds_it(hub, gateway) -> None:
    holder, other = await hub.page("operator"), await hub.page("admin")
    ask = await take_lease(holder, gateway)
    await other.say(LEASE)
    second = await gateway.hear(frames.LeaseRequest)
    await gateway.say(
        frames.LeaseState(
            device="base",
            session=ask.session,
            who="operator",
            epoch=7,
            asked=second.session,
            refused="operator holds it",
        )
    )
    news = await other.hear(page_wire.LeaseUpdate, lambda news: news.refused)
    assert (news.holder, news.refused) == ("operator", "operator holds it")


async def test_driving_frame_goes_down_as_it_came(hub, gateway) -> None:
    page = await hub.page("operator")
    ask = await take_lease(page, gateway)
    await page.say(DRIVE)
    drive = await gateway.hear(frames.DriveFrame)
    assert drive.session == ask.session
    assert (drive.epoch, drive.seq, drive.tick, drive.held_ms) == (7, 1, 3, 2.0)
    assert (drive.linear, drive.angular) == (0.1, 0.2)


async def test_driving_frame_that_is_no_number_is_not_passed_on(hub, gateway) -> None:
    page = await hub.page("operator")
    await page.say(
        page_wire.PageDrive(
            site="agv", device="base", epoch=1, seq=1, tick=1, linear=float("nan"), angular=0.0
        )
    )
    assert (await page.hear(page_wire.RequestError)).code == "invalid"
    await page.say(DRIVE)
    assert (await gateway.hear(frames.DriveFrame)).linear == 0.1


async def test_ticks_go_to_the_holder_only(hub, gateway) -> None:
    holder, other = await hub.page("operator"), await hub.page("admin")
    await take_lease(holder, gateway)
    await gateway.say(frames.ControlTick(tick=42))
    await gateway.say(frames.DriveState(device="base", linear=0.1, angular=0.0, cap=1.0))
    assert (await holder.hear(page_wire.TickUpdate)).tick == 42
    await other.hear(page_wire.DriveUpdate)
    assert not any(isinstance(each, page_wire.TickUpdate) for each in other.heard)


async def test_closed_page_frees_its_lease_at_once(hub, gateway) -> None:
    page = await hub.page("operator")
    ask = await take_lease(page, gateway)
    await page.hear(page_wire.LeaseUpdate)
    await page.close()
    free = await gateway.hear(frames.LeaseRequest, lambda ask: ask.op is LeaseOp.FREE)
    assert (free.device, free.session) == ("base", ask.session)


async def test_closed_page_leaves_no_subscription_behind(hub, gateway) -> None:
    page = await hub.page("operator")
    await page.say(page_wire.Subscribe(sub=1, site="agv", channels=["base/speed"]))
    await take_lease(page, gateway)
    await page.hear(page_wire.LeaseUpdate)
    browser = next(iter(hub.hub.core.browsers))
    assert hub.hub.core.fanout.held(browser) == (1, 1)
    await page.close()
    await gateway.hear(frames.LeaseRequest, lambda ask: ask.op is LeaseOp.FREE)
    assert hub.hub.core.fanout.held(browser) == (0, 0)


async def test_lost_link_shows_leases_as_free_and_commands_as_unknown(hub, gateway) -> None:
    page = await hub.page("operator")
    await take_lease(page, gateway)
    await page.hear(page_wire.LeaseUpdate, lambda news: news.yours)
    await page.say(WANDER)
    await gateway.hear(frames.CommandRequest)
    await gateway.close()
    assert (await page.hear(page_wire.LeaseUpdate)).holder == ""
    assert (await page.hear(page_wire.CommandUpdate)).phase is CommandPhase.UNKNOWN


async def test_stop_needs_no_lease_and_its_confirmation_comes_back(hub, gateway) -> None:
    page, other = await hub.page("operator"), await hub.page("admin")
    await page.say(STOP)
    ask = await gateway.hear(frames.StopRequest)
    assert (ask.device, ask.id, ask.who) == ("base", "stop-1", "operator")
    await gateway.say(frames.StopState(device="base", latched=True, who=ask.who, id=ask.id))
    await gateway.say(frames.StopState(device="base", latched=True, confirmed=True, id=ask.id))
    for each in (page, other):
        news = await each.hear(page_wire.StopUpdate, lambda news: news.confirmed)
        assert (news.latched, news.id) == (True, "stop-1")


async def test_stop_is_told_to_a_page_that_comes_later(hub, gateway) -> None:
    page = await hub.page("operator")
    await gateway.say(frames.StopState(device="base", latched=True, confirmed=True))
    await page.hear(page_wire.StopUpdate)
    assert (await (await hub.page("admin")).hear(page_wire.StopUpdate)).latched


async def test_reset_key_goes_to_the_one_who_asked(hub, gateway) -> None:
    page, other = await hub.page("operator"), await hub.page("operator")
    await page.say(page_wire.PageReset(site="agv", device="base", epoch=7))
    ask = await gateway.hear(frames.ResetRequest)
    await gateway.say(frames.ResetToken(device="base", session=ask.session, token="key"))  # noqa: S106
    assert (await page.hear(page_wire.ResetTokenUpdate)).token == "key"  # noqa: S105
    await gateway.say(frames.StopState(device="base", latched=False))
    await other.hear(page_wire.StopUpdate)
    assert not any(isinstance(each, page_wire.ResetTokenUpdate) for each in other.heard)


async def test_command_goes_down_once_and_its_phases_come_back(hub, gateway) -> None:
    page, other = await hub.page("operator"), await hub.page("admin")
    await page.say(WANDER)
    ask = await gateway.hear(frames.CommandRequest)
    assert (ask.command, ask.args, ask.ttl_ms, ask.who) == (
        "wander",
        {"active": True},
        5000.0,
        "operator",
    )
    await page.say(WANDER)
    assert (await page.hear(page_wire.RequestError)).code == "busy"
    for phase in (CommandPhase.ACCEPTED, CommandPhase.SUCCEEDED):
        await gateway.say(
            frames.CommandState(id="c-1", device="base", command="wander", phase=phase)
        )
    for each in (page, other):
        news = await each.hear(
            page_wire.CommandUpdate, lambda news: news.phase is CommandPhase.SUCCEEDED
        )
        assert news.who == "operator"


async def test_who_acts_is_told_and_the_wish_to_interrupt_goes_down_with_the_command(
    hub, gateway
) -> None:
    page = await hub.page("operator")
    await page.say(WANDER)
    ask = await gateway.hear(frames.CommandRequest)
    assert ask.over == ""
    why, blocked_by = "Ada is acting on Base: Wander (since 4 s)", "theirs"
    await gateway.say(
        frames.CommandState(
            id=ask.id, device="base", command="wander", phase=CommandPhase.REFUSED, message=why,
            blocked_by=blocked_by,
        )
    )  # fmt: skip
    news = await page.hear(page_wire.CommandUpdate)
    assert (news.message, news.blocked_by) == (why, blocked_by)
    await page.say(replace(WANDER, id="c-2", over=blocked_by))
    assert (await gateway.hear(frames.CommandRequest)).over == blocked_by


async def test_a_page_that_comes_while_somebody_acts_is_told_who_and_for_how_long(
    hub, gateway
) -> None:
    before = await hub.page("operator")
    acting = frames.CommandState(
        id="hers", device="base", command="wander", phase=CommandPhase.RUNNING, who="Ada",
        acting="Ada is acting on Base: Wander", acting_s=4.0,
    )  # fmt: skip
    await gateway.say(acting)
    assert (await before.hear(page_wire.CommandUpdate)).acting == acting.acting
    late = await (await hub.page("operator")).hear(page_wire.CommandUpdate)
    assert (late.id, late.who, late.acting) == ("hers", "gateway: Ada", acting.acting)
    assert 4.0 <= late.acting_s < 60.0
    # Names of people are for those who may view the device.
    guest = await hub.page("guest")
    await gateway.say(replace(acting, id="his", over="Base: Wander of Ada (hers)", who="Bob"))
    await before.hear(page_wire.CommandUpdate, lambda news: news.id == "his")
    await hub.hub.audit.log.wait_written()
    admin = await hub.client("admin")
    found = (await admin.get("/api/audit", params={"kind": "command interrupts"})).json()["rows"]
    assert [(row["who"], row["message"]) for row in found] == [
        ("gateway: Bob", "wander his interrupts Base: Wander of Ada (hers)")
    ]
    for each in ("hers", "his"):
        await gateway.say(replace(acting, id=each, phase=CommandPhase.SUCCEEDED, acting=""))
    await before.hear(page_wire.CommandUpdate, lambda news: (news.id, news.acting) == ("his", ""))
    await gateway.say(replace(acting, id="third"))
    last = await hub.page("operator")
    assert (await last.hear(page_wire.CommandUpdate)).id == "third"
    assert not [one for one in guest.heard if isinstance(one, page_wire.CommandUpdate)]


UNKNOWN = (
    (page_wire.PageCommand(site="agv", device="base", command="fly", id="x"), "unknown"),
    (
        page_wire.PageCommand(site="agv", device="base", command="wander", id="x", args={"up": 1}),
        "invalid",
    ),
    (page_wire.PageCommand(site="agv", device="wing", command="wander", id="x"), "unknown"),
    (page_wire.PageStop(site="moon", device="base", id="x"), "unknown"),
)


# What is refused changes nothing, so one hub is asked all of it.


async def test_what_the_description_does_not_know_is_refused(hub, gateway) -> None:
    page = await hub.page("operator")
    for message, code in UNKNOWN:
        await page.say(message)
        assert (await page.hear(page_wire.RequestError)).code == code, message


async def test_everything_asked_of_an_absent_gateway_is_answered_offline(hub, gateway) -> None:
    page = await hub.page("operator")
    await gateway.close()
    await page.hear(page_wire.SiteUpdate, lambda news: not news.online)
    for message in (LEASE, DRIVE, STOP, WANDER):
        await page.say(message)
        problem = await page.hear(page_wire.RequestError)
        assert (problem.code, problem.about) == ("offline", type(message).__struct_config__.tag)


async def test_guest_acts_on_nothing(hub, gateway) -> None:
    page = await hub.page("guest")
    for message in (LEASE, DRIVE, STOP, WANDER):
        await page.say(message)
        assert (await page.hear(page_wire.RequestError)).code == "forbidden", message
    operator = await hub.page("operator")
    await operator.say(STOP)
    await gateway.hear(frames.StopRequest, lambda ask: ask.who == "operator")
    assert not any(
        isinstance(each, frames.DriveFrame | frames.CommandRequest | frames.StopRequest)
        for each in gateway.heard
    )


async def test_guest_is_told_nothing_of_what_others_do(hub, gateway) -> None:
    guest, operator = await hub.page("guest"), await hub.page("operator")
    await take_lease(operator, gateway)
    await gateway.say(frames.DriveState(device="base", linear=0.1, angular=0.0, cap=1.0))
    await gateway.say(frames.StopState(device="base", latched=True))
    await gateway.say(frames.Event(kind="connection lost", device="base"))
    await operator.say(WANDER)
    await gateway.hear(frames.CommandRequest)
    await operator.hear(page_wire.EventUpdate, lambda news: news.kind == "connection lost")
    await gateway.samples(("base/speed", 1, 1.0))
    await guest.say(page_wire.Subscribe(sub=1, site="agv", channels=["base/speed"]))
    await guest.hear(page_wire.Subscribed)
    allowed = (page_wire.Greeting, page_wire.SiteUpdate, page_wire.Values)
    assert [each for each in guest.heard if not isinstance(each, allowed)] == []


async def test_what_was_done_is_written_down_in_an_unbroken_chain(hub, gateway) -> None:
    page = await hub.page("operator")
    await take_lease(page, gateway)
    await page.say(STOP)
    await gateway.hear(frames.StopRequest)
    audit: Audit = hub.hub.audit.log
    await audit.wait_written()
    kinds = {row.entry.kind for row in (await audit.find_records(AuditFilter(site="agv"), 100))[0]}
    assert {"gateway connected", "lease taken", "stop pressed"} <= kinds
    assert (await audit.verify_chain()).broken == 0


def picture(seq: int) -> frames.PictureFrame:
    return frames.PictureFrame(
        stream="camera/front",
        seq=seq,
        time_us=1,
        mono_us=seq,
        width=2,
        height=2,
        data=bytes([seq % 256]) * 100,
    )


async def test_stream_is_watched_while_someone_looks_and_rests_afterwards(hub, gateway) -> None:
    assert (await gateway.hear(frames.StreamSubscription)).streams == []
    viewer = await hub.viewer("operator", "camera/front")
    assert (await gateway.hear(frames.StreamSubscription)).streams == ["camera/front"]
    await viewer.close()
    assert (await gateway.hear(frames.StreamSubscription)).streams == []


async def test_slow_viewer_gets_two_pictures_and_then_the_newest(hub, gateway) -> None:
    viewer = await hub.viewer("operator", "camera/front")
    await gateway.hear(frames.StreamSubscription, lambda watch: watch.streams)
    camera = await hub.camera()
    for seq in (1, 2):
        await camera.say(picture(seq))
        shot = await viewer.hear(page_wire.CameraPicture)
        assert (shot.seq, shot.data) == (seq, picture(seq).data)
    for seq in range(3, 11):
        await camera.say(picture(seq))
        # The answer to a beat says that the picture before it was handed on.
        await camera.say(frames.Beat(n=seq, mono_us=1))
        await camera.hear(frames.BeatReply)
    await viewer.say(page_wire.PictureShown(seq=1))
    assert (await viewer.hear(page_wire.CameraPicture)).seq == 10


async def test_viewer_is_told_the_clock_by_which_its_pictures_are_stamped(hub, gateway) -> None:
    viewer = await hub.viewer("operator", "camera/front")
    before_us = SystemClock().monotonic_ns() // 1000
    await viewer.say(page_wire.PagePing(n=7, at_ms=1.5))
    pong = await viewer.hear(page_wire.PagePong)
    assert (pong.n, pong.at_ms) == (7, 1.5)
    assert before_us <= pong.hub_us <= SystemClock().monotonic_ns() // 1000


async def test_guest_sees_no_stream_that_is_not_public(hub, gateway) -> None:
    with pytest.raises(Exception, match="404"):
        await hub.viewer("guest", "camera/front")


async def test_twenty_viewers_that_never_answer_do_not_hold_up_one_that_does(hub, gateway) -> None:
    idle = [await hub.viewer("operator", "camera/front") for _ in range(20)]
    viewer = await hub.viewer("operator", "camera/front")
    camera = await hub.camera()
    for seq in range(1, 30):
        await camera.say(picture(seq))
        shot = await viewer.hear(page_wire.CameraPicture)
        assert shot.seq == seq
        await viewer.say(page_wire.PictureShown(seq=seq))
    await asyncio.gather(*(each.close() for each in idle))


def forms_of(watch: frames.StreamSubscription) -> list[str]:
    return watch.forms.get("camera/front", [])


def film(seq: int, form: str, *, key: bool = False) -> frames.PictureFrame:
    return frames.PictureFrame(
        stream="camera/front", seq=seq, time_us=1, mono_us=seq, width=2, height=2, format="h264",
        forms=[form], key=key, codec="avc1.42C01E" if key else "", data=bytes(100),
    )  # fmt: skip


async def test_each_page_gets_the_form_it_can_show_and_each_form_is_asked_for_once(
    hub, gateway
) -> None:
    old = await hub.viewer("operator", "camera/front")
    new = [await hub.viewer("operator", "camera/front&forms=h264,jpeg") for _ in range(3)]
    asked = await gateway.hear(
        frames.StreamSubscription, lambda watch: len(watch.forms.get("camera/front", ())) > 1
    )
    assert asked.forms == {"camera/front": ["h264", "jpeg"]}
    assert (await gateway.hear(frames.KeyframeRequest)).form == "h264"
    camera = await hub.camera()
    await camera.say(film(1, "h264", key=True))
    await camera.say(msgspec.structs.replace(picture(1), forms=["jpeg"]))
    for each in new:
        shot = await each.hear(page_wire.CameraPicture)
        assert (shot.format, shot.key, shot.codec) == ("h264", True, "avc1.42C01E")
    assert (await old.hear(page_wire.CameraPicture)).format == "jpeg"
    assert not any(isinstance(each, page_wire.CameraPicture) for each in old.heard[:-1])


async def test_pictures_of_an_older_gateway_reach_pages_that_play_films(hub, gateway) -> None:
    viewer = await hub.viewer("operator", "camera/front&forms=h264,jpeg")
    await gateway.hear(frames.StreamSubscription, lambda watch: watch.streams)
    camera = await hub.camera()
    for seq in (1, 2, 3):
        await camera.say(picture(seq))
        assert (await viewer.hear(page_wire.CameraPicture)).format == "jpeg"
        await viewer.say(page_wire.PictureShown(seq=seq))


async def test_why_a_camera_cannot_be_shown_is_told_to_pages_that_understand_it(
    hub, gateway
) -> None:
    new = await hub.viewer("operator", "camera/front&forms=h264,jpeg")
    old = await hub.viewer("operator", "camera/front")
    camera = await hub.camera()
    await camera.say(frames.StreamError(stream="camera/front", why="it is cut off"))
    said = await new.hear(page_wire.RequestError)
    assert (said.code, said.message) == ("picture", "it is cut off")
    later = await hub.viewer("operator", "camera/front&forms=jpeg")
    assert (await later.hear(page_wire.RequestError)).message == "it is cut off"
    await camera.say(picture(1))
    await old.hear(page_wire.CameraPicture)
    assert not any(isinstance(each, page_wire.RequestError) for each in old.heard)


async def test_a_hidden_page_has_stills(hub, gateway) -> None:
    viewer = await hub.viewer("operator", "camera/front&forms=h264,jpeg")
    await viewer.say(page_wire.ViewerAttention(still=True))
    asked = await gateway.hear(
        frames.StreamSubscription, lambda watch: watch.forms.get("camera/front") == ["still"]
    )
    assert asked.streams == ["camera/front"]


ASK = page_wire.PageLease(site="agv", device="base", op=LeaseOp.ASK)
FORCE = page_wire.PageLeaseForce(site="agv", device="base")


def asked_of(holder: frames.LeaseRequest, asker: frames.LeaseRequest) -> frames.LeaseState:
    return frames.LeaseState(
        device="base",
        session=holder.session,
        who=holder.who,
        epoch=7,
        remains_ms=3000,
        rival=asker.session,
        rival_who=asker.who,
        rival_ms=5000,
        asked=asker.session,
    )


async def test_an_ask_is_shown_to_the_holder_and_to_the_asker_as_theirs(hub, gateway) -> None:
    holder, asker = await hub.page("operator"), await hub.page("admin")
    held = await take_lease(holder, gateway)
    await asker.say(ASK)
    ask = await gateway.hear(frames.LeaseRequest, lambda ask: ask.op is LeaseOp.ASK)
    await gateway.say(asked_of(held, ask))
    seen = await holder.hear(page_wire.LeaseUpdate, lambda news: news.rival)
    mine = await asker.hear(page_wire.LeaseUpdate, lambda news: news.rival)
    assert (seen.yours, seen.rival, seen.asking) == (True, "admin", False)
    assert (mine.yours, mine.rival, mine.asking) == (False, "admin", True)
    assert 4000 <= seen.answer_ms <= 5000


async def test_a_no_is_told_to_the_asker_alone(hub, gateway) -> None:
    holder, asker = await hub.page("operator"), await hub.page("admin")
    held = await take_lease(holder, gateway)
    await holder.hear(page_wire.LeaseUpdate)
    await asker.say(ASK)
    ask = await gateway.hear(frames.LeaseRequest, lambda ask: ask.op is LeaseOp.ASK)
    await gateway.say(
        frames.LeaseState(
            device="base", session=held.session, who=held.who, epoch=7,
            asked=ask.session, refused="operator keeps control", forceable=True,
        )
    )  # fmt: skip
    news = await asker.hear(page_wire.LeaseUpdate, lambda news: news.refused)
    assert news.forceable
    await gateway.say(frames.DriveState(device="base", linear=0.0, angular=0.0, cap=1.0))
    await holder.hear(page_wire.DriveUpdate)
    told = [each for each in holder.heard if isinstance(each, page_wire.LeaseUpdate)]
    assert not any(each.refused or each.forceable for each in told)


async def test_only_an_admin_may_force(hub, gateway) -> None:
    operator, admin = await hub.page("operator"), await hub.page("admin")
    await operator.say(FORCE)
    assert (await operator.hear(page_wire.RequestError)).code == "forbidden"
    await admin.say(FORCE)
    forced = await gateway.hear(frames.LeaseForceRequest)
    assert (forced.device, forced.who) == ("base", "admin")


async def test_an_asker_who_closes_the_page_withdraws(hub, gateway) -> None:
    holder, asker = await hub.page("operator"), await hub.page("admin")
    await take_lease(holder, gateway)
    await asker.say(ASK)
    ask = await gateway.hear(frames.LeaseRequest, lambda ask: ask.op is LeaseOp.ASK)
    await asker.close()
    free = await gateway.hear(frames.LeaseRequest, lambda ask: ask.op is LeaseOp.FREE)
    assert free.session == ask.session


async def test_a_command_that_takes_the_right_admin_is_shown_to_and_taken_from_no_other(
    hub,
) -> None:
    text = DESCRIPTION.replace("name: Wander about", "name: Wander about\n        right: admin")
    assert text != DESCRIPTION
    gateway = await hub.gateway()
    await gateway.hello(text)
    listed = {}
    for name in ("operator", "admin"):
        detail = (await (await hub.client(name)).get("/api/sites/agv")).json()
        base = next(device for device in detail["devices"] if device["id"] == "base")
        listed[name] = {command["id"] for command in base["commands"]}
    assert listed["admin"] - listed["operator"] == {"wander"}
    page = await hub.page("operator")
    await page.say(WANDER)
    problem = await page.hear(page_wire.RequestError)
    assert (problem.code, problem.message) == (
        "forbidden",
        "Wander about needs the right admin on this device",
    )
    await (await hub.page("admin")).say(WANDER)
    # The first that comes to the gateway: the operator's has not.
    assert (await gateway.hear(frames.CommandRequest)).who == "admin"
