"""No part of the hub holds a description that counts no more."""

from __future__ import annotations

from object_graph import paths_to, replaced_structs

from talaia.model.yaml_text.load import load_site
from talaia.wire.browser import EventUpdate, Subscribe, Values
from talaia.wire.frames import Ack, DescriptionUpdate
from talaia.wire.sealing import compress_text

FIRST = """
talaia: 1
site: agv
name: Robot
ros2: {}
devices:
  base:
    name: Base
    signals:
      speed:
        name: Speed
        source: {topic: /odom, type: nav_msgs/msg/Odometry, field: twist.twist.linear.x}
        anomalies:
          - {detector: iqr}
    streams:
      front: {name: Front, source: {topic: /images, type: sensor_msgs/msg/Image}}
alarms:
  fast: {name: Fast, kind: limit, severity: warning, signal: base/speed, above: 3}
"""
SECOND = FIRST.replace("name: ", "name: New ")


async def test_no_part_keeps_a_description_that_has_been_replaced(hub) -> None:
    page, gateway = await hub.page("admin"), await hub.gateway()
    await gateway.hello(FIRST)
    gateway.channels = {"base/speed": 0}
    await page.say(Subscribe(sub=1, site="agv", channels=["base/speed"]))
    await gateway.samples(("base/speed", 1, 1.0))
    await page.hear(Values)
    before = hub.hub.core.sites.find_site("agv").description
    update = DescriptionUpdate(
        description=compress_text(SECOND),
        catalogue="c1",
        addresses=[each.address for each in load_site(SECOND).channels()],
        renamed={},
    )
    await gateway.say(update)
    await page.hear(EventUpdate, lambda news: news.kind == "description changed")
    # The detectors go by it from the next sample on.
    await gateway.samples(("base/speed", 2, 1.0))
    await gateway.hear(Ack, lambda ack: ack.below == 2)
    after = hub.hub.core.sites.find_site("agv").description
    assert after.name == "New Robot"
    assert paths_to(hub.hub, replaced_structs(before, after)) == []
