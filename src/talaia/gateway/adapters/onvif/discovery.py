"""From what an ONVIF camera says that it has to a device of a description. Pure."""

from __future__ import annotations

import math
from typing import NamedTuple

from talaia.gateway.adapters.onvif.answers import CameraProfile, PtzStatus
from talaia.model.connection import OnvifSource
from talaia.model.discovery.ros_units import word_of
from talaia.model.discovery.topic_words import free_word
from talaia.model.site import (
    Argument,
    ArgumentType,
    Command,
    CommandKind,
    CommandRight,
    Device,
    DeviceKind,
    Drive,
    DriveMessage,
    DrivenJoint,
    Signal,
    SignalType,
    Stop,
    Stream,
)

__all__ = ["CameraFindings", "FoundStream", "device_of"]

# Half of its fastest, until the owner says how fast people may turn it.
CAREFUL_SHARE = 0.5
# From one end to the other some cameras need so long, slowly (s).
_WAY_S = 45.0


class FoundStream(NamedTuple):
    """A picture of a camera: its address, or why it is left out."""

    profile: CameraProfile
    address: str
    problem: str = ""


class CameraFindings(NamedTuple):
    """What a camera says of itself.

    Attributes:
        profile: the token of what moves; empty where nothing does.
        axes: ``pan``, ``tilt``, ``zoom``, as far as each can be moved.
        problem: why it cannot be used; empty where it can.

    """

    url: str
    name: str = ""
    model: str = ""
    streams: tuple[FoundStream, ...] = ()
    profile: str = ""
    axes: tuple[str, ...] = ()
    has_home: bool = False
    has_presets: bool = False
    presets: tuple[str, ...] = ()
    status: PtzStatus = PtzStatus()
    problem: str = ""


def device_of(found: CameraFindings, word: str) -> Device:
    """Describe a camera: pictures, and where it moves its drive, signals and commands.

    Args:
        found: what it has.
        word: its own in addresses, and its connection's.

    """
    streams: dict[str, Stream] = {}
    for stream in found.streams:
        if not stream.problem:
            key = free_word(word_of(stream.profile.name or stream.profile.token), streams)
            streams[key] = Stream(
                name=stream.profile.name or key, source=OnvifSource(url=stream.address)
            )
    signals = _signals_of(found)
    drive = None
    if found.axes:
        drive = Drive(
            message=DriveMessage.PTZ,
            joints={
                axis: DrivenJoint(name=axis.capitalize(), max_speed=CAREFUL_SHARE)
                for axis in found.axes
            },
            picture=f"{word}/{next(iter(streams))}" if streams else "",
            stop=Stop(confirmed_by=(f"{word}/moving",) if "moving" in signals else ()),
        )
    return Device(
        name=found.name or found.model or word,
        kind=DeviceKind.CAMERA,
        connection=word,
        streams=streams,
        signals=signals,
        commands=_commands_of(found),
        drive=drive,
    )


def _signals_of(found: CameraFindings) -> dict[str, Signal]:
    place, signals = found.status.place, dict[str, Signal]()
    for axis, value in place._asdict().items():
        if axis in found.axes and not math.isnan(value):
            signals[axis] = Signal(
                name=axis.capitalize(), source=OnvifSource(ptz=axis), decimals=2, primary=False
            )
    if signals or found.status.moving is not None:
        signals["moving"] = Signal(name="Moves", source=OnvifSource(ptz="moving"), primary=False)
    if found.has_presets:
        signals["presets"] = Signal(
            name="Presets",
            source=OnvifSource(ptz="presets"),
            type=SignalType.TEXT,
            # It changes when somebody sets one.
            max_age=0.0,
            primary=False,
        )
    return signals


def _commands_of(found: CameraFindings) -> dict[str, Command]:
    commands: dict[str, Command] = {}
    if found.has_presets:
        preset = {
            "preset": Argument(type=ArgumentType.TEXT, field="preset", name="Preset", max_length=64)
        }
        for key, name, target in (
            ("goto_preset", "Go to preset", "GotoPreset"),
            ("set_preset", "Keep as preset", "SetPreset"),
            ("remove_preset", "Remove preset", "RemovePreset"),
        ):
            goes = target == "GotoPreset"
            commands[key] = _command(
                name, target, preset, timeout=_WAY_S if goes else 10.0, changes=not goes
            )
    if found.has_home:
        commands["home"] = _command("Go home", "GotoHomePosition", timeout=_WAY_S)
        commands["set_home"] = _command("Keep as home", "SetHomePosition", changes=True)
    if found.axes:
        # By this word it is done whoever else acts on it: it makes safe.
        commands["stop"] = _command("Stop", "Stop")
    return commands


def _command(
    name: str,
    target: str,
    arguments: dict[str, Argument] | None = None,
    *,
    timeout: float = 10.0,
    changes: bool = False,
) -> Command:
    return Command(
        name=name,
        target=target,
        kind=CommandKind.ONVIF,
        arguments=arguments or {},
        timeout=timeout,
        # Others go by what it is.
        confirm=changes,
        right=CommandRight.ADMIN if changes else CommandRight.USE,
    )
