"""Meshes by the robot's gateway: once over its line, to whom they are open, whatever it does."""

from __future__ import annotations

import asyncio

import pytest
from patience import PATIENCE_S, until_answered

from talaia.hub.live.assets.robot_assets import AssetTimes
from talaia.wire.frames import MAX_ASSET, AssetState

from ...mesh_gateway import DESCRIBED, MODEL_TOPIC, SHUT, MeshGateway, digest_of

HAND, FOOT = "package://arm/hand.stl", "package://arm/foot.stl"
MESH, OTHER = b"solid hand\n" * 300, b"solid foot\n" * 300
ASSETS = "/api/sites/agv/assets"


@pytest.fixture
async def robot(hub):
    robot = MeshGateway(hub, {HAND: MESH, FOOT: OTHER})
    await robot.open()
    yield robot
    await robot.close()


async def get(hub, uri: str, name: str = "operator", **more):
    client = await hub.client(name)
    return await client.get(ASSETS, params={"uri": uri}, **more)


def hurry(hub, *, state: float = PATIENCE_S, file: float = PATIENCE_S) -> None:
    """Wait for a gateway less long than for a real one."""
    hub.hub.taps.assets.times = AssetTimes(state, file)


async def test_mesh_crosses_the_line_once_for_all_who_look_at_it(hub, robot) -> None:
    first, second = await asyncio.gather(get(hub, HAND), get(hub, HAND, "admin"))
    assert (first.status_code, first.content) == (200, MESH)
    assert second.content == MESH
    assert first.headers["etag"] == f'"{digest_of(MESH)}"'
    assert robot.asked == [(HAND, False), (HAND, True)]
    again = await get(hub, HAND, headers={"If-None-Match": first.headers["etag"]})
    assert (again.status_code, again.content) == (304, b"")
    # Not even a question.
    assert len(robot.asked) == 2


async def test_same_content_under_another_name_is_not_sent_again(hub, robot) -> None:
    await get(hub, HAND)
    robot.files[FOOT] = MESH
    pieces = robot.pieces
    assert (await get(hub, FOOT)).content == MESH
    assert (robot.asked[-1], robot.pieces) == ((FOOT, False), pieces)


async def test_changed_mesh_is_noticed_when_the_description_comes_anew(hub, robot) -> None:
    assert (await get(hub, HAND)).content == MESH
    follower = await hub.follower("operator", MODEL_TOPIC, "&as=bytes")
    await robot.publish_model("<robot/>")
    robot.files[HAND] = OTHER

    async def is_new() -> bool:
        return (await get(hub, HAND)).content == OTHER

    # The description and the question come by two connections: what counts is the end.
    await until_answered(is_new)
    await follower.close()


async def test_changed_mesh_is_noticed_with_the_next_link_and_what_is_the_same_is_not_sent(
    hub, robot
) -> None:
    assert (await get(hub, HAND)).content == MESH
    assert (await get(hub, FOOT)).content == OTHER
    await robot.close()
    robot.files[HAND] = OTHER + MESH
    robot.asked.clear()
    await robot.open()
    assert (await get(hub, HAND)).content == OTHER + MESH
    assert (await get(hub, FOOT)).content == OTHER
    assert robot.asked == [(HAND, False), (HAND, True), (FOOT, False)]


async def test_copy_is_served_while_the_robot_is_away(hub, robot) -> None:
    assert (await get(hub, HAND)).content == MESH
    await robot.close()
    assert (await get(hub, HAND)).content == MESH
    missing = await get(hub, FOOT)
    assert missing.status_code == 404
    assert "is not connected" in missing.json()["message"]


async def test_gateway_of_before_is_asked_for_nothing_and_the_answer_says_what_to_do(hub) -> None:
    robot = MeshGateway(hub, {HAND: MESH})
    await robot.open(takes=False)
    answer = await get(hub, HAND)
    assert answer.status_code == 404
    assert "--assets" in answer.json()["message"]
    assert robot.asked == []
    await robot.close()


async def test_what_the_gateway_says_of_a_missing_mesh_is_said(hub, robot) -> None:
    answer = await get(hub, "package://arm/none.stl")
    assert (answer.status_code, answer.json()["message"]) == (404, "it is not there")
    # Nothing is remembered: it may be there the next time.
    robot.files["package://arm/none.stl"] = MESH
    assert (await get(hub, "package://arm/none.stl")).content == MESH


@pytest.mark.parametrize(
    ("description", "allowed"),
    [(DESCRIBED, {"operator", "admin"}), (SHUT, {"admin"})],
    ids=["open", "shut"],
)
async def test_mesh_is_for_those_who_may_have_the_robots_description(
    hub, description, allowed
) -> None:
    robot = MeshGateway(hub, {HAND: MESH})
    await robot.open(description)
    for name in ("guest", "operator", "admin"):
        answer = await get(hub, HAND, name)
        assert (answer.status_code == 200) is (name in allowed), name
        if name not in allowed:
            assert answer.json()["message"] == "there is no such file"
    assert (await (await hub.client()).get(ASSETS, params={"uri": HAND})).status_code == 401
    await robot.close()


@pytest.mark.parametrize(
    "uri",
    ["package://arm/keys.pem", "package://arm/../x.stl", "http://arm/x.stl", "file:///etc/passwd"],
)
async def test_what_is_no_mesh_is_not_even_asked_for(hub, robot, uri) -> None:
    robot.files[uri] = b"secret"
    assert (await get(hub, uri, "admin")).status_code == 404
    assert robot.asked == []


# ── gateways as none should be ──


async def test_file_that_is_not_what_its_digest_says_is_not_kept(hub, robot) -> None:
    robot.sent[HAND] = MESH[:-1] + b"!"
    answer = await get(hub, HAND)
    assert answer.status_code == 404
    assert "damaged" in answer.json()["message"]
    assert not hub.hub.taps.assets.cache.has_file("agv", digest_of(MESH))
    robot.sent.clear()
    assert (await get(hub, HAND)).content == MESH


async def test_gateway_that_goes_away_in_the_middle_is_waited_for_by_nobody(hub, robot) -> None:
    robot.cut_after = 2
    asking = asyncio.create_task(get(hub, HAND))

    async def has_begun() -> bool:
        return robot.pieces == 2

    await until_answered(has_begun)
    await robot.close()
    answer = await asking
    assert answer.status_code == 404
    assert "was lost" in answer.json()["message"]
    # What has come is gone on with.
    robot.cut_after, robot.pieces = 10**9, 0
    await robot.open()
    assert (await get(hub, HAND)).content == MESH
    assert robot.pieces == 2


async def test_gateway_that_never_answers_or_never_sends_is_not_waited_for_without_end(
    hub, robot
) -> None:
    hurry(hub, state=0.1, file=0.1)
    robot.answers = False
    assert "does not answer" in (await get(hub, HAND)).json()["message"]
    robot.answers = True
    robot.cut_after = 0
    hurry(hub, file=0.1)
    assert "in time" in (await get(hub, HAND)).json()["message"]


async def test_file_that_nobody_has_asked_for_is_refused(hub, robot) -> None:
    said = await robot.send_file(MESH, digest_of(MESH))
    assert (said.refused, robot.pieces) == ("nobody asks for it", 0)


async def test_file_that_is_larger_than_any_may_be_is_refused_at_once(hub, robot) -> None:
    robot.answers = False
    asking = asyncio.create_task(get(hub, HAND))
    await robot.until_asked(1)
    await robot.link.say(AssetState(uri=HAND, size=5, digest=digest_of(MESH)))
    await robot.until_asked(2)
    await robot.link.say(AssetState(uri=HAND, size=5, digest=digest_of(MESH)))
    said = await robot.send_file(MESH, digest_of(MESH), size=MAX_ASSET + 1)
    assert "more than" in said.refused
    assert "more than" in (await asking).json()["message"]


async def test_states_that_nobody_has_asked_for_change_nothing(hub, robot) -> None:
    for number in range(100):
        await robot.link.say(AssetState(uri=f"package://arm/{number}.stl", digest=digest_of(MESH)))
    assert (await get(hub, HAND)).content == MESH
