"""A page of somebody else with npm's roslib, unchanged, in Chromium: guest, driver, admin."""

from __future__ import annotations

import asyncio

import pytest

from talaia.wire import frames
from talaia.wire.browser import PageCommand
from talaia.wire.frames import CommandPhase, LeaseOp

from ...everyone.world import NOW
from ..sent_messages import sent_for
from ..tokens import open_protocol
from .page_with_roslib import connected_page, open_page, serve_page

PAGE = """
function subscribe(name, messageType, compression) {
  const topic = new ROSLIB.Topic({ros, name, messageType, compression});
  topic.subscribe((message) => told.push([name, message]));
}
function subscribeAs(fields) {
  // What `Topic` has no option for is asked for by the message itself.
  ros.on(fields.topic, (message) => told.push([fields.topic, message.msg]));
  ros.callOnConnection({op: "subscribe", ...fields});
}
function param(name) {
  const one = new ROSLIB.Param({ros, name});
  return new Promise((good, bad) => one.get(good, (why) => bad(Error(why))));
}
function call(name) {
  const service = new ROSLIB.Service({ros, name, serviceType: "std_srvs/Trigger"});
  return new Promise((good, bad) => service.callService({}, good, (why) => bad(Error(why))));
}
function list() {
  return new Promise((good, bad) => ros.getTopics((found) => good(found.topics), bad));
}
function drive(linear) {
  const topic = new ROSLIB.Topic({ros, name: "/v", messageType: "geometry_msgs/Twist"});
  const zero = {x: 0, y: 0, z: 0};
  setInterval(() => topic.publish({linear: {...zero, x: linear}, angular: zero}), 50);
}
async function everything(devices) {
  const zero = {x: 0, y: 0, z: 0};
  for (const name of ["/v", ...devices.map((device) => `/talaia/${device}/drive`)]) {
    const topic = new ROSLIB.Topic({ros, name, messageType: "geometry_msgs/Twist"});
    topic.publish({linear: {...zero, x: 1}, angular: zero});
  }
  for (const device of devices) {
    void call(`/talaia/${device}/turn`).catch(() => undefined);
    void call(`/talaia/${device}/drive/stop`).catch(() => undefined);
  }
  // Answered after all of it.
  await list();
}
"""
HEARD = "([name, value]) => told.some((each) => each[0] === name && each[1]?.data === value)"


@pytest.fixture(scope="module")
def origin(tmp_path_factory):
    """Where the page is served from, which is not the hub."""
    with serve_page(tmp_path_factory.mktemp("page"), PAGE) as origin:
        yield origin


async def test_page_that_an_admin_has_not_named_gets_no_connection(chromium, world, origin) -> None:
    await open_protocol(world.hub, "rosbridge", "https://another.example")
    page = await open_page(chromium, world, origin, "admin")
    await page.wait_for_function("told.some(([event]) => event === 'close')")
    assert not await page.evaluate("ros.isConnected")


async def test_page_lists_subscribes_and_calls_with_the_rights_of_its_token(
    chromium,
    world,
    origin,
) -> None:
    await open_protocol(world.hub, "rosbridge", origin)
    gateway = world.gateways["agv"]
    guest = await connected_page(chromium, world, origin, "guest")
    assert await guest.evaluate("list()") == ["/talaia/base/open"]
    driver = await connected_page(chromium, world, origin, "driver")
    assert "/talaia/base/shut" in await driver.evaluate("list()")
    admin = await connected_page(chromium, world, origin, "admin")
    for page, compression in ((guest, "none"), (driver, "cbor"), (admin, "cbor")):
        for name in ("open", "shut"):
            words = [f"/talaia/base/{name}", "std_msgs/Float64", compression]
            await page.evaluate("(words) => subscribe(...words)", words)
        # Answered after both.
        await page.evaluate("list()")
    await gateway.samples(("base/shut", NOW + 1, 0.25), ("base/open", NOW + 1, 0.5))
    for page in (driver, admin):
        await page.wait_for_function(HEARD, arg=["/talaia/base/shut", 0.25])
    for page in (guest, driver, admin):
        await page.wait_for_function(HEARD, arg=["/talaia/base/open", 0.5])
    assert not await guest.evaluate(HEARD, ["/talaia/base/shut", 0.25])

    called = asyncio.create_task(driver.evaluate("call('/talaia/base/turn')"))
    asked = await gateway.hear(frames.CommandRequest)
    assert (asked.device, asked.command, asked.who) == ("base", "turn", "driver")
    await gateway.say(
        frames.CommandState(
            id=asked.id,
            device="base",
            command="turn",
            phase=CommandPhase.SUCCEEDED,
            message="turned",
        )
    )
    assert await called == {"success": True, "message": "turned"}
    refused = await guest.evaluate("call('/talaia/base/turn').catch((why) => String(why))")
    assert "there is no service /talaia/base/turn" in refused


async def test_page_reads_fragments_bytes_throttled_topics_and_parameters(
    chromium,
    world,
    origin,
) -> None:
    await open_protocol(world.hub, "rosbridge", origin)
    gateway = world.gateways["agv"]
    page = await connected_page(chromium, world, origin, "driver")
    words, raw, slow = (f"/talaia/base/{name}" for name in ("words", "shut", "open"))
    number = {"type": "std_msgs/Float64"}
    for fields in (
        {"topic": words, "type": "std_msgs/String", "fragment_size": 300},
        {"topic": raw, "compression": "cbor-raw", **number},
        {"topic": slow, "throttle_rate": 60_000, "queue_length": 2, **number},
    ):
        await page.evaluate("(fields) => subscribeAs(fields)", fields)
    assert await page.evaluate("param('/base/drive/max_speed')") == 1
    assert "no parameter" in await page.evaluate("param('/nothing').catch((why) => String(why))")
    # Answered after the subscriptions.
    await page.evaluate("list()")
    long = "word " * 300
    await gateway.samples(*(("base/open", NOW + at, at + 0.5) for at in range(1, 6)))
    await gateway.samples(("base/words", NOW + 7, long), ("base/shut", NOW + 7, 0.25))
    await page.wait_for_function(HEARD, arg=[words, long])
    # As roslib gives it: the serialized message, whose number stands after a head of four bytes.
    read = """(name) => {
      const found = told.find((each) => each[0] === name);
      if (found === undefined) return false;
      const {secs, nsecs, bytes} = found[1];
      const data = Uint8Array.from(bytes).buffer;
      return {secs, nsecs, value: new DataView(data).getFloat64(4, true)};
    }"""
    found = await (await page.wait_for_function(read, arg=raw)).json_value()
    assert found == {"secs": NOW // 10**6, "nsecs": 7000, "value": 0.25}
    # One went at once; the others wait for a minute.
    passed = "(name) => told.filter((each) => each[0] === name).map(([, value]) => value.data)"
    assert await page.evaluate(passed, slow) == [1.5]
    await page.close()


async def test_page_that_tries_everything_moves_what_its_token_may_and_nothing_else(
    chromium,
    world,
    origin,
) -> None:
    await open_protocol(world.hub, "rosbridge", origin)
    gateway, devices = world.gateways["agv"], ["base", "power", "camera"]
    # An admin lets nobody drive anything here; STOP takes no more than being allowed to look.
    expected = {
        "guest": set(),
        "driver": {("call", "base"), ("stop", "base")},
        "admin": {(what, device) for what in ("call", "stop") for device in devices},
    }
    for name, sent in expected.items():
        page = await connected_page(chromium, world, origin, name)
        await page.evaluate("(devices) => everything(devices)", devices)
        # What a page of ours asks for now reaches the gateway after all of that.
        ours = await world.page("operator")
        mark = {"site": "agv", "device": "camera", "command": "turn", "args": {}}
        await ours.say(PageCommand(id=f"mark-{name}", **mark))
        await gateway.hear(frames.CommandRequest, lambda asked: asked.who == "operator")
        assert sent_for(gateway, name) == sent
        await ours.close()
        await page.close()


async def test_page_drives_at_half_speed_and_gives_the_vehicle_back_when_it_is_closed(
    chromium,
    world,
    origin,
) -> None:
    await open_protocol(world.hub, "rosbridge", origin)
    gateway, admin = world.gateways["agv"], await world.admin()
    person = str((await world.hub.people.find_by_name("driver")).id)
    asked = {"person": person, "site": "agv", "device": "base", "allowed": True}
    assert (await admin.put("/api/client-drivers", json=asked)).status_code == 204
    page = await connected_page(chromium, world, origin, "driver")
    await page.evaluate("drive(0.9)")
    lease = await gateway.hear(frames.LeaseRequest)
    assert (lease.op, lease.who) == (LeaseOp.TAKE, "driver")
    await gateway.say(
        frames.LeaseState(
            device="base", session=lease.session, who="driver", epoch=9, remains_ms=3000
        )
    )
    await gateway.say(frames.ControlTick(tick=42))
    moved = await gateway.hear(frames.DriveFrame, lambda frame: frame.linear > 0)
    # Half of the description's 1 m/s.
    assert moved.linear == 0.5
    await page.close()
    # A gateway stops a vehicle whose lease is given back.
    await gateway.hear(frames.LeaseRequest, lambda ask: ask.op is LeaseOp.FREE)
