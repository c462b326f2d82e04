"""Two gateways with one key: who has the place is decided by what a thief cannot choose."""

from __future__ import annotations

import contextlib

import msgspec
import pytest
import websockets

from talaia.hub.live.gateways import frame_limits
from talaia.wire.browser import (
    EventUpdate,
    HeldStopUpdate,
    PagePing,
    PagePong,
    PageStop,
    SiteUpdate,
)
from talaia.wire.frames import (
    MEDIA_FROM_GATEWAY,
    MEDIA_FROM_HUB,
    Ack,
    Beat,
    BeatReply,
    Bye,
    LinkHeld,
    ResumeSaved,
    StopRequest,
    StopState,
    Welcome,
)
from talaia.wire.gateway_proof import read_next_nonce

NOW = 1_700_000_000_000_000
# As a thief would call it, to come after every other.
LAST = "~~~~"


async def linked(hub, resume: str = "", *, boot: str = "boot-1"):
    """Link a gateway that proves its key, and keeps what it is handed down."""
    gateway = await hub.proven_gateway(resume)
    welcome = await gateway.hello(boot=boot)
    await gateway.say(ResumeSaved(serial=int(welcome.resume.split(".")[1])))
    return gateway, welcome.resume


async def waiting(hub, resume: str = "", *, boot: str = LAST):
    """Open the link of a gateway that is to wait."""
    gateway = await hub.proven_gateway(resume)
    await gateway.say(gateway.hello_message(boot=boot))
    await gateway.hear(LinkHeld)
    return gateway


async def said_once(page) -> EventUpdate:
    return await page.hear(EventUpdate, lambda news: news.kind == "second gateway")


async def stands(gateway) -> None:
    """See that a gateway's link stands: its samples are stored."""
    await gateway.samples(("base/speed", NOW, 0.5))
    await gateway.hear(Ack)


async def test_whoever_calls_its_run_last_of_all_waits_and_people_are_told(hub) -> None:
    page = await hub.page("operator")
    gateway, _ = await linked(hub)
    thief = await waiting(hub)
    assert not (await said_once(page)).good
    assert (await page.hear(SiteUpdate, lambda news: news.rival_us > 0)).online
    # What it says belongs to no site, and nothing but beats comes to it.
    thief.channels = gateway.channels
    await thief.samples(("base/speed", NOW, 99.0))
    await thief.hear(Beat)
    await stands(gateway)
    assert ("agv", LAST) not in hub.history.samples


async def test_a_thief_that_says_the_key_as_gateways_of_before_did_is_kept_out(hub) -> None:
    gateway, _ = await linked(hub)
    # Even with the name of the run that is linked.
    for boot in (LAST, "boot-1"):
        thief = await hub.gateway()
        await thief.say(thief.hello_message(boot=boot))
        assert "another gateway" in (await thief.hear(Bye)).reason
        assert await thief.closed() == 4409
    await stands(gateway)


async def test_of_two_of_before_the_first_stays_and_the_same_run_takes_its_own_place(hub) -> None:
    first = await hub.gateway()
    await first.hello(boot="boot-1")
    second = await hub.gateway()
    await second.say(second.hello_message(boot="boot-2"))
    assert (await second.hear(Bye)).after_s > 0
    again = await hub.gateway()
    await again.hello(boot="boot-1")
    assert await first.closed() == 4409


@pytest.mark.parametrize("saved", [True, False])
async def test_the_same_gateway_takes_its_place_at_once_behind_a_half_open_link(hub, saved) -> None:
    page = await hub.page("operator")
    _, before = await linked(hub)
    # Killed before it has the newer one on its disk, it comes with the one before.
    half_open = await hub.proven_gateway(before)
    newer = (await half_open.hello(boot="boot-2")).resume
    if saved:
        await half_open.say(ResumeSaved(serial=int(newer.split(".")[1])))
    back, _ = await linked(hub, newer if saved else before, boot="boot-0")
    assert await half_open.closed() == 4409
    await stands(back)
    # It is no second gateway.
    await page.say(PagePing(n=1, at_ms=0.0))
    await page.hear(PagePong)
    assert not [x for x in page.heard if isinstance(x, EventUpdate) and x.kind == "second gateway"]


async def test_a_copied_disk_knows_only_of_earlier_links_and_waits(hub) -> None:
    _, copied = await linked(hub)
    gateway, _ = await linked(hub, copied, boot="boot-2")
    copy = await waiting(hub, copied)
    await stands(gateway)
    assert copy.close_code is None


async def test_who_was_there_before_the_thief_takes_its_place_back_by_itself(
    hub,
) -> None:
    page = await hub.page("operator")
    gateway, handed = await linked(hub)
    await gateway.close()
    await page.hear(SiteUpdate, lambda news: not news.online)
    # While the robot is away the key alone is enough; and it may dial again and again.
    thief, stolen = await linked(hub, boot=LAST)
    await thief.close()
    await page.hear(SiteUpdate, lambda news: not news.online)
    thief, stolen = await linked(hub, stolen, boot=LAST)
    back, _ = await linked(hub, handed, boot="boot-2")
    assert await thief.closed() == 4409
    assert "has come back" in (await said_once(page)).message
    # What the thief was handed down shows nothing any more.
    await waiting(hub, stolen)
    await stands(back)


async def test_a_recorded_handshake_opens_nothing(hub) -> None:
    recorded = await hub.proof("/gateway/link")
    await hub.dial("/gateway/link", recorded)
    for path in ("/gateway/link", "/gateway/media", "/gateway/files"):
        with pytest.raises(websockets.InvalidStatus) as refused:
            await hub.dial(path, recorded)
        assert refused.value.response.status_code == 401
    # One that was not used yet opens no other path either.
    with pytest.raises(websockets.InvalidStatus):
        await hub.dial("/gateway/media", await hub.proof("/gateway/link"))


async def test_a_proof_of_another_key_or_of_a_number_of_ones_own_is_refused(hub) -> None:
    with pytest.raises(websockets.InvalidStatus):
        await hub.proven_gateway(key="guessed")
    said = (await hub.proof("/gateway/link"))["Authorization"]
    nonce = said.split("nonce=")[1].split(",")[0]
    own = f"{'0' * 32}.{nonce.split('.')[1]}.{nonce.split('.')[2]}"
    with pytest.raises(websockets.InvalidStatus):
        await hub.dial("/gateway/link", {"Authorization": said.replace(nonce, own)})


async def test_a_forged_place_shows_nothing(hub) -> None:
    gateway, handed = await linked(hub)
    lineage, serial, secret = handed.split(".")
    for forged in (
        f"{lineage}.{serial}.{'00' * 32}",
        # The earliest of all, and the latest, each with a secret that was handed down.
        f"1.{serial}.{secret}",
        f"{lineage}.{int(serial) + 10**9}.{secret}",
    ):
        await (await waiting(hub, forged)).close()
    await stands(gateway)


async def test_a_revoked_key_proves_nothing_and_one_that_waits_is_sent_away(hub) -> None:
    gateway, handed = await linked(hub)
    thief = await waiting(hub)
    admin = await hub.client("admin")
    (mine,) = (await admin.get("/api/gateways")).json()["gateways"]
    assert (await admin.post(f"/api/gateways/{mine['id']}/revoke")).status_code == 204
    await gateway.closed()
    await thief.closed()
    with pytest.raises(websockets.InvalidStatus):
        await hub.proven_gateway(handed)


async def test_stop_reaches_both(hub) -> None:
    page = await hub.page("operator")
    gateway, _ = await linked(hub)
    second = await waiting(hub)
    await page.say(PageStop(site="agv", device="base", id="s1"))
    for each in (gateway, second):
        assert (await each.hear(StopRequest)).id == "s1"
    # The page is shown at once that there are two to stop, and how far each has come.
    assert (await page.hear(HeldStopUpdate)).latched == 0
    await second.say(StopState(device="base", latched=True, id="s1", who="somebody"))
    news = await page.hear(HeldStopUpdate, lambda news: news.latched > 0)
    assert (news.id, news.held, news.latched, news.confirmed) == ("s1", 1, 1, 0)
    await second.say(StopState(device="base", latched=True, confirmed=True, id="s1"))
    await page.hear(HeldStopUpdate, lambda news: news.confirmed == 1)
    # What nobody pressed there is not its to say, nor how STOP stands at the one that is linked.
    await second.say(StopState(device="arm", latched=True, id="s1"))
    for _ in range(3):
        await second.say(StopState(device="base", latched=False))
        await second.say(StopState(device="base", latched=True, confirmed=True, id="s1"))
    late = await hub.page("operator")
    assert (await late.hear(HeldStopUpdate)).device == "base"
    admin = await hub.client("admin")
    rows = (await admin.get("/api/audit", params={"kind": "second gateway: "})).json()["rows"]
    assert [(row["kind"], row["who"], row["source"]) for row in rows] == [
        ("second gateway: stop confirmed by the robot", "", "gateway"),
        ("second gateway: stop latched", "", "gateway"),
    ]
    assert not hub.hub.core.sites.find_site("agv").retained.stops
    await second.close()
    assert (await page.hear(HeldStopUpdate, lambda news: news.held == 0)).id == ""


async def test_an_admin_lets_the_other_one_take_over_and_the_first_one_waits(hub) -> None:
    admin = await hub.client("admin")
    first, handed = await linked(hub)
    second = await waiting(hub, boot="boot-2")
    (mine,) = (await admin.get("/api/gateways")).json()["gateways"]
    assert [each["version"] for each in mine["held"]] == [""]
    path = f"/api/gateways/{mine['id']}/second"
    operator = await hub.client("operator")
    assert (await operator.post(path, json={"stays": "held"})).status_code == 403
    assert (await admin.post(path, json={"stays": "held"})).status_code == 204
    chosen = (await second.hear(Welcome)).resume
    assert await first.closed() == 4409
    second.channels = first.channels
    await stands(second)
    # However long it was there before, and over the next link too.
    await (await waiting(hub, handed)).close()
    await second.say(ResumeSaved(serial=int(chosen.split(".")[1])))
    again, _ = await linked(hub, chosen, boot="boot-3")
    await waiting(hub, handed)
    await stands(again)
    await hub.hub.audit.log.wait_written()
    rows = (await admin.get("/api/audit", params={"kind": "second gateway settled"})).json()["rows"]
    assert [row["who"] for row in rows] == ["admin"]


async def test_an_admin_keeps_the_first_one_and_the_other_is_told_of_no_more(hub) -> None:
    admin, page = await hub.client("admin"), await hub.page("admin")
    first, _ = await linked(hub)
    second = await waiting(hub)
    await said_once(page)
    (mine,) = (await admin.get("/api/gateways")).json()["gateways"]
    path = f"/api/gateways/{mine['id']}/second"
    assert (await admin.post(path, json={"stays": "linked"})).status_code == 204
    await second.close()
    await waiting(hub)
    (site,) = (await admin.get("/api/sites")).json()
    assert site["rival_us"] == 0
    await stands(first)
    await first.close()
    assert (await admin.post("/api/gateways/999/second", json={"stays": "held"})).status_code == 404


async def test_the_one_that_waits_has_the_place_when_the_first_one_has_gone(hub) -> None:
    first, _ = await linked(hub)
    second = await waiting(hub)
    await first.close()
    await second.hear(Welcome)


async def test_a_thief_that_waits_puts_out_no_pictures_and_hands_over_no_files(hub) -> None:
    _, handed = await linked(hub)
    mine = await hub.dial("/gateway/media", await hub.proof("/gateway/media", handed))
    for path in ("/gateway/media", "/gateway/files"):
        for headers in (
            await hub.proof(path),
            {"Authorization": f"Bearer {hub.keys['agv']}"},
        ):
            theirs = await hub.dial(path, headers)
            # The reason, and then its end.
            await theirs.recv()
            await theirs.wait_closed()
            assert theirs.close_code == 1013
    await mine.send(MEDIA_FROM_GATEWAY.encode(Beat(n=1, mono_us=1)))
    assert isinstance(MEDIA_FROM_HUB.decode(await mine.recv()), BeatReply)


async def test_one_that_waits_and_talks_on_is_sent_away_and_costs_the_other_nothing(hub) -> None:
    gateway, _ = await linked(hub)
    thief = await waiting(hub)
    for number in range(200):
        await thief.say(BeatReply(n=number, mono_us=1, peer_us=1))
    assert await thief.closed() == 1013
    await stands(gateway)


async def test_what_no_hub_knows_from_one_that_waits_is_bounded_and_no_debt_of_the_site(
    hub,
) -> None:
    robot, handed = await linked(hub)
    few = frame_limits.Allowance(rate=0.001, burst=1.0)
    limits = frame_limits.FrameLimits(longest_over_s=0.0, others={frame_limits.UNKNOWN: few})
    hub.hub.core.sites.find_site("agv").frame_limits = limits
    thief = await waiting(hub)
    with contextlib.suppress(websockets.ConnectionClosed):
        for _ in range(150):
            await thief.connection.send(msgspec.msgpack.encode({"t": "of_a_later_version"}))
    assert await thief.closed() == 1013
    # The robot dials anew, and is not held off for what the thief said.
    await robot.close()
    back, _ = await linked(hub, handed, boot="boot-2")
    await stands(back)


async def test_only_so_many_wait(hub) -> None:
    await linked(hub)
    for _ in range(4):
        await waiting(hub)
    one_more = await hub.proven_gateway()
    await one_more.say(one_more.hello_message(boot=LAST))
    assert "another gateway" in (await one_more.hear(Bye)).reason


async def test_the_answer_to_an_upgrade_has_the_number_for_the_next_connection(hub) -> None:
    link = await hub.dial("/gateway/link", await hub.proof("/gateway/link"))
    assert read_next_nonce(link.response.headers["Authentication-Info"])
