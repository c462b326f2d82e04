"""A page of somebody else with npm's roslib, unchanged, in Chromium: guest, driver, admin."""

from __future__ import annotations

import asyncio
import functools
import http.server
import threading

import pytest

from talaia.wire import frames
from talaia.wire.browser import PageCommand
from talaia.wire.frames import CommandPhase, LeaseOp

from ...everyone.world import NOW
from ..sent_messages import sent_for
from ..tokens import open_protocol, token_of
from .rosbridge_peer import address_of, bundle_roslib

PAGE = """<!doctype html><title>A page with roslib</title><script src="roslib.js"></script>
<script>
const ros = new ROSLIB.Ros();
const told = [];
for (const event of ["connection", "close"]) ros.on(event, () => told.push([event, null]));
function subscribe(name, messageType, compression) {
  const topic = new ROSLIB.Topic({ros, name, messageType, compression});
  topic.subscribe((message) => told.push([name, message]));
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
</script>"""
HEARD = "([name, value]) => told.some((each) => each[0] === name && each[1]?.data === value)"


class Quiet(http.server.SimpleHTTPRequestHandler):
    """Serves a folder and prints nothing."""

    def log_message(self, *_about: object) -> None:
        """Print nothing."""


@pytest.fixture(scope="module")
def origin(tmp_path_factory):
    """Where the page is served from, which is not the hub."""
    folder = tmp_path_factory.mktemp("page")
    bundle_roslib(folder)
    (folder / "index.html").write_text(PAGE)
    handler = functools.partial(Quiet, directory=folder)
    with http.server.ThreadingHTTPServer(("127.0.0.1", 0), handler) as server:
        threading.Thread(target=server.serve_forever, daemon=True).start()
        yield f"http://127.0.0.1:{server.server_address[1]}"
        server.shutdown()


async def open_page(chromium, world, origin, name):
    page = await chromium.new_page()
    await page.goto(origin)
    address = address_of(world.hub, "agv", await token_of(world.hub, name))
    await page.evaluate("(address) => void ros.connect(address)", address)
    return page


async def connected_page(chromium, world, origin, name):
    page = await open_page(chromium, world, origin, name)
    await page.wait_for_function("told.some(([event]) => event === 'connection')")
    return page


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
