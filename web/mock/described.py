"""The site description as the HTTP API says it."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

from seen_side import CLASSES

from talaia.model.site import parts_of
from talaia.model.units.conversion import shown_units
from talaia.model.units.unit import unit_of

if TYPE_CHECKING:
    from talaia.model.site import Device, Signal


# Stored unit to shown unit, as the account page has chosen.
CHOSEN: dict[str, str] = {}


def shown_json(unit: str) -> dict[str, Any] | None:
    """Say in which unit values are shown, as the hub does."""
    way = shown_units(CHOSEN).get(unit)
    return None if way is None else way._asdict()


def signal_json(device_id: str, signal_id: str, signal: Signal) -> dict[str, Any]:
    """Say a signal as the hub does."""
    address = f"{device_id}/{signal_id}"
    return {
        "id": signal_id,
        "address": address,
        "name": signal.name,
        "type": signal.type,
        "role": signal.role if signal.role != "auto" else "none",
        "unit": signal.unit,
        "decimals": signal.decimals if signal.decimals >= 0 else unit_of(signal.unit).decimals,
        "minimum": signal.minimum,
        "maximum": signal.maximum,
        "shown": shown_json(signal.unit),
        "states": signal.states,
        "meanings": signal.meanings,
        "frame": signal.frame,
        "max_age": signal.max_age,
        "primary": signal.primary,
        "public": signal.visibility == "public",
        "ros": "",
        "channels": [address + (f".{part}" if part else "") for part in parts_of(signal)],
    }


def drive_json(device: Device) -> dict[str, Any] | None:
    """Say how a device is driven."""
    drive = device.drive
    if drive is None:
        return None
    return {
        "max_speed": drive.max_speed,
        "shown_speed": shown_json("m/s"),
        "shown_turn": shown_json("rad/s"),
        "max_reverse": drive.max_speed if drive.max_reverse is None else drive.max_reverse,
        "max_turn": drive.max_turn,
        "ttl": drive.ttl,
        "rate": drive.rate,
        "lease": drive.lease,
        "picture": drive.picture,
        "position": drive.position,
        "stop": True,
    }


def device_json(device_id: str, device: Device, rights: list[str]) -> dict[str, Any]:
    """Say a device as the hub does to somebody with these rights on it."""
    views = bool(rights)
    return {
        "id": device_id,
        "name": device.name,
        "kind": device.kind,
        "public": device.visibility == "public",
        "signals": [
            signal_json(device_id, key, one)
            for key, one in device.signals.items()
            if views or one.visibility == "public"
        ],
        "streams": [
            {
                "id": key,
                "address": f"{device_id}/{key}",
                "name": one.name,
                "max_rate": one.max_rate,
                "public": one.visibility == "public",
                "detect": {"classes": CLASSES, "confidence": 0.5},
                "blurred": one.blur is not None,
                "may_unblur": one.blur is not None and "admin" in rights,
            }
            for key, one in device.streams.items()
            if views or one.visibility == "public"
        ],
        "commands": [
            {
                "id": key,
                "name": one.name,
                "role": one.role if one.role != "auto" else "none",
                "description": one.description,
                "confirm": one.confirm,
                "timeout": one.timeout,
                "ros": "",
                "arguments": [
                    {
                        "id": name,
                        "name": argument.name or name,
                        "type": argument.type,
                        "unit": argument.unit,
                        "minimum": argument.minimum,
                        "maximum": argument.maximum,
                        "max_length": argument.max_length,
                        "default": argument.default,
                    }
                    for name, argument in one.arguments.items()
                ],
            }
            for key, one in device.commands.items()
            if "use" in rights
        ],
        "drive": drive_json(device) if views else None,
        "pointing": None,
        "slew": None,
        "rights": rights,
    }
