"""A page's socket goes to all shards, and the page sees one hub; what fails at one, fails there."""

# ruff: noqa: D107
from __future__ import annotations

import asyncio
from contextlib import asynccontextmanager

import pytest
from patience import PATIENCE_S, stays, until_answered

from talaia.hub.sharding.page_join import PageJoin
from talaia.wire.browser import (
    FROM_BROWSER,
    TO_BROWSER,
    Greeting,
    PageCommand,
    PageDrive,
    PagePing,
    PagePong,
    PageStop,
    RequestError,
    SessionEnded,
    SessionUpdate,
    SiteUpdate,
    Subscribe,
    Subscribed,
    Unsubscribe,
    Values,
)
from talaia.wire.socket_frame import SocketFrame

from .small_shards import SmallPage, SmallShard

SHARDS = {"agv": "east", "arm": "west", "lab": "main"}


def values(sub: int) -> Values:
    return Values(sub=sub, base_us=1, channel=b"", offset=b"", value=b"")


def stop(site: str) -> PageStop:
    return PageStop(site=site, device="base", id="1")


def subscribe(sub: int, site: str) -> Subscribe:
    return Subscribe(sub=sub, site=site, channels=["base/speed"])


def online(site: str, catalogue: str = "c1") -> SiteUpdate:
    return SiteUpdate(site=site, online=True, since_us=1, catalogue=catalogue)


class World:
    """Three shards, and pages at what joins them."""

    def __init__(self) -> None:
        self.main, self.east, self.west = map(SmallShard, ("main", "east", "west"))
        apps = {"main": self.main, "east": self.east, "west": self.west}
        self.asked = []
        self.join = PageJoin(apps, self.shard_of, retry_s=0.01)
        self.pages = []

    def shard_of(self, site: str) -> str:
        self.asked.append(site)
        return SHARDS.get(site, "main")

    def page(self, **how) -> SmallPage:
        page = SmallPage(self.join, **how)
        self.pages.append(page)
        return page

    async def joined(self, **how):
        """Let a page in at all shards; give it, and each shard's end."""
        page = self.page(**how)
        ends = [await shard.end() for shard in (self.main, self.east, self.west)]
        assert (await page.hear(Greeting)).who == "ada at main"
        return page, *ends


@pytest.fixture
async def world():
    world = World()
    yield world
    for page in world.pages:
        if not page.serving.done():
            await page.leave()


@asynccontextmanager
async def nothing_more(page: SmallPage):
    """What is told within reaches the page before this ends, if it does at all."""
    yield
    assert page.heard.all == []


@pytest.mark.parametrize("text", [False, True], ids=["msgpack", "json"])
async def test_what_a_page_says_of_a_site_goes_to_its_shard_and_in_order(world, text) -> None:
    page, main, east, west = await world.joined(text=text)
    said = {
        east: [stop("agv"), subscribe(1, "agv"), stop("agv"), Unsubscribe(sub=1)],
        west: [subscribe(2, "arm"), stop("arm"), Unsubscribe(sub=2)],
        main: [subscribe(3, "lab"), stop("lab"), stop("unknown"), Unsubscribe(sub=3)],
    }
    for at in range(4):
        for messages in said.values():
            for message in messages[at : at + 1]:
                page.say(message)
    for end, messages in said.items():
        assert [await end.heard.take() for _ in messages] == messages
        assert end.heard.all == []


async def test_each_shard_gets_the_page_s_own_request_without_what_is_the_server_s(world) -> None:
    _, *ends = await world.joined()
    for end in ends:
        assert end.scope["headers"] == [(b"cookie", b"talaia=secret")]
        assert "websocket.http.response" in end.scope["extensions"]
        # By this the server would hand messages to one shard alone.
        assert "talaia.message_taker" not in end.scope["extensions"]


async def test_what_cannot_be_read_is_answered_by_the_main_shard(world) -> None:
    page, main, east, west = await world.joined()
    long = PageStop(site="agv", device="base", id="1" * FROM_BROWSER.max_frame)
    too_long = FROM_BROWSER.encode(long)
    for data in (b"\xc1", b"", b"\x81\xa4site\xa3agv", too_long):
        page.say_data({"bytes": data})
        assert await main.unread.take() == data
    for text in ("no JSON", '{"t":"stop","site":7}'):
        page.say_data({"text": text})
        assert await main.unread.take() == text
    assert east.unread.all == west.unread.all == []


async def test_a_ping_keeps_the_session_everywhere_and_one_pong_comes_back(world) -> None:
    page, *ends = await world.joined()
    ping = PagePing(n=7, at_ms=1.0, active=True)
    page.say(ping)
    for end in reversed(ends):
        assert await end.heard.take() == ping
        await end.say(PagePong(n=7, at_ms=1.0, hub_us=ends.index(end)))
    async with nothing_more(page):
        assert (await page.hear(PagePong)).hub_us == 0


@pytest.mark.parametrize("text", [False, True], ids=["msgpack", "json"])
async def test_what_shards_tell_comes_as_the_bytes_that_they_wrote(world, text) -> None:
    page, main, east, _ = await world.joined(text=text)
    told = [values(1), online("agv"), RequestError(code="busy", message="no", about="stop")]
    for end in (main, east):
        for message in told:
            await end.say(message)
            assert await page.hear(type(message)) == message
    encode = TO_BROWSER.encode_text if text else TO_BROWSER.encode
    for end in (main, east):
        assert end.write(SocketFrame(encode(values(9))))
    assert page.written == 2
    assert [said.sub for said in page.heard.all] == [9, 9]


async def test_a_page_that_is_greeted_by_a_written_frame_comes_to_the_other_shards(world) -> None:
    world.main.writes_greeting = True
    page, *_ = await world.joined()
    assert page.written == 1


async def test_a_frame_that_cannot_be_written_at_once_is_left_to_be_sent(world) -> None:
    page, main, east, _ = await world.joined()
    page.reads.clear()
    frames = [SocketFrame(TO_BROWSER.encode(said)) for said in (values(1), SessionEnded(reason=""))]
    for end in (main, east):
        # The end of a session is said by one of them alone.
        assert [end.write(frame) for frame in frames] == [False, end is east]
    page.reads.set()
    await main.say(SessionEnded(reason="over"))
    assert (await page.hear(SessionEnded)).reason == "over"


async def test_of_a_session_s_time_the_main_shard_tells_alone(world) -> None:
    page, main, east, _ = await world.joined()
    await east.say(SessionUpdate(ends_us=5))
    await main.say(SessionUpdate(ends_us=6))
    async with nothing_more(page):
        assert (await page.hear(SessionUpdate)).ends_us == 6


async def test_a_session_that_any_shard_ends_ends_everywhere_with_one_word(world) -> None:
    page, main, east, west = await world.joined()
    for end in (east, main):
        await end.say(SessionEnded(reason=f"over at {end.scope['path']}"))
    await page.hear(SessionEnded)
    await east.close(4401)
    assert await page.closed() == 4401
    async with asyncio.timeout(PATIENCE_S):
        await page.serving
        await main.left.wait()
        await west.left.wait()
    assert page.heard.all == page.answer.all[1:] == []


async def test_who_breaks_the_rules_at_one_shard_is_sent_away_with_its_word(world) -> None:
    page, _, east, _ = await world.joined()
    await east.say(RequestError(code="invalid", message="no such frame"))
    await east.close(1002)
    assert (await page.hear(RequestError)).code == "invalid"
    assert await page.closed() == 1002


async def test_a_page_that_leaves_has_left_every_shard(world) -> None:
    page, *ends = await world.joined()
    await page.leave()
    assert all(end.left.is_set() for end in ends)


async def test_a_page_that_is_cancelled_has_left_every_shard(world) -> None:
    page, *ends = await world.joined()
    page.serving.cancel()
    await asyncio.gather(page.serving, return_exceptions=True)
    assert all(end.left.is_set() for end in ends)


class TestAdmission:
    """The main shard decides."""

    async def test_whom_the_main_shard_denies_gets_its_answer_and_no_other_shard_is_asked(
        self, world
    ) -> None:
        world.main.denies = 401
        page = world.page()
        await page.serving
        start, body = page.answer.all
        assert (start["status"], start["headers"]) == (401, [(b"retry-after", b"1")])
        assert body["body"] == b"no"
        assert world.east.asked == 0

    async def test_a_main_shard_that_cannot_be_reached_is_the_caller_s_to_tell(self, world) -> None:
        world.main.error = ConnectionError("no hub leads")
        with pytest.raises(ConnectionError, match="no hub leads"):
            await world.page().serving

    @pytest.mark.parametrize("fault", ["error", "denies", "opens"])
    async def test_another_shard_that_is_away_keeps_nobody_away_and_is_asked_again(
        self, world, fault
    ) -> None:
        if fault == "error":
            world.east.error = ConnectionError("no hub leads")
        elif fault == "denies":
            world.east.denies = 503
        else:
            world.east.opens.clear()
        page = world.page()
        west = await world.west.end()
        await page.hear(Greeting)
        # What is asked meanwhile is asked there when it is back; other things are not kept.
        page.say(subscribe(1, "agv"))
        page.say(stop("agv"))
        page.say(subscribe(2, "arm"))
        assert await west.heard.take() == subscribe(2, "arm")
        refused = await page.hear(RequestError)
        assert (refused.code, refused.about) == ("offline", "stop")
        world.east.error, world.east.denies = None, 0
        world.east.opens.set()
        east = await world.east.end()
        assert await east.heard.take() == subscribe(1, "agv")
        assert east.heard.all == []


class TestAShardThatBreaks:
    """The page stays, and sees that nothing is known of its sites."""

    @pytest.mark.parametrize(("how", "text"), [("closes", False), ("ends", True)])
    async def test_its_sites_are_said_to_be_away_at_once(self, world, how, text) -> None:
        page, _, east, west = await world.joined(text=text)
        for end, site in ((east, "agv"), (east, "agv"), (west, "arm")):
            await end.say(online(site, "c7"))
            await page.hear(SiteUpdate)
        # It does not come back.
        world.east.error = ConnectionError("no hub leads")
        if how == "closes":
            await east.close(1012)
        else:
            east.break_off()
        async with nothing_more(page):
            told = await page.hear(SiteUpdate)
            assert (told.site, told.online, told.away, told.catalogue) == ("agv", False, True, "c7")
            assert "cannot be reached" in told.why
        # And that is said once, however often it is asked again.
        asked = world.east.asked
        await stays(0.1, lambda: page.heard.all == [], "it is said again")
        assert world.east.asked > asked

    async def test_when_it_is_back_all_that_was_asked_there_is_asked_anew(self, world) -> None:
        page, _, east, west = await world.joined()
        for sub, site in ((1, "agv"), (2, "agv"), (3, "arm"), (4, "agv")):
            page.say(subscribe(sub, site))
        page.say(Unsubscribe(sub=2))
        for _ in range(4):
            await east.heard.take()
        await west.heard.take()
        await east.close(1012)
        back = await world.east.end()
        assert [await back.heard.take() for _ in range(2)] == [
            subscribe(1, "agv"),
            subscribe(4, "agv"),
        ]
        await back.say(online("agv"))
        assert (await page.hear(SiteUpdate)).online
        assert back.heard.all == west.heard.all == []
        assert page.answer.all[1:] == []

    async def test_nobody_drives_through_it_and_nothing_of_that_comes_later(self, world) -> None:
        page, _, east, _ = await world.joined()
        world.east.opens.clear()
        await east.close(1012)
        drive = PageDrive(site="agv", device="base", epoch=1, seq=1, tick=1, linear=1, angular=0)
        page.say(drive)
        page.say(PageCommand(site="agv", device="base", command="dock", id="1"))
        # Not for each of the frames that come many times a second.
        assert (await page.hear(RequestError)).about == "command"
        world.east.opens.set()
        back = await world.east.end()
        page.say(stop("agv"))
        assert await back.heard.take() == stop("agv")

    async def test_more_subscriptions_than_are_remembered_make_the_page_come_again(
        self, world
    ) -> None:
        page, _, east, _ = await world.joined()
        for sub in range(513):
            page.say(subscribe(sub, "agv"))
            await east.heard.take()
        await east.close(1012)
        assert await page.closed() == 1012

    async def test_a_failure_of_its_own_does_not_touch_the_others(self, world, caplog) -> None:
        world.east.error = ValueError("a fault in the program")
        page = world.page()
        west = await world.west.end()
        page.say(stop("arm"))
        assert await west.heard.take() == stop("arm")
        assert "a fault in the program" in caplog.text


class TestTheMainShardAway:
    """Whoever is in stays, and goes on with the sites of the others."""

    @pytest.mark.parametrize(("how", "text"), [("closes", False), ("raises", True)])
    async def test_its_own_sites_are_away_and_pings_are_answered_by_its_clock(
        self, world, how, text
    ) -> None:
        page, main, east, _ = await world.joined(text=text)
        page.say(subscribe(1, "lab"))
        await main.heard.take()
        await main.say(online("lab"))
        await page.hear(SiteUpdate)
        ahead_us = 10**15
        await main.say(PagePong(n=1, at_ms=1.0, hub_us=ahead_us))
        await page.hear(PagePong)
        world.main.opens.clear()
        if how == "closes":
            await main.close(1012)
        else:
            main.break_off(ConnectionError("the hub that leads is gone"))
        told = await page.hear(SiteUpdate)
        assert (told.site, told.away) == ("lab", True)
        page.say(PagePing(n=2, at_ms=2.0))
        pong = await page.hear(PagePong)
        assert (pong.n, pong.at_ms) == (2, 2.0)
        assert ahead_us <= pong.hub_us < ahead_us + PATIENCE_S * 1e6
        page.say(stop("agv"))
        assert await east.heard.take(lambda said: isinstance(said, PageStop)) == stop("agv")
        page.say(stop("lab"))
        assert (await page.hear(RequestError)).code == "offline"
        world.main.opens.set()
        back = await world.main.end()
        assert await back.heard.take() == subscribe(1, "lab")
        # The page is not greeted anew: it would begin anew.
        await back.say(online("lab"))
        async with nothing_more(page):
            assert (await page.hear(SiteUpdate)).online

    async def test_one_whose_session_it_knows_no_more_comes_again_to_hear_so(self, world) -> None:
        page, main, *_ = await world.joined()
        world.main.denies = 401
        await main.close(1012)
        assert await page.closed() == 1012

    async def test_one_that_is_busy_is_asked_again(self, world) -> None:
        _, main, *_ = await world.joined()
        world.main.denies = 503
        await main.close(1012)
        await stays(0.1, lambda: not world.pages[0].serving.done(), "the page is sent away")
        world.main.denies = 0
        await world.main.end()


class TestAPageThatHasGone:
    """Nobody fails because it cannot be told anything any more."""

    @pytest.mark.parametrize("error", [OSError("gone"), RuntimeError("closed already")])
    async def test_shards_that_break_meanwhile_are_no_failure_of_the_page_s(
        self, world, error
    ) -> None:
        page, main, east, _ = await world.joined()
        for end, site in ((main, "lab"), (east, "agv")):
            await end.say(online(site))
            await page.hear(SiteUpdate)
        page.error = error
        asked = world.main.asked
        world.main.error = world.east.error = ConnectionError("no hub leads")
        await main.close(1012)
        await east.close(1012)

        async def is_asked_again() -> bool:
            return world.main.asked > asked

        await until_answered(is_asked_again)
        # As it leaves, what failed would be raised.
        await page.leave()


class TestNumbers:
    """A subscription's number is one shard's at a time."""

    async def test_one_that_is_used_anew_for_another_shard_ends_at_the_former(self, world) -> None:
        page, main, east, west = await world.joined()
        for site, former in (("agv", None), ("arm", east), ("lab", west), ("agv", main)):
            page.say(subscribe(1, site))
            if former is not None:
                assert await former.heard.take(lambda said: isinstance(said, Unsubscribe))
        page.say(Unsubscribe(sub=1))
        assert await east.heard.take(lambda said: isinstance(said, Unsubscribe))

    @pytest.mark.parametrize("ended_before", [False, True])
    async def test_values_of_the_former_shard_are_not_shown_as_the_new_one_s(
        self, world, ended_before
    ) -> None:
        page, _, east, west = await world.joined()
        page.say(subscribe(1, "agv"))
        await east.heard.take()
        await east.say(values(1))
        await page.hear(Values)
        if ended_before:
            page.say(Unsubscribe(sub=1))
        page.say(subscribe(1, "arm"))
        await west.heard.take()
        # Under way when the number was used anew.
        await east.say(values(1))
        await east.say(Subscribed(sub=1))
        assert east.write(SocketFrame(TO_BROWSER.encode(values(1))))
        async with nothing_more(page):
            await west.say(values(1))
            await page.hear(Values)
            assert west.write(SocketFrame(TO_BROWSER.encode(values(1))))
            await page.hear(Values)


class TestALookUp:
    """Of a site that nobody has told of the shard is looked up, and nothing else waits for it."""

    async def test_stop_at_another_site_goes_before_and_its_own_site_s_order_stays(
        self, world
    ) -> None:
        answered = asyncio.get_running_loop().create_future()

        async def look_up() -> str:
            return await answered

        world.join.shard_of = lambda site: look_up() if site == "new" else SHARDS[site]
        page, main, east, west = await world.joined()
        page.say(subscribe(1, "new"))
        page.say(stop("new"))
        page.say(subscribe(1, "arm"))
        page.say(stop("agv"))
        assert await east.heard.take() == stop("agv")
        assert main.heard.all == west.heard.all == []
        answered.set_result("west")
        assert [await west.heard.take() for _ in range(3)] == [
            subscribe(1, "new"),
            stop("new"),
            subscribe(1, "arm"),
        ]

    async def test_where_it_fails_the_main_shard_answers(self, world) -> None:
        async def look_up() -> str:
            raise ConnectionError("no database")

        world.join.shard_of = lambda _site: look_up()
        page, main, *_ = await world.joined()
        page.say(stop("new"))
        assert await main.heard.take() == stop("new")

    async def test_a_page_that_says_more_than_is_kept_meanwhile_is_sent_away(self, world) -> None:
        async def look_up() -> str:
            return await asyncio.Future()

        world.join.shard_of = lambda _site: look_up()
        page, *_ = await world.joined()
        for _ in range(502):
            page.say(stop("new"))
        assert await page.closed() == 1012

    async def test_a_site_that_a_shard_has_told_of_is_not_looked_up(self, world) -> None:
        page, _, east, _ = await world.joined()
        await east.say(online("other"))
        await page.hear(SiteUpdate)
        page.say(stop("other"))
        assert await east.heard.take() == stop("other")
        assert "other" not in world.asked


class TestBounds:
    """Nothing grows because somebody does not read."""

    async def test_a_page_that_does_not_read_is_waited_for_by_each_shard(self, world) -> None:
        page, main, east, _ = await world.joined()
        page.reads.clear()
        telling = [asyncio.create_task(end.say(values(1))) for end in (main, east)]
        # It can stop a robot all the same.
        page.say(stop("agv"))
        assert await east.heard.take() == stop("agv")
        assert not any(task.done() for task in telling)
        page.reads.set()
        await asyncio.gather(*telling)

    async def test_a_shard_that_does_not_hear_is_left_and_the_others_go_on(self, world) -> None:
        page, _, east, west = await world.joined()
        await east.say(online("agv"))
        await page.hear(SiteUpdate)
        # It hears nothing more, as one that stands still.
        hears = east.heard.add
        blocked = asyncio.Event()

        async def wait(said) -> None:
            await blocked.wait()
            await hears(said)

        east.heard.add = wait
        for _ in range(2_002):
            page.say(stop("agv"))
        page.say(stop("arm"))
        assert await west.heard.take() == stop("arm")
        blocked.set()
        assert (await page.hear(SiteUpdate)).away
        await world.east.end()


async def test_what_a_page_looks_at_is_asked_of_the_shard_that_its_site_came_to(world) -> None:
    page, _, east, west = await world.joined()
    await east.say(online("agv"))
    await page.hear(SiteUpdate)
    asked = subscribe(1, "agv")
    page.say(asked)
    assert await east.heard.take() == asked
    # Its lead begins anew without it, and the other one tells of it.
    east.break_off()
    assert (await page.hear(SiteUpdate)).away
    again = await world.east.end()
    assert await again.heard.take() == asked
    await west.say(online("agv"))
    assert (await page.hear(SiteUpdate)).online
    assert await west.heard.take() == asked
    assert await again.heard.take() == Unsubscribe(sub=1)
    await west.say(values(1))
    assert await page.hear(Values) == values(1)
    # What the former one says yet is of then.
    async with nothing_more(page):
        await again.say(values(1))
    page.say(stop("agv"))
    assert await west.heard.take() == stop("agv")


async def test_a_page_that_asks_before_a_site_is_told_of_gets_it_from_who_tells(world) -> None:
    page, _, east, west = await world.joined()
    asked = subscribe(1, "agv")
    page.say(asked)
    # By what was known: its lead has let go of it, and never tells this page.
    assert await east.heard.take() == asked
    await west.say(online("agv"))
    await page.hear(SiteUpdate)
    assert await west.heard.take() == asked
    assert await east.heard.take() == Unsubscribe(sub=1)
    # Once: what a shard tells again changes nothing.
    await west.say(online("agv"))
    await page.hear(SiteUpdate)
    page.say(stop("agv"))
    assert await west.heard.take() == stop("agv")
