"""The command-line clients' words (``dome_servcli client open``), the same for both ROS. Pure."""

from __future__ import annotations

import re
from typing import TYPE_CHECKING, NamedTuple

from talaia.sim.observatory.models.ticket import Ticket
from talaia.sim.observatory.servers.devices import DEVICES

if TYPE_CHECKING:
    from talaia.sim.observatory.servers.base import Server, Value

__all__ = ["PROGRAMS", "ClientRequest", "InvalidRequest", "parse_number", "parse_request"]

PROGRAMS = {f"{device}_servcli": device for device in DEVICES}
# Hours or degrees, minutes, and perhaps seconds, with a sign before all of them.
_PARTS = re.compile(r"([+-]?)(\d+)[:h](\d+)(?:[:m](\d+(?:\.\d*)?))?s?")


class InvalidRequest(Exception):
    """What was written asks for nothing that there is."""


class ClientRequest(NamedTuple):
    """One request to a server.

    Attributes:
        kind: trigger, switch, ask or fault.
        name: of the service below the device's.
        values: arguments by name.

    """

    device: str
    kind: str
    name: str
    values: dict[str, Value]


def parse_number(text: str) -> float:
    """Read a number, or hours (degrees), minutes and seconds: ``5:34:32``, ``-5h23m``.

    Raises:
        InvalidRequest: it is none.

    """
    found = _PARTS.fullmatch(text)
    if found:
        sign, whole, minutes, seconds = found.groups()
        value = int(whole) + int(minutes) / 60 + float(seconds or 0) / 3600
        return -value if sign == "-" else value
    try:
        value = float(text)
    except ValueError:
        # Refused below, with whatever else is not finite.
        value = float("nan")
    if value != value or value in (float("inf"), float("-inf")):
        raise InvalidRequest(f"{text!r} is not a number")
    return value


def parse_request(device: str, words: list[str]) -> ClientRequest:
    """Read what stands behind ``client``.

    Raises:
        InvalidRequest: in the founding design's words where it had some.

    """
    # Here: with NumPy, which wrong words of others need not wait for.
    from talaia.sim.observatory.servers.catalog import make_server

    # One of our own that nobody reaches: it knows which words there are.
    server = make_server(device, seed=0, unix_s=0.0, call=_call_nobody)
    action, rest = (words[0], words[1:]) if words else ("", [])
    if device == "observatory" and action == "fault":
        return ClientRequest(device, "fault", action, {"data": " ".join(rest)})
    if action in server.triggers and not rest:
        return ClientRequest(device, "trigger", action, {})
    if action in server.switches:
        if rest not in (["on"], ["off"]):
            raise InvalidRequest(f"{action}: expected on or off")
        return ClientRequest(device, "switch", action, {"data": rest == ["on"]})
    if action in server.asks:
        return ClientRequest(device, "ask", action, _parse_values(server, action, rest))
    raise InvalidRequest(f"Invalid {device} action")


def _parse_values(server: Server, action: str, rest: list[str]) -> dict[str, Value]:
    arguments = server.asks[action].arguments
    # Those whose example is a text may be left out.
    least = sum(not isinstance(argument, str) for argument in arguments.values())
    if not least <= len(rest) <= len(arguments):
        raise InvalidRequest(
            f"{action}: expected {' '.join(argument.upper() for argument in arguments)}"
        )
    given = zip(arguments.items(), rest, strict=False)
    return {
        name: text if isinstance(example, str) else parse_number(text)
        for (name, example), text in given
    }


def _call_nobody(device: str, service: str) -> Ticket:
    return Ticket.refused(f"/{device}/{service} is not there")
