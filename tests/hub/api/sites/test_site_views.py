"""What pages are told of a device's roles: those that are said, and those that are proposed."""

from __future__ import annotations

from pathlib import Path

from talaia.model.detection import Detect, PictureLine, PictureZone

from ...seeing import seeing

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


SHOWN = """
talaia: 1
site: agv
name: Robot
ros2: {}
shown_units: {°C: °F, m/s: km/h}
devices:
  box:
    name: Box
    signals:
      inside: {name: Inside, unit: °C, decimals: 1, source: &at
        {topic: /t, type: a/msg/B, field: d}}
      outside: {name: Outside, unit: °C, source: *at}
      warmer: {name: Warmer, unit: °C, source: {expression: "{box/inside} - {box/outside}"}}
      scaled: {name: Scaled, unit: °C, source: {expression: "{box/inside} * 2 - 1"}}
      speed: {name: Speed, unit: m/s, decimals: 2, source: *at}
      light: {name: Light, unit: lx, source: *at}
      place: {name: Place, type: position, source: {topic: /p, type: a/msg/P, field: pose}}
"""


async def test_each_sees_values_in_the_unit_they_chose_or_else_in_the_sites(hub) -> None:
    signals = {item["id"]: item for item in (await devices_of(hub, SHOWN))["box"]["signals"]}
    shown = {name: item["shown"] for name, item in signals.items()}
    fahrenheit = {"unit": "°F", "factor": 1.8, "offset": 32.0, "decimals": 1}
    assert shown["inside"] == shown["outside"] == fahrenheit
    # What is warmer by 2 °C is warmer by 3.6 °F; of what is scaled nobody knows what it is.
    assert shown["warmer"] == {**fahrenheit, "offset": 0.0}
    assert shown["scaled"] is shown["light"] is shown["place"] is None
    assert (shown["speed"]["unit"], shown["speed"]["decimals"]) == ("km/h", 1)
    assert signals["speed"]["unit"] == "m/s"
    ada = await hub.client("operator")
    wrong = await ada.put("/api/me/units", json={"shown": {"m/s": "°C"}})
    assert (wrong.status_code, wrong.json()["message"]) == (422, "m/s cannot be shown in °C")
    choice = {"m/s": "kn", "°C": "°C", "m": "ft"}
    assert (await ada.put("/api/me/units", json={"shown": choice})).status_code == 204
    site = (await ada.get("/api/sites/agv")).json()
    shown = {item["id"]: item["shown"] for item in site["devices"][0]["signals"]}
    assert (shown["speed"]["unit"], shown["inside"]) == ("kn", None)
    assert shown["place"]["unit"] == site["shown_units"]["m"]["unit"] == "ft"
    # Only hers, and asked for with what else there is to choose.
    other = (await (await hub.client("admin")).get("/api/sites/agv")).json()
    assert other["shown_units"]["m/s"]["unit"] == "km/h"
    listed = {item["unit"]: item for item in (await ada.get("/api/me/units")).json()["units"]}
    assert listed["°C"] == {
        "unit": "°C",
        "name": "degree Celsius",
        "sites": ["Robot"],
        "shown": "°C",
        "choices": ["°F", "K"],
    }
    assert "lx" not in listed


async def test_zones_and_lines_of_a_camera_come_with_the_signals_that_count_at_them(hub) -> None:
    corners = ((0.3, 0.6), (0.6, 0.6), (0.7, 1.0))
    described = seeing(
        Detect(
            classes=("person",),
            zones={"mat": PictureZone(name="Mat", points=corners)},
            lines={"door": PictureLine(name="Door", points=corners[:2])},
        )
    )
    counting = described.replace(
        "      front_person:",
        "      mat_dwell:\n        name: Longest\n        unit: s\n"
        "        source: {stream: front, sees: person, zone: mat, measure: dwell}\n"
        "      front_person:",
        1,
    )
    assert counting != described
    camera = (await devices_of(hub, counting))["camera"]
    detect = next(item["detect"] for item in camera["streams"] if item["id"] == "front")
    (mat,), (door,) = detect["zones"], detect["lines"]
    assert (mat["id"], mat["name"]) == ("mat", "Mat")
    assert mat["points"] == [{"x": x, "y": y} for x, y in corners]
    assert [(item["signal"], item["measure"]) for item in mat["counts"]] == [
        ("camera/mat_dwell", "dwell")
    ]
    assert (door["name"], door["counts"]) == ("Door", [])
