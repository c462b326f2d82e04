"""The page of `talaia init --web`: who gets in, what it says, and that it ends."""

from __future__ import annotations

import asyncio
import http.client
import json
from typing import NamedTuple

from described_robot import found_of, read_robot

from talaia.cli.init_page.questions import questions_of
from talaia.cli.init_page.server import InitPage, serve_page
from talaia.model.discovery.generate_description import propose_description
from talaia.model.discovery.rules.proposal_answers import ProposalAnswers

MADE = propose_description(found_of(read_robot("chosen", "mecanum")), "fork", "Fork", "UTC")


class Told(NamedTuple):
    """An answer."""

    status: int
    headers: dict[str, str]
    body: bytes


class Visit:
    """A page that is served, and one who asks it."""

    def __init__(self, problems: list[str] | None = None) -> None:  # noqa: D107
        self.given: list[ProposalAnswers] = []
        self.problems = problems or []
        self.address: asyncio.Future[str] = asyncio.get_running_loop().create_future()
        questions = questions_of(MADE, "site.yaml")
        self.page = InitPage(
            questions, lambda: {"base/speed": 0.5}, {"front/view": b"jpeg"}.get, self.finish
        )
        self.served = asyncio.ensure_future(serve_page(self.page, self.address.set_result))
        self.cookie = ""

    def finish(self, answers: ProposalAnswers) -> list[str]:
        self.given.append(answers)
        return self.problems

    async def ask(self, path: str, body: object = None, **changed: str) -> Told:
        """Ask once, with the cookie."""
        host = (await self.address).split("/")[2]
        sent = {"Host": host, "Origin": f"http://{host}", "Content-Type": "application/json"}
        sent |= {"Cookie": self.cookie}
        sent |= {key.replace("_", "-").title(): value for key, value in changed.items()}

        def talk() -> Told:
            line = http.client.HTTPConnection("127.0.0.1", int(host.rpartition(":")[2]), timeout=20)
            with_body = None if body is None else json.dumps(body)
            line.request("GET" if body is None else "POST", path, with_body, sent)
            answer = line.getresponse()
            told = Told(
                answer.status, {k.lower(): v for k, v in answer.getheaders()}, answer.read()
            )
            line.close()
            return told

        return await asyncio.to_thread(talk)

    async def enter(self) -> Told:
        """Open the address that was printed."""
        told = await self.ask("/?" + (await self.address).partition("?")[2])
        self.cookie = told.headers.get("set-cookie", "").partition(";")[0]
        return told


async def test_the_address_is_good_once_and_what_it_gives_opens_all_the_rest() -> None:
    visit = Visit()
    assert (await visit.ask("/questions")).status == 403
    assert (await visit.ask("/pictures/front/view")).status == 403
    told = await visit.enter()
    assert (told.status, told.headers["location"]) == (303, "/")
    assert "HttpOnly" in told.headers["set-cookie"]
    assert "SameSite=Strict" in told.headers["set-cookie"]
    assert json.loads((await visit.ask("/questions")).body)["name"] == "Fork"
    assert json.loads((await visit.ask("/values")).body) == {"base/speed": 0.5}
    picture = await visit.ask("/pictures/front/view")
    assert (picture.status, picture.headers["content-type"]) == (200, "image/jpeg")
    # There may be one later.
    assert (await visit.ask("/pictures/rear/view")).status == 204
    assert (await visit.ask("/?" + (await visit.address).partition("?")[2])).status == 403
    visit.served.cancel()


async def test_another_page_and_another_hosts_name_are_refused() -> None:
    visit = Visit()
    await visit.enter()
    assert (await visit.ask("/", host="evil.example")).status == 421
    assert (await visit.ask("/answers", {}, origin="http://evil.example")).status == 403
    assert (await visit.ask("/answers", {}, content_type="text/plain")).status == 403
    assert visit.given == []
    policy = (await visit.ask("/")).headers["content-security-policy"]
    assert "default-src 'none'" in policy
    visit.served.cancel()


async def test_it_ends_when_it_is_answered() -> None:
    visit = Visit()
    await visit.enter()
    answers = {"unwanted": ["power"], "names": {"base": "Chassis"}, "stop_topic": "/e_stop"}
    assert (await visit.ask("/answers", answers)).status == 200
    await asyncio.wait_for(visit.served, 20)
    (given,) = visit.given
    assert (given.unwanted, given.stop_topic) == (frozenset({"power"}), "/e_stop")


async def test_what_is_wrong_is_told_and_it_goes_on() -> None:
    visit = Visit(["$.devices.base.name: expected a name"])
    await visit.enter()
    told = await visit.ask("/answers", {})
    assert (told.status, json.loads(told.body)["problems"]) == (422, visit.problems)
    assert (await visit.ask("/answers", {"unknown": 1})).status == 400
    assert not visit.served.done()
    visit.served.cancel()


def test_each_device_is_asked_for_with_its_values_and_stop_is_asked_and_not_assumed() -> None:
    asked = json.loads(questions_of(MADE, "site.yaml"))
    base = next(device for device in asked["devices"] if device["id"] == "base")
    assert base["drive"] == "/cmd_vel, at most 0.2 m/s, 0.2 m/s sideways, 0.5 rad/s"
    speed = next(signal for signal in base["signals"] if signal["id"] == "speed")
    assert (speed["unit"], speed["channels"]) == ("m/s", ["base/speed"])
    (topic,) = asked["topics"]
    assert (topic["id"], "`true`" in topic["question"]) == ("/e_stop", True)
    assert [signal["id"] for signal in asked["signals"]] == ["base/speed", "base/turn_rate"]
