"""What is asked about all sites is asked of each shard; who cannot be reached is named."""

# ruff: noqa: D107
from __future__ import annotations

import asyncio
import json
from typing import ClassVar

import httpx
import pytest

from talaia.hub.policy_routes import ROUTES
from talaia.hub.sharding import merged_lists
from talaia.hub.sharding.merged_lists import MergedLists

SHARDS = {"agv": "east", "arm": "west", "lab": "main"}


class SmallHub:
    """The HTTP application of one shard."""

    def __init__(self, name: str) -> None:
        self.name = name
        # By method and path: the status and what is answered.
        self.answers = {}
        self.heard = []
        self.error = None
        self.breaks_off = False

    async def __call__(self, scope, receive, send) -> None:
        if self.error is not None:
            raise self.error
        body = (await receive())["body"]
        route = f"{scope['method']} {scope['path']}"
        self.heard.append((route, scope, body))
        status, said = self.answers.get(route, (404, {"code": "unknown"}))
        headers = [(b"content-type", b"application/json"), (b"content-length", b"7")]
        headers += [(b"x-of", self.name.encode()), (b"cache-control", b"no-store")]
        await send({"type": "http.response.start", "status": status, "headers": headers})
        whole = json.dumps(said).encode() if said is not None else b""
        await send({"type": "http.response.body", "body": whole[:1], "more_body": True})
        if not self.breaks_off:
            await send({"type": "http.response.body", "body": whole[1:]})


class World:
    """Three shards, and who asks them."""

    def __init__(self) -> None:
        self.main, self.east, self.west = map(SmallHub, ("main", "east", "west"))
        self.all = (self.main, self.east, self.west)
        self.lists = MergedLists({hub.name: hub for hub in self.all}, self.shard_of)

    async def shard_of(self, site: str) -> str:
        return SHARDS.get(site, "main")

    async def ask(self, method: str, path: str, **more) -> httpx.Response:
        transport = httpx.ASGITransport(self.lists.serve)
        async with httpx.AsyncClient(transport=transport, base_url="http://hub") as client:
            return await client.request(method, path, **more)

    def have_sites(self) -> None:
        for site, shard in SHARDS.items():
            getattr(self, shard).answers["GET /api/sites"] = 200, [{"site": site}]


@pytest.fixture
def world() -> World:
    return World()


def test_every_route_that_is_merged_is_there() -> None:
    assert not any(MergedLists.takes("HEAD", path) for _, path in ROUTES)
    merged = {route for route in ROUTES if MergedLists.takes(*route)}
    assert {*merged_lists._MERGED, ("POST", "/api/rollouts"), ("POST", "/api/rollouts/stop")} == (
        merged
    )


async def test_each_shard_s_sites_are_in_one_list_with_the_main_shard_s_headers(world) -> None:
    world.have_sites()
    conditional = {"accept-encoding": "gzip", "if-none-match": "x", "range": "bytes=0-1"}
    answer = await world.ask("GET", "/api/sites?a=b", headers={**conditional, "cookie": "talaia=s"})
    assert [site["site"] for site in answer.json()] == ["agv", "arm", "lab"]
    assert (answer.headers["x-of"], answer.headers["cache-control"]) == ("main", "no-store")
    assert int(answer.headers["content-length"]) == len(answer.content)
    assert "x-talaia-missing" not in answer.headers
    for hub in world.all:
        ((_, scope, _),) = hub.heard
        headers = dict(scope["headers"])
        assert (headers[b"cookie"], scope["query_string"]) == (b"talaia=s", b"a=b")
        # A part of an answer, or none, could not be put together.
        assert not {b"accept-encoding", b"if-none-match", b"range"} & set(headers)


@pytest.mark.parametrize("status", [401, 403, 429, 503])
async def test_whom_the_main_shard_refuses_gets_its_answer_and_no_other_is_asked(
    world, status
) -> None:
    world.have_sites()
    world.main.answers["GET /api/sites"] = status, {"code": "no"}
    answer = await world.ask("GET", "/api/sites")
    assert (answer.status_code, answer.json()) == (status, {"code": "no"})
    assert world.east.heard == world.west.heard == []


@pytest.mark.parametrize("fault", ["error", "failure", "status", "part", "slow"])
async def test_a_shard_that_does_not_answer_is_named_and_the_others_are_listed(
    world, fault
) -> None:
    world.have_sites()
    match fault:
        case "error":
            world.east.error = ConnectionError("no hub leads")
        case "failure":
            world.east.error = ValueError("a fault in the program")
        case "status":
            world.east.answers["GET /api/sites"] = 503, {"code": "busy"}
        case "part":
            world.east.breaks_off = True
        case "slow":

            async def wait(*_) -> None:
                await asyncio.Future()

            apps = {"main": world.main, "east": wait, "west": world.west}
            world.lists = MergedLists(apps, soon_s=0.01)
    answer = await world.ask("GET", "/api/sites")
    assert answer.status_code == 200
    assert [site["site"] for site in answer.json()] == ["arm", "lab"]
    assert answer.headers["x-talaia-missing"] == "east"


async def test_a_main_shard_that_cannot_be_reached_is_the_caller_s_to_tell(world) -> None:
    world.main.error = ConnectionError("no hub leads")
    with pytest.raises(ConnectionError, match="no hub leads"):
        await world.ask("GET", "/api/sites")
    world.main.error, world.main.breaks_off = None, True
    with pytest.raises(ConnectionError, match="not answered to the end"):
        await world.ask("GET", "/api/sites")


async def test_metrics_are_given_by_the_shards_of_whose_sites_one_may_have_some(world) -> None:
    for hub in world.all:
        hub.answers["GET /metrics"] = 403, {"code": "forbidden"}
    assert (await world.ask("GET", "/metrics")).status_code == 403
    world.west.answers["GET /metrics"] = 200, {}
    answer = await world.ask("GET", "/metrics")
    assert (answer.status_code, answer.headers["x-of"]) == (200, "west")
    # Nothing is missing that one may have.
    assert "x-talaia-missing" not in answer.headers


async def test_a_request_beyond_any_use_is_refused_before_anybody_is_asked(world) -> None:
    too_long = b"x" * (4 * 1024 * 1024 + 1)
    answer = await world.ask("POST", "/clients/prometheus/read", content=too_long)
    assert (answer.status_code, answer.json()["code"]) == (413, "too_large")
    assert answer.headers["content-type"] == "application/problem+json"
    assert world.main.heard == []


class TestRollouts:
    """A release is handed out at all shards that have sites of it, or at none."""

    ASKED: ClassVar = {"version": "2.0", "sites": ["lab", "agv", "lab2", "arm"], "first": 2}

    @pytest.fixture(autouse=True)
    def _idle(self, world) -> None:
        for hub in world.all:
            self.stand(hub, None)
            hub.answers["POST /api/rollouts"] = (
                201,
                {
                    "version": "2.0",
                    "began_us": 1,
                    "runs": True,
                    "stopped": "",
                    "sites": [{"site": f"of {hub.name}"}],
                },
            )
            hub.answers["POST /api/rollouts/stop"] = 204, None

    def stand(self, hub, rollout) -> None:
        said = {"releases": [], "gateways": [], "rollout": rollout}
        hub.answers["GET /api/releases"] = 200, said

    def asked_of(self, hub, route: str) -> list[bytes]:
        return [body for said, _, body in hub.heard if said == route]

    async def test_each_shard_hands_it_to_its_own_sites_in_their_order(self, world) -> None:
        answer = await world.ask("POST", "/api/rollouts", json=self.ASKED)
        assert answer.status_code == 201
        assert [one["site"] for one in answer.json()["sites"]] == ["of main", "of east", "of west"]
        for hub, sites in ((world.main, ["lab", "lab2"]), (world.east, ["agv"])):
            (body,) = self.asked_of(hub, "POST /api/rollouts")
            assert json.loads(body) == {**self.ASKED, "sites": sites}
        _, scope, body = world.east.heard[-1]
        assert dict(scope["headers"])[b"content-length"] == str(len(body)).encode()

    async def test_one_that_is_refused_anywhere_is_taken_back_everywhere(self, world) -> None:
        world.west.answers["POST /api/rollouts"] = 409, {"code": "refused", "message": "arm: no"}
        answer = await world.ask("POST", "/api/rollouts", json=self.ASKED)
        assert (answer.status_code, answer.json()["message"]) == (409, "arm: no")
        for hub, stops in ((world.main, 1), (world.east, 1), (world.west, 0)):
            assert len(self.asked_of(hub, "POST /api/rollouts/stop")) == stops

    async def test_while_one_is_under_way_anywhere_none_begins(self, world) -> None:
        self.stand(world.west, {"version": "1.0", "runs": True})
        answer = await world.ask("POST", "/api/rollouts", json={**self.ASKED, "sites": ["lab"]})
        assert answer.status_code == 409
        assert "the rollout of 1.0 is under way" in answer.json()["message"]
        assert self.asked_of(world.main, "POST /api/rollouts") == []

    async def test_with_a_shard_away_none_begins(self, world) -> None:
        world.east.error = ConnectionError("no hub leads")
        answer = await world.ask("POST", "/api/rollouts", json=self.ASKED)
        assert (answer.status_code, answer.headers["retry-after"]) == (503, "1")
        assert self.asked_of(world.main, "POST /api/rollouts") == []

    @pytest.mark.parametrize(
        "body", [b"no JSON", b"[]", b'{"sites":[]}', b'{"sites":[1]}', b"[" * 100_000]
    )
    async def test_what_cannot_be_read_is_answered_by_the_main_shard(self, world, body) -> None:
        world.main.answers["POST /api/rollouts"] = 422, {"code": "invalid"}
        answer = await world.ask("POST", "/api/rollouts", content=body)
        assert answer.status_code == 422
        assert self.asked_of(world.main, "POST /api/rollouts") == [body]
        assert world.east.heard == []

    async def test_who_may_not_hears_it_of_the_main_shard(self, world) -> None:
        world.main.answers["GET /api/releases"] = 403, {"code": "forbidden"}
        answer = await world.ask("POST", "/api/rollouts", json={**self.ASKED, "sites": ["agv"]})
        assert answer.status_code == 403
        assert world.east.heard == []

    async def test_it_is_stopped_at_all_shards(self, world) -> None:
        world.main.answers["POST /api/rollouts/stop"] = 409, {"code": "idle"}
        assert (await world.ask("POST", "/api/rollouts/stop")).status_code == 204
        assert all(self.asked_of(hub, "POST /api/rollouts/stop") for hub in world.all)
        for hub in world.all:
            hub.answers["POST /api/rollouts/stop"] = 409, {"code": "idle"}
        answer = await world.ask("POST", "/api/rollouts/stop")
        assert (answer.status_code, answer.json()["code"]) == (409, "idle")

    async def test_who_may_not_stop_it_hears_so_and_one_that_is_away_is_told(self, world) -> None:
        world.east.error = ConnectionError("no hub leads")
        answer = await world.ask("POST", "/api/rollouts/stop")
        assert answer.status_code == 503
        assert "stop it again" in answer.json()["message"]
        # All that can be reached have stopped.
        assert self.asked_of(world.west, "POST /api/rollouts/stop")
        for hub in world.all:
            hub.answers["POST /api/rollouts/stop"] = 403, {"code": "forbidden"}
        assert (await world.ask("POST", "/api/rollouts/stop")).status_code == 403
