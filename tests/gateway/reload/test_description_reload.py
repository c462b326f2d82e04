"""No part of a gateway holds a description that counts no more."""

from __future__ import annotations

from typing import TYPE_CHECKING

from object_graph import paths_to, replaced_structs

from talaia.clock import SystemClock
from talaia.gateway.app import Gateway
from talaia.gateway.assembly.reload import ReloadPart
from talaia.gateway.reload.current_description import prepare_description
from talaia.gateway.settings import GatewaySettings, HubAddress, LegacySettings
from talaia.model.derived_signals import with_counts
from talaia.model.yaml_text.load import load_site

if TYPE_CHECKING:
    from pathlib import Path

TEXT = """
talaia: 1
site: dome
name: Dome
connections:
  bridge: {kind: rosbridge, url: "ws://127.0.0.1:9090"}
  shell: {kind: process}
devices:
  dome:
    name: Dome
    connection: bridge
    signals:
      wind: {name: Wind, unit: m/s, source: {topic: /w, type: std_msgs/msg/Float64, field: data}}
      shut: {name: Shut, source: {topic: /s, type: std_msgs/msg/Float64, field: data}}
    streams:
      inside: {name: Inside, source: {topic: /images, type: sensor_msgs/msg/CompressedImage}}
    commands:
      close: {name: Close, target: /close, type: std_srvs/srv/Trigger}
    drive:
      topic: /cmd_vel
      max_speed: 0.2
      max_turn: 2
      stop: {topic: /stop, confirmed_by: [dome/wind]}
  tool:
    name: Tool
    connection: shell
    signals:
      load: {name: Load, source: {run: "uptime"}}
    commands:
      turn: {name: Turn, kind: process, target: "true"}
interlocks:
  storm:
    name: Storm
    when: [{signal: dome/wind, above: 10}]
    refuse: [dome/close]
"""


async def test_no_part_keeps_a_description_that_has_been_replaced(tmp_path: Path) -> None:
    gateway = Gateway(
        site=load_site(TEXT),
        settings=GatewaySettings(
            hub=HubAddress.from_text("ws://127.0.0.1:1", allow_plain=True),
            key="key",
            data=tmp_path,
            door=LegacySettings(port=0),
        ),
        clock=SystemClock(),
    )
    try:
        (reload,) = [part.reload for part in gateway._parts if isinstance(part, ReloadPart)]
        before = reload.now.site
        # Every name is another: nothing of the former description can count by being the same.
        text = TEXT.replace("name: ", "name: New ")
        after = with_counts(load_site(text))
        reload.apply_description(prepare_description(after, text), "", "")
        replaced = replaced_structs(before, after)
        assert len(replaced) >= 10
        assert paths_to(gateway, replaced) == []
    finally:
        await gateway.close()
