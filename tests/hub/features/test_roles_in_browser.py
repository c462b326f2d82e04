"""A dome described in Catalan has its page by roles alone, in a real Chromium."""

from __future__ import annotations

import pytest
from playwright.async_api import expect

from talaia.clock import SystemClock
from talaia.model.yaml_text.load import load_site

from ..chromium import sign_in

pytestmark = [pytest.mark.browser, pytest.mark.timeout(120)]
CATALAN = """\
talaia: 1
site: agv
name: Observatori
ros2: {}
devices:
  cupula:
    name: Cúpula
    kind: dome
    signals:
      comporta:
        name: Comporta
        role: dome.shutter
        type: state
        states: [tancada, oberta, obrint-se, aturada]
        meanings: [closed, open, opening, partial]
        max_age: 600
        source: {topic: /cupula/estat, type: std_msgs/msg/UInt8, field: data}
      gir:
        name: Gir
        role: dome.azimuth
        unit: °
        max_age: 600
        source: {topic: /cupula/gir, type: std_msgs/msg/Float64, field: data}
      mode:
        name: Mode
        type: state
        states: [bé, avaria]
        meanings: [normal, error]
        max_age: 600
        source: {topic: /cupula/mode, type: std_msgs/msg/UInt8, field: data}
    commands:
      obre: {name: Obre, role: dome.open, target: /cupula/obre, type: std_srvs/srv/Trigger}
      tanca: {name: Tanca, role: dome.close, target: /cupula/tanca, type: std_srvs/srv/Trigger}
      neteja: {name: Neteja, target: /cupula/neteja, type: std_srvs/srv/Trigger}
"""


@pytest.mark.parametrize(
    ("width", "theme"), [(1440, "light"), (390, "dark")], ids=["desktop-light", "phone-dark"]
)
async def test_a_dome_in_catalan_is_drawn_with_its_buttons(
    chromium, hub, width: int, theme: str
) -> None:
    site = load_site(CATALAN)
    gateway = await hub.gateway()
    await gateway.hello(description=CATALAN)
    page = await sign_in(chromium, hub, "operator")
    await page.set_viewport_size({"width": width, "height": 844})
    await page.emulate_media(color_scheme=theme)
    await page.goto(f"{hub.origin}/sites/agv/devices/cupula")
    dome = page.locator("t-part-dome")
    await expect(dome.get_by_role("button", name="Obre")).to_be_visible()
    gateway.channels = {channel.address: at for at, channel in enumerate(site.channels())}
    now_us = SystemClock().wall_ns() // 1000
    await gateway.samples(
        ("cupula/comporta", now_us, 1.0),
        ("cupula/gir", now_us, 90.0),
        ("cupula/mode", now_us, 1.0),
    )
    await expect(dome.locator("t-status").first).to_contain_text("Open")
    await expect(dome.locator("strong")).to_contain_text("90")
    await expect(page.get_by_text("oberta").first).to_be_visible()
    # What the description calls an error looks like one, in any language.
    await expect(page.locator("t-value[level=bad]")).to_contain_text("avaria")
    await expect(dome.get_by_role("button", name="Tanca")).to_be_visible()
    # What has no role is not lost: it stands among the other commands.
    await expect(dome.get_by_role("button", name="Neteja")).to_have_count(0)
    others = page.locator("t-commands")
    await expect(others.get_by_role("heading", name="Other commands")).to_be_visible()
    await expect(others.get_by_text("Neteja").first).to_be_visible()
    assert await page.evaluate("document.documentElement.scrollWidth") <= width
    assert page.errors == []
