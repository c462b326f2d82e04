"""A site whose commands have names on the robot, and a gateway's answers to them."""

from __future__ import annotations

from talaia.hub.auth.tokens import new_token
from talaia.wire import frames
from talaia.wire.browser import PageCommand
from talaia.wire.frames import CommandPhase

SITE = """
talaia: 1
site: agv
name: Agv
ros2: {}
devices:
  base:
    name: Base
    visibility: public
    drive: {topic: /cmd_vel, max_speed: 1, max_turn: 1}
    commands:
      add:
        name: Add
        target: /add_two_ints
        type: example_interfaces/srv/AddTwoInts
        arguments: {a: {type: integer, field: a}, b: {type: integer, field: b}}
      light: {name: Light, target: /light, type: std_srvs/srv/SetBool, fixed: {data: true}}
      horn:
        name: Horn
        kind: topic
        target: /horn
        type: std_msgs/msg/String
        arguments: {words: {type: text, field: data}}
      goal:
        name: Goal
        kind: topic
        target: /goal_pose
        type: geometry_msgs/msg/PoseStamped
        fixed: {header.frame_id: map}
        arguments:
          x: {type: number, field: pose.position.x}
          y: {type: number, field: pose.position.y}
      count:
        name: Count
        kind: action
        target: /count
        type: test_msgs/action/Fibonacci
        arguments: {order: {type: integer, field: order}}
  power:
    name: Power
    visibility: view
    commands:
      cut: {name: Cut, target: /cut, type: std_srvs/srv/Trigger}
"""
# Written by hand: what each may call and publish by the robot's names.
SERVICES = {
    "guest": set(),
    "driver": {"/add_two_ints", "/light", "/count"},
    "admin": {"/add_two_ints", "/light", "/count", "/cut"},
}
TOPICS = {"guest": set(), "driver": {"/horn", "/goal_pose"}, "admin": {"/horn", "/goal_pose"}}
ADD = "example_interfaces/srv/AddTwoInts"


async def begin_site(world):
    """Put the site in the place of the world's."""
    await world.gateways["agv"].close()
    return await world.connect("agv", SITE)


async def asked_of(gateway):
    """Give the next command that reaches the gateway."""
    asked = await gateway.hear(frames.CommandRequest)
    return asked, (asked.who, asked.device, asked.command, asked.args)


async def answer(gateway, asked, phase=CommandPhase.SUCCEEDED, message="done", **more) -> None:
    state = frames.CommandState(
        id=asked.id,
        device=asked.device,
        command=asked.command,
        phase=phase,
        message=message,
        **more,
    )
    await gateway.say(state)


async def commands_sent(world, gateway) -> list:
    """Give the commands that reached the gateway until now and were not asked for above."""
    page, mark = await world.page("operator"), f"mark-{new_token()}"
    args = {"a": 1, "b": 1}
    await page.say(PageCommand(site="agv", device="base", command="add", id=mark, args=args))
    # What was asked before it is there before it.
    await gateway.hear(frames.CommandRequest, lambda asked: asked.id == mark)
    await page.close()
    return [message for message in gateway.heard if isinstance(message, frames.CommandRequest)]
