"""What the page asks, as JSON: each device with what it has, and STOP."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

import msgspec

from talaia.model.discovery.rules.stop_choice import (
    ABOUT_STOP,
    question_of_signal,
    question_of_topic,
)
from talaia.model.site import SignalType, parts_of
from talaia.model.units.unit import UNITS

if TYPE_CHECKING:
    from talaia.model.discovery.generate_description import DescriptionProposal
    from talaia.model.site import Device, Drive, Signal, Stream

__all__ = ["questions_of"]


def questions_of(made: DescriptionProposal, output: str) -> bytes:
    """Write the questions about a proposal; ``output`` is where the answer goes."""
    topics = dict.fromkeys(name for choice in made.stops for name in choice.topics)
    signals = dict.fromkeys(one for choice in made.stops for one in choice.signals)
    asked: dict[str, Any] = {
        "name": made.site.name,
        "output": output,
        "devices": [_device(word, device) for word, device in made.site.devices.items()],
        "left_out": list(made.left_out),
        "units": [symbol for symbol in UNITS if symbol],
        "driven": bool(made.stops),
        "about_stop": ABOUT_STOP,
        "topics": [{"id": name, "question": question_of_topic(name)} for name in topics],
        "signals": [
            {"id": address, "question": question_of_signal(_shown(made, address))}
            for address in signals
        ],
    }
    return msgspec.json.encode(asked)


def _shown(made: DescriptionProposal, address: str) -> str:
    signal = made.site.signal(address)
    return address if signal is None else f"{signal.name} ({address})"


def _device(word: str, device: Device) -> dict[str, Any]:
    return {
        "id": word,
        "name": device.name,
        "kind": device.kind.value,
        "drive": "" if device.drive is None else drive_words(device.drive),
        "signals": [_signal(word, *one) for one in device.signals.items()],
        "streams": [
            {"id": name, "name": one.name, "source": _source_of(one)}
            for name, one in device.streams.items()
        ],
        "commands": [
            {"id": name, "name": one.name, "target": one.target}
            for name, one in device.commands.items()
        ],
    }


def _signal(device: str, word: str, signal: Signal) -> dict[str, Any]:
    address = f"{device}/{word}"
    return {
        "id": word,
        "name": signal.name,
        "type": signal.type.value,
        "unit": signal.unit,
        "states": list(signal.states),
        "primary": signal.primary,
        "measured": signal.type is SignalType.NUMBER,
        "channels": [f"{address}.{part}" if part else address for part in parts_of(signal)],
        "source": _source_of(signal) or getattr(signal.source, "parameter", ""),
    }


def _source_of(one: Signal | Stream) -> str:
    return str(getattr(one.source, "topic", ""))


def drive_words(drive: Drive) -> str:
    """Say by what a device is driven, and how fast at the most."""
    if drive.joints:
        return f"{len(drive.joints)} joints by {drive.topic or drive.message}"
    how = [f"{drive.max_speed:g} m/s"]
    how += [f"{drive.max_sideways:g} m/s sideways"] if drive.max_sideways else []
    how += [f"{drive.max_turn:g} rad/s"] if drive.max_turn else []
    how += [f"wheels to {drive.max_steering:g} rad"] if drive.max_steering else []
    return f"{drive.topic}, at most {', '.join(how)}"
