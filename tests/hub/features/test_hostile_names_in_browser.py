"""Hostile names in a real Chromium: each is shown as text, and nothing of it is ever run."""

from __future__ import annotations

import pytest
import yaml
from patience import PATIENCE_MS

from talaia.wire import browser, frames

from ..everyone.story import settle
from ..everyone.world import NOW, PASSWORD, World

pytestmark = [pytest.mark.browser, pytest.mark.timeout(180)]

# Each would set `pwned` if it were taken for markup, a link or a script.
PAYLOADS = {
    "site": "<img src=x onerror=pwned=1>site",
    "device": '"><script>pwned=1</script>device',
    "signal": "<svg/onload=pwned=1>signal",
    "words": "javascript:pwned=1//words",
    "stream": "{{pwned=1}}${pwned=1}stream",
    "command": "'-pwned=1-'command",
    "said": "<iframe srcdoc='<script>parent.pwned=1</script>'>said",
    "value": "<details open ontoggle=pwned=1>value",
    "event": "</title><script>pwned=1</script>event",
}
PERSON = "<img src=x onerror=pwned=1>eve"
DESCRIPTION = yaml.safe_dump(
    {
        "talaia": 1,
        "site": "agv",
        "name": PAYLOADS["site"],
        "ros2": {},
        "devices": {
            "base": {
                "name": PAYLOADS["device"],
                "kind": "vehicle",
                "signals": {
                    "open": {
                        "name": PAYLOADS["signal"],
                        "source": {"topic": "/a", "type": "std_msgs/msg/Float64", "field": "data"},
                    },
                    "words": {
                        "name": PAYLOADS["words"],
                        "type": "text",
                        "source": {"topic": "/c", "type": "std_msgs/msg/String", "field": "data"},
                    },
                },
                "streams": {
                    "eye": {
                        "name": PAYLOADS["stream"],
                        "source": {"topic": "/i", "type": "sensor_msgs/msg/Image"},
                    }
                },
                "commands": {
                    "turn": {
                        "name": PAYLOADS["command"],
                        "description": PAYLOADS["said"],
                        "target": "/turn",
                        "type": "std_srvs/srv/Trigger",
                    }
                },
                "drive": {"topic": "/v", "max_speed": 1, "max_turn": 1},
            }
        },
    }
)
PAGES = (
    "/home",
    "/devices",
    "/public",
    "/sites/agv",
    "/sites/agv/live",
    "/sites/agv/drive",
    "/sites/agv/history",
    "/sites/agv/devices/base",
    "/account",
    "/admin/people",
    "/admin/roles",
    "/admin/gateways",
    "/admin/storage",
    "/admin/audit",
    "/admin/support",
)
# What a page holds, through every shadow root: its text, and markup that a name has become.
LOOK = """() => {
  const texts = [document.title], made = [];
  const walk = (root) => {
    for (const each of root.querySelectorAll('*')) {
      if (each.matches('img[src=x], iframe, details[ontoggle], [onload], [onerror]')
          || each.matches('a[href^=javascript]')
          || (each.localName === 'script' && !each.src)) made.push(each.outerHTML);
      for (const node of each.childNodes) if (node.nodeType === 3) texts.push(node.data);
      for (const name of ['aria-label', 'title', 'label', 'alt', 'placeholder']) {
        if (each.hasAttribute(name)) texts.push(each.getAttribute(name));
      }
      if (each.shadowRoot) walk(each.shadowRoot);
    }
  };
  walk(document);
  return {texts, made, pwned: typeof pwned !== 'undefined', title: document.title};
}"""


async def test_hostile_names_are_text_in_every_page_and_run_in_none(world: World, chromium) -> None:
    kept = (await world.hub.people.find_by_name("admin")).password_hash
    await world.hub.people.add_person(PERSON, kept, "admin")
    await world.gateways["agv"].close()
    gateway = await world.connect("agv", DESCRIPTION)
    await gateway.samples(("base/open", NOW, 1.0), ("base/words", NOW, PAYLOADS["value"]))
    await gateway.say(frames.Event(kind="noise", device="base", message=PAYLOADS["event"]))
    # The person acts, so that their name stands wherever people are named.
    listening = await world.page("operator")
    await listening.hear(browser.Greeting)
    await settle([])

    context = await chromium.new_context(viewport={"width": 1440, "height": 1000})
    context.set_default_timeout(PATIENCE_MS)
    told: list[str] = []
    context.on("weberror", lambda error: told.append(str(error.error)))
    context.on(
        "console",
        lambda line: told.append(line.text) if "Security Policy" in line.text else None,
    )
    context.on("dialog", lambda dialog: told.append(dialog.message))
    page = await context.new_page()
    await page.goto(f"{world.hub.origin}/login")
    await page.get_by_label("Name").fill(PERSON)
    await page.get_by_label("Password").fill(PASSWORD)
    await page.get_by_role("button", name="Sign in", exact=True).click()
    await page.wait_for_url("**/home")
    seen: set[str] = set()
    for path in PAGES:
        await page.goto(world.hub.origin + path)
        await page.wait_for_load_state("networkidle")
        looked = await page.evaluate(LOOK)
        assert not looked["pwned"], path
        assert looked["made"] == [], path
        assert "<script" not in await page.locator("head > title").inner_html(), path
        seen |= {
            what
            for what, payload in {**PAYLOADS, "person": PERSON}.items()
            if any(payload in text for text in looked["texts"])
        }
    assert told == []
    # Each name was really shown, as it was written. What is said of a command opens with it, and
    # events are on pages of their own.
    assert {"site", "device", "signal", "words", "value", "command", "person"} <= seen
    await context.close()
