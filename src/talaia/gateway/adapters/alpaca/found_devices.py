"""Asks an Alpaca server what it has, and makes devices of it; the same for gateway and probe."""

from __future__ import annotations

from typing import TYPE_CHECKING

from talaia.gateway.adapters.alpaca.discovery import (
    FoundDevice,
    questions_for,
    switch_questions,
)
from talaia.gateway.adapters.alpaca.protocol import NOT_IMPLEMENTED, AlpacaRefused, Configured
from talaia.gateway.adapters.alpaca.standard_signals import DEVICE_TYPES

if TYPE_CHECKING:
    from collections.abc import Collection

    from talaia.gateway.adapters.alpaca.server import AlpacaServer

__all__ = ["ask_device", "list_devices"]

# Without a list, each type's numbers are tried from 0 until one is not there.
_MOST_TRIED = 4


async def list_devices(server: AlpacaServer, wanted: Collection[str] = ()) -> list[Configured]:
    """List a server's devices: by its management API, or by asking for each type's first ones.

    Args:
        server: who is asked.
        wanted: only these (``telescope/0``), which then are asked for by name; empty for all.

    Raises:
        FetchFailed: it does not answer.
        AlpacaRefused: its list cannot be read.

    """
    listed = await server.list_devices()
    if listed is not None:
        return [found for found in listed if not wanted or found.device in wanted]
    tried = [[device] for device in wanted] or [
        [f"{kind}/{number}" for number in range(_MOST_TRIED)] for kind in DEVICE_TYPES
    ]
    found: list[Configured] = []
    for row in tried:
        for device in row:
            try:
                name = await server.ask_property(f"{device}/name")
            except AlpacaRefused:
                break
            found.append(Configured(str(name), device, ""))
    return found


async def ask_device(server: AlpacaServer, found: Configured) -> FoundDevice:
    """Ask a device for all that its type may have.

    Raises:
        FetchFailed: it does not answer.

    """
    answers: dict[str, object] = {}
    kind = found.device.partition("/")[0]
    await _ask_all(server, found.device, questions_for(kind), answers)
    if kind == "switch":
        await _ask_all(server, found.device, switch_questions(answers.get("maxswitch")), answers)
    return FoundDevice(found.device, found.name, answers)


async def _ask_all(
    server: AlpacaServer, device: str, names: list[str], answers: dict[str, object]
) -> None:
    for name in names:
        try:
            answers[name] = await server.ask_property(f"{device}/{name}")
        except AlpacaRefused as error:
            # It has it, and no value now: a mount that is not connected, a sensor that warms up.
            if error.number not in (NOT_IMPLEMENTED, 0):
                answers[name] = None
