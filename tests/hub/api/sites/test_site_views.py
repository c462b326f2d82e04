"""What pages are told of a device's roles: those that are said, and those that are proposed."""

from __future__ import annotations

from pathlib import Path

EXAMPLES = Path(__file__).parents[4] / "examples"


async def devices_of(hub, text: str, name: str = "operator") -> dict[str, dict]:
    gateway = await hub.gateway()
    await gateway.hello(text)
    site = (await (await hub.client(name)).get("/api/sites/agv")).json()
    return {device["id"]: device for device in site["devices"]}


def roles_in(device: dict) -> dict[str, str]:
    return {item["id"]: item["role"] for item in device["signals"]}


async def test_a_description_without_roles_is_served_with_those_that_are_proposed(hub) -> None:
    text = (EXAMPLES / "observatory" / "site.yaml").read_text()
    plain = "\n".join(line for line in text.splitlines() if not line.strip().startswith("role:"))
    devices = await devices_of(hub, plain.replace("site: observatory", "site: agv"))
    assert "role:" not in plain
    assert roles_in(devices["dome"]) == {
        "shutter": "dome.shutter",
        "closed": "none",
        "position": "dome.opening",
        "azimuth": "dome.azimuth",
        "turning": "dome.turning",
        "local": "dome.local",
    }
    shutter = devices["dome"]["signals"][0]
    assert shutter["meanings"] == ["closed", "open", "opening", "closing", "partial", "error"]
    assert {item["id"]: item["role"] for item in devices["dome"]["commands"]}["open"] == "dome.open"
    slew = {"command": "goto", "ra": "ra", "dec": "dec", "alt": "", "az": ""}
    assert devices["telescope"]["slew"] == slew
    assert devices["dome"]["slew"] is None


async def test_whoever_may_not_use_a_telescope_is_not_told_how_it_is_pointed(hub) -> None:
    text = (EXAMPLES / "observatory" / "site.yaml").read_text()
    public = text.replace("site: observatory", "site: agv").replace(
        "kind: telescope\n", "kind: telescope\n    visibility: public\n"
    )
    telescope = (await devices_of(hub, public, "guest"))["telescope"]
    assert telescope["slew"] is None
    assert telescope["commands"] == []


LIFECYCLE = """
talaia: 1
site: agv
name: Robot
ros2: {}
devices:
  lidar:
    name: Lidar
    signals:
      state:
        name: State
        type: state
        states: [unconfigured, inactive, active, finalized]
        source: {lifecycle: /lidar}
    commands:
      activate: {name: Activate, kind: lifecycle, target: /lidar, fixed: {transition: activate}}
      other: {name: Other, kind: lifecycle, target: /other, fixed: {transition: activate}}
"""


async def test_a_transition_says_from_which_states_it_leads_on(hub) -> None:
    """Of a node whose state is no signal here nobody can say."""
    lidar = (await devices_of(hub, LIFECYCLE))["lidar"]
    commands = lidar["commands"]
    assert commands[0]["needs"] == {
        "channel": "lidar/state",
        "max_age": 5.0,
        "states": ["unconfigured", "inactive", "active", "finalized"],
        "among": ["inactive"],
    }
    assert commands[1]["needs"] is None
    assert [each["ros"] for each in (*lidar["signals"], *commands)] == ["lifecycle"] * 3
