"""Commands that take long, as ROS actions of PyPI's roslibpy and of npm's roslib in Chromium."""

from __future__ import annotations

import pytest

from talaia.wire import frames
from talaia.wire.frames import CommandPhase

from ..tokens import open_protocol, token_of
from .page_with_roslib import connected_page, serve_page
from .rosbridge_peer import RoslibpyClient

SITE = """
talaia: 1
site: agv
name: Agv
ros2: {}
devices:
  base:
    name: Base
    visibility: public
    signals: {}
    commands:
      turn: {name: Turn, target: /turn, type: std_srvs/srv/Trigger}
      count:
        name: Count
        kind: action
        target: /count
        type: test_msgs/action/Fibonacci
        arguments: {order: {name: Order, type: integer, field: order}}
"""
NAME = "/talaia/base/count"
PAGE = f"""
const action = new ROSLIB.Action({{ros, name: "{NAME}", actionType: "talaia/action/base_count"}});
function send(order) {{
  return action.sendGoal(
    {{order}},
    (found) => told.push(["result", found]),
    (found) => told.push(["feedback", found]),
    (why) => told.push(["failed", why]),
  );
}}
"""


class RoslibpyGoals:
    """What of roslibpy's `ActionClient` is tried here."""

    def __init__(self, client) -> None:
        """Go by a client that is connected."""
        self._client = client

    async def send(self, order: int) -> None:
        await self._client.say("goal", NAME, "talaia/action/base_count", {"order": order})
        self._goal = await self._client.hear("sent")

    async def cancel(self) -> None:
        await self._client.say("cancel", NAME, self._goal)

    async def feedback(self):
        return await self._client.hear("feedback")

    async def result(self):
        found = await self._client.hear("result")
        # GoalStatus.SUCCEEDED of action_msgs.
        assert found["status"] == 4
        return found["values"]

    async def failure(self) -> str:
        return str(await self._client.hear("failed"))


class RoslibGoals:
    """What of roslib's `Action` is tried here."""

    def __init__(self, page) -> None:
        """Go by a page that is connected."""
        self._page = page

    async def send(self, order: int) -> None:
        self._goal = await self._page.evaluate("send", order)

    async def cancel(self) -> None:
        await self._page.evaluate("(goal) => action.cancelGoal(goal)", self._goal)

    async def feedback(self):
        return await self._heard("feedback")

    async def result(self):
        return await self._heard("result")

    async def failure(self) -> str:
        return await self._heard("failed")

    async def _heard(self, name):
        found = await self._page.wait_for_function(
            "(name) => { const at = told.findIndex(([event]) => event === name);"
            " return at < 0 ? false : told.splice(at, 1); }",
            arg=name,
        )
        return (await found.json_value())[0][1]


@pytest.fixture
async def counting(world):
    """The world with a site that has an action."""
    await world.gateways["agv"].close()
    await world.connect("agv", SITE)
    return world


async def try_goals(gateway, goals) -> None:
    async def answer(asked, phase, *, message="", progress=0.0) -> None:
        await gateway.say(
            frames.CommandState(
                id=asked.id,
                device="base",
                command="count",
                phase=phase,
                message=message,
                progress=progress,
            )
        )

    await goals.send(7)
    asked = await gateway.hear(frames.CommandRequest)
    assert (asked.device, asked.command, asked.args) == ("base", "count", {"order": 7})
    await answer(asked, CommandPhase.ACCEPTED)
    await answer(asked, CommandPhase.RUNNING, message="half", progress=0.5)
    while (feedback := await goals.feedback()) != {"progress": 0.5, "message": "half"}:
        assert feedback["progress"] == 0
    await answer(asked, CommandPhase.SUCCEEDED, message="counted")
    assert await goals.result() == {"success": True, "message": "counted"}

    await goals.send(8)
    asked = await gateway.hear(frames.CommandRequest)
    await answer(asked, CommandPhase.RUNNING)
    await goals.cancel()
    cancelled = await gateway.hear(frames.CommandCancel)
    assert (cancelled.id, cancelled.device) == (asked.id, "base")
    await answer(asked, CommandPhase.CANCELLED, message="as was asked")
    assert "as was asked" in await goals.failure()

    await goals.send(9)
    asked = await gateway.hear(frames.CommandRequest)
    await answer(asked, CommandPhase.FAILED, message="jammed")
    assert "jammed" in await goals.failure()


async def test_roslibpy_sends_follows_and_cancels_goals(counting) -> None:
    await open_protocol(counting.hub, "rosbridge")
    token = await token_of(counting.hub, "driver")
    async with await RoslibpyClient().connect(counting.hub, "agv", token) as client:
        await client.say("get_services")
        assert NAME in await client.hear("found")
        await client.say("action_servers")
        assert await client.hear("servers") == [NAME, "/count"]
        await try_goals(counting.gateways["agv"], RoslibpyGoals(client))


async def test_page_sends_follows_and_cancels_goals(chromium, counting, tmp_path) -> None:
    with serve_page(tmp_path, PAGE) as origin:
        await open_protocol(counting.hub, "rosbridge", origin)
        page = await connected_page(chromium, counting, origin, "driver")
        await try_goals(counting.gateways["agv"], RoslibGoals(page))


async def test_goal_of_who_may_not_or_of_what_is_no_action_reaches_no_robot(counting) -> None:
    await open_protocol(counting.hub, "rosbridge")
    gateway = counting.gateways["agv"]
    for name, action in (("guest", NAME), ("driver", "/talaia/base/turn"), ("driver", "/nothing")):
        token = await token_of(counting.hub, name)
        async with await RoslibpyClient().connect(counting.hub, "agv", token) as client:
            await client.say("goal", action, "talaia/action/base_count", {"order": 1})
            assert f"there is no action {action}" in str(await client.hear("failed"))
            await client.say("cancel", action, "another's")
            await client.say("get_nodes")
            await client.hear("found")
    asked = (frames.CommandRequest, frames.CommandCancel)
    assert not [message for message in gateway.heard if isinstance(message, asked)]
