"""The example's description, with times so short that thousands of trials are possible."""

from __future__ import annotations

import sys
from pathlib import Path
from typing import Any

import yaml

from talaia.model.yaml_text.load import dump_site, load_site

from ..observatory import EXAMPLE

sys.path.insert(0, str(Path(__file__).parents[2] / "gateway"))
from observatory_site import as_ros1

# The simulator's hardware goes so many times faster.
SPEED = 8
# What the description says (s), beside which the table's limits stand.
MAX_AGE_S = 4.0
FROZEN_S = 8.0
LASTING_S = 2.0
MOUNT_S = 6.0
MOVE_S = 6.0
LINK_LOSS_S = 6.0
WATCHDOG_S = 7.0
DISAGREE_S = 2.0
# Of the simulated dome's own controller.
HEARTBEAT_S = 10.0


CLAMSHELL = EXAMPLE.parents[1] / "clamshell" / "site.yaml"


def described(protocol: str, port: int = 0, roof: str = "dome") -> str:
    """Give the description as YAML; with INDI, of a server on this port."""
    site = _shortened(CLAMSHELL if roof == "clamshell" else EXAMPLE)
    if protocol == "INDI":
        _as_indi(site, port)
    loaded = load_site(yaml.safe_dump(site, sort_keys=False, allow_unicode=True))
    return dump_site(as_ros1(loaded) if protocol == "ROS 1" else loaded)


def _as_indi(site: dict[str, Any], port: int) -> None:
    """Let the same site be one of `indi_dome`."""
    site.pop("ros2")
    site.pop("alarms")
    # It has neither a camera nor a command that points.
    site.pop("night", None)
    site["connections"] = {"indi": {"kind": "indi", "port": port, "host": "127.0.0.1"}}
    devices = site["devices"] = {x: site["devices"][x] for x in ("dome", "telescope", "weather")}
    for name, device in devices.items():
        device["indi"] = f"Trial {name.capitalize()}"
    dome, telescope, weather = devices.values()
    signals = dome["signals"]
    dome["signals"] = {x: signals[x] for x in ("shutter", "closed", "position", "local")}
    ways = ["closed", "opening", "open", "closing", "error", "unknown"]
    signals["shutter"] |= {"states": ways, "source": {"property": "DOME_SHUTTER"}}
    for name in ("closed", "position", "local"):
        signals[name]["source"] = {"property": "DOME_SENSORS", "element": name.upper()}
    dome["commands"] = {
        "open": _command("Open", "DOME_SHUTTER", "SHUTTER_OPEN"),
        "close": _command("Close", "DOME_SHUTTER", "SHUTTER_CLOSE"),
        "stop": _command("Stop", "DOME_ABORT_MOTION", "ABORT"),
    }
    state = {
        "name": "Parking",
        "type": "state",
        "states": ["parked", "parking", "unparked", "unparking", "error", "unknown"],
        "source": {"property": "TELESCOPE_PARK"},
    }
    telescope["signals"] = {"state": state}
    telescope["commands"] = {
        "park": _command("Park", "TELESCOPE_PARK", "PARK"),
        "unpark": _command("Unpark", "TELESCOPE_PARK", "UNPARK"),
    }
    telescope.pop("pointing")
    for name in ("raining", "pressure", "description"):
        weather["signals"].pop(name)
    for name, each in weather["signals"].items():
        element = "TEMPERATURE" if name == "stamped" else name.upper()
        each["source"] = {"property": "WEATHER_PARAMETERS", "element": element}
        each["max_age"] = MAX_AGE_S
    weather["signals"]["stamped"]["source"]["stamp"] = "timestamp"
    rules = site["interlocks"]
    rules["rain"]["when"] = [{"signal": "weather/rain", "above": 0}]
    known = {
        f"{x}/{command}" for x, each in devices.items() for command in each.get("commands", ())
    }
    for rule in rules.values():
        rule["refuse"] = [each for each in rule["refuse"] if each in known]
    roof = site["enclosures"]["dome"]
    for gone in ("follow", "heartbeat", "abort"):
        roof.pop(gone)


def _command(name: str, target: str, element: str) -> dict[str, Any]:
    return {"name": name, "kind": "indi", "target": target, "fixed": {element: True}, "timeout": 60}


def _shortened(example: Path) -> dict[str, Any]:
    """Give an example with short times."""
    site: dict[str, Any] = yaml.safe_load(example.read_text())
    weather = site["devices"]["weather"]["signals"]
    for name in ("clouds", "raining", "wind", "gust", "humidity", "dew_point", "temperature"):
        weather[name]["max_age"] = MAX_AGE_S
    weather["temperature"]["frozen_after"] = FROZEN_S
    weather["stamped"] = {
        "name": "Temperature with its time",
        "unit": "°C",
        "max_age": MAX_AGE_S,
        "source": {
            "topic": "/weather/stamped",
            "type": "sensor_msgs/msg/Temperature",
            "field": "temperature",
            "stamp": "header.stamp",
        },
    }
    rules = site["interlocks"]
    rules["weather"]["when"].append({"signal": "weather/stamped", "below": -50})
    for rule in rules.values():
        rule["dwell"] = 1
        for each in rule["when"]:
            each.pop("dwell", None)
            if "lasting" in each:
                each["lasting"] = LASTING_S
    dome, roof = site["devices"]["dome"], site["enclosures"]["dome"]
    if "link_loss" in dome:
        dome["link_loss"]["after"] = LINK_LOSS_S
    if "mount_within" in roof:
        roof["mount_within"] = MOUNT_S
    roof |= {
        "move_within": MOVE_S,
        "retries": 1,
        "alarm_every": 20,
        "watchdog_after": WATCHDOG_S,
        "disagree_after": DISAGREE_S,
    }
    if site["devices"].pop("cctv", None):
        site["devices"]["power"]["outlets"].pop("outlet7")
    return site
