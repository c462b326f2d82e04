"""Parameters of the robot's nodes, read and set by Foxglove's and rosbridge's clients."""

from __future__ import annotations

import json

import pytest

from talaia.hub.auth.permissions import Grants, Permission, Right
from talaia.hub.clients.account_offer import make_account_offer
from talaia.hub.clients.robot_parameters import make_robot_parameters
from talaia.model.yaml_text.load import load_site
from talaia.wire import frames
from talaia.wire.browser import SiteUpdate, Subscribe, Values
from talaia.wire.frames import CommandPhase

from ..everyone.world import NOW
from .foxglove.foxglove_peer import NodeClient, client_of
from .robot_commands import answer, asked_of
from .robot_parameters_site import KNOWN, NAMES, SITE, VALUES
from .rosbridge.page_with_roslib import connected_page, serve_page
from .rosbridge.rosbridge_peer import RawClient, RoslibpyClient, address_of
from .tokens import open_protocol, token_of

PAGE = """
function get(name) {
  const one = new ROSLIB.Param({ros, name});
  return new Promise((good, bad) => one.get(good, (why) => bad(Error(why))));
}
function set(name, value) {
  const one = new ROSLIB.Param({ros, name});
  return new Promise((good, bad) => one.set(value, good, (why) => bad(Error(why))));
}
"""


@pytest.fixture
async def gateway(world):
    """A gateway that has read all parameters but one."""
    await world.gateways["agv"].close()
    gateway = await world.connect("agv", SITE)
    await gateway.samples(*((f"base/{name}", NOW + 1, value) for name, value in VALUES.items()))
    # Told to a page once the hub knows it.
    page = await world.page("operator")
    await page.say(Subscribe(sub=1, site="agv", channels=["base/offsets"], every_ms=0))
    await page.hear(Values)
    await page.close()
    return gateway


async def roslibpy_client(world, name):
    await open_protocol(world.hub, "rosbridge")
    return await RoslibpyClient().connect(world.hub, "agv", await token_of(world.hub, name))


@pytest.mark.parametrize("name", NAMES)
async def test_rosapi_lists_parameters_as_ros_2_names_them_for_who_may_see_them(
    world, gateway, name
) -> None:
    async with await roslibpy_client(world, name) as client:
        await client.say("get_params")
        found = {one for one in await client.hear("found") if one.startswith(("/peer", "/fuse"))}
        expected = {f"/peer:{one}" for one in NAMES[name]}
        # One that can only be set is there for who may set it.
        assert found == expected | ({"/fuse:cut"} if name == "admin" else set())


async def test_roslibpy_reads_parameters_by_any_of_their_names_and_nothing_that_is_not_known(
    world, gateway
) -> None:
    async with await roslibpy_client(world, "driver") as client:
        for name, value in KNOWN.items():
            for written in (f"/peer:{name}", f"peer:{name}", f"/peer/{name}", f"/peer.{name}"):
                await client.say("get_param", written)
                found = await client.hear("found")
                assert (type(found), found) == (type(value), value), written
        for name in ("/peer:shown", "/fuse:cut", "/nothing"):
            await client.say("get_param", name)
            assert await client.hear("found") == ""


async def test_setting_by_rosapi_is_a_command_and_answered_when_it_has_ended(
    world, gateway
) -> None:
    await open_protocol(world.hub, "rosbridge")
    client = await RawClient().connect(
        address_of(world.hub, "agv", await token_of(world.hub, "driver"))
    )
    for name, value, expected in (
        ("/peer:gain", 3, ("gain", {"value": 3.0})),
        ("/peer/motor.steps", 9, ("steps", {"value": 9})),
        ("peer.lamp", True, ("lamp_on", {})),
        ("/peer:offsets", [1, 2.5], ("offsets", {"value": "[1, 2.5]"})),
    ):
        args = {"name": name, "value": json.dumps(value)}
        await client.say("call_service", service="/rosapi/set_param", id=name, args=args)
        asked, said = await asked_of(gateway)
        assert said == ("driver", "base", *expected)
        await answer(gateway, asked, message="set")
        found = await client.hear("service_response", lambda said, name=name: said["id"] == name)
        assert (found["result"], found["values"]) == (True, {"successful": True, "reason": "set"})
    for name, value, why in (
        ("/peer:gain", "11", "11.0 is above 10"),
        ("/peer:gain", '"a"', "gain: expected a number, found 'a'"),
        ("/peer:gain", "{", "not JSON"),
        ("/peer:lamp", "false", "lamp can only be true here, not false"),
        # Together with another it is set by a command alone.
        ("/peer:mode", '"fast"', "no command of yours sets it alone"),
        ("/peer:shown", "1", "no command of yours sets it alone"),
        ("/fuse:cut", "true", "there is no parameter /fuse:cut"),
        ("/site", '"b"', "/site is of the description and cannot be set"),
    ):
        found = await client.call("/rosapi/set_param", {"name": name, "value": value})
        assert found["result"] is False
        assert why in found["values"], found
    found = await client.call("/rosapi/delete_param", {"name": "/peer:gain"})
    assert found["result"] is False
    await client.close()
    assert not [one for one in gateway.heard if isinstance(one, frames.CommandRequest)]


async def test_page_with_roslib_reads_and_sets_a_parameter(
    chromium, world, gateway, tmp_path
) -> None:
    with serve_page(tmp_path, PAGE) as origin:
        await open_protocol(world.hub, "rosbridge", origin)
        page = await connected_page(chromium, world, origin, "driver")
        assert await page.evaluate("get('/peer:gain')") == 1.5
        await page.evaluate("void (window.done = set('/peer:gain', 2.5))")
        asked, said = await asked_of(gateway)
        assert said == ("driver", "base", "gain", {"value": 2.5})
        await answer(gateway, asked, CommandPhase.FAILED, "the node refuses it")
        assert "the node refuses it" in await page.evaluate("done.catch((why) => String(why))")
        guest = await connected_page(chromium, world, origin, "guest")
        for name in ("/peer:gain", "/fuse:cut"):
            refused = f"set('{name}', 1).catch((why) => String(why))"
            assert "there is no parameter" in await guest.evaluate(refused)
            assert "no parameter" in await guest.evaluate(
                f"get('{name}').catch((why) => String(why))"
            )


def values_of(said, prefix="/peer."):
    return {
        one["name"].removeprefix(prefix): one["value"]
        for one in said["parameters"]
        if one["name"].startswith(prefix)
    }


async def test_npm_foxglove_client_reads_follows_and_sets_parameters(world, gateway) -> None:
    async with await client_of(world, "driver", kind=NodeClient) as client:
        await client.call("getParameters", [], "all")
        said = await client.hear("parameterValues", lambda said: said.get("id") == "all")
        assert values_of(said) == KNOWN
        kinds = {one["name"]: one.get("type") for one in said["parameters"]}
        assert (kinds["/peer.gain"], kinds["/peer.offsets"]) == ("float64", "float64_array")
        assert kinds["/peer.motor.steps"] is None

        await client.call("subscribeParameterUpdates", ["/peer.gain", "/peer.shown"])
        said = await client.hear("parameterValues", lambda said: "id" not in said)
        assert values_of(said) == {"gain": 1.5}
        await gateway.samples(("base/mode", NOW + 2, "quick"), ("base/shown", NOW + 2, 4.0))
        said = await client.hear("parameterValues", lambda said: "id" not in said)
        assert values_of(said) == {"shown": 4.0}

        wishes = [
            {"name": "/peer.gain", "value": 3, "type": "float64"},
            {"name": "/peer.motor.steps", "value": "a"},
            {"name": "/fuse.cut", "value": True},
            {"name": "/site", "value": "b"},
        ]
        await client.call("setParameters", wishes, "set")
        asked, said = await asked_of(gateway)
        assert said == ("driver", "base", "gain", {"value": 3.0})
        for why in (
            "/peer.motor.steps: motor.steps: expected a whole number, found 'a'",
            "/fuse.cut: there is no such parameter",
            "/site: it is of the description and cannot be set",
        ):
            await client.hear("status", lambda said, why=why: said["message"] == why)
        await answer(gateway, asked)
        said = await client.hear("parameterValues", lambda said: said.get("id") == "set")
        # What was set is told before the robot is asked again.
        assert values_of(said) == {"gain": 3, "motor.steps": 7}

        await client.call("setParameters", [{"name": "/peer.gain", "value": 4}], "again")
        asked, _ = await asked_of(gateway)
        await answer(gateway, asked, CommandPhase.REFUSED, "it rains")
        await client.hear("status", lambda said: said["message"] == "/peer.gain: refused: it rains")
        said = await client.hear("parameterValues", lambda said: said.get("id") == "again")
        assert values_of(said) == {"gain": 1.5}


async def test_guest_of_foxglove_sees_and_sets_no_parameter_that_is_not_public(
    world, gateway
) -> None:
    client = await client_of(world, "guest")
    names = [f"/peer.{name}" for name in KNOWN]
    await client.say({"op": "subscribeParameterUpdates", "parameterNames": []})
    await client.say({"op": "getParameters", "parameterNames": names, "id": "some"})
    wishes = [{"name": name, "value": 1} for name in (*names, "/peer.shown", "/fuse.cut")]
    await client.say({"op": "setParameters", "parameters": wishes, "id": "set"})
    await gateway.samples(("base/gain", NOW + 2, 777.0), ("base/shown", NOW + 2, 4.0))
    await client.hear("parameterValues", lambda said: values_of(said) == {"shown": 4.0})
    await client.hear("parameterValues", lambda said: said.get("id") == "set")
    assert "777" not in "".join(frame for frame in client.frames if isinstance(frame, str))
    await client.close()
    assert not [one for one in gateway.heard if isinstance(one, frames.CommandRequest)]


async def test_parameter_of_a_robot_that_is_away_is_not_told(world, gateway) -> None:
    async with await client_of(world, "driver", kind=NodeClient) as client:
        await gateway.close()
        # Told to pages as it happens.
        page = await world.page("operator")
        await page.hear(SiteUpdate, lambda said: said.site == "agv" and not said.online)
        await page.close()
        await client.call("getParameters", ["/peer.gain", "/site"], "away")
        said = await client.hear("parameterValues", lambda said: said.get("id") == "away")
        assert said["parameters"] == [{"name": "/site", "value": "agv"}]


TWO_ROBOTS = """
talaia: 1
site: agv
name: Agv
connections: {first: {kind: ros2}, second: {kind: ros1}, third: {kind: ros1}}
devices:
  base:
    name: Base
    connection: first
    signals: {gain: {name: Gain, source: {parameter: /peer/gain}}}
  arm:
    name: Arm
    connection: second
    signals:
      gain: {name: Gain, source: {parameter: /peer/gain}}
      reach: {name: Reach, source: {parameter: /peer/reach}}
"""


def test_parameter_that_two_robots_have_is_neither_and_ros_1_names_its_own_by_slashes() -> None:
    site = load_site(TWO_ROBOTS)
    account = make_account_offer(site, Grants(frozenset({Permission(Right.VIEW)})))
    found = make_robot_parameters(site, account)
    assert set(found.listed(":")) == set(found.listed(".")) == {"/peer/reach"}
    assert found.find("/peer:gain") is None
