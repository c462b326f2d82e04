"""Which drivers of an INDI server answer. Pure.

A server says nothing when one of its drivers hangs. So each driver is asked for one property it
has: any answer says that it lives, and makes no measurement newer (`state`). That one has fallen
silent is told once, and once that it is back.
"""

from __future__ import annotations

import logging
from typing import TYPE_CHECKING, Protocol

from talaia.gateway.adapters.indi.goals import SILENT_NS
from talaia.gateway.adapters.indi.protocol import ask_properties

if TYPE_CHECKING:
    from collections.abc import Callable

    from talaia.gateway.adapters.indi.state import IndiDevice, IndiDeviceTree

__all__ = ["DriverAnswers", "DriverEvents"]

log = logging.getLogger(__name__)


class DriverEvents(Protocol):
    """Takes what happened to a driver."""

    def __call__(self, kind: str, device: str, message: str, *, good: bool) -> None:
        """Write down what happened to the driver of an INDI device."""
        ...


class DriverAnswers:
    """All drivers of one server. On the event loop."""

    def __init__(
        self, tree: IndiDeviceTree, send: Callable[[bytes], None], report: DriverEvents
    ) -> None:
        """Take what is known, where words to the server go, and who is told."""
        self._tree, self._send, self._report = tree, send, report
        # INDI devices that were told as silent.
        self._silent: set[str] = set()

    def restart(self) -> None:
        """Begin with a server anew: who was silent there says nothing of now."""
        self._silent.clear()

    def is_silent(self, name: str) -> bool:
        """Tell whether the driver of an INDI device does not answer."""
        return name in self._silent

    def ask_drivers(self, now_ns: int) -> None:
        """Ask every driver for one property, and tell of those that did not answer before."""
        for device in self._tree:
            # CONNECTION is the smallest that nearly all have.
            name = (
                "CONNECTION" if "CONNECTION" in device.vectors else next(iter(device.vectors), "")
            )
            self._send(ask_properties(device.name, name))
            self._judge_silence(device, now_ns)
        # One with nothing to ask for: what comes later is asked for anew.
        if not self._tree.devices:
            self._send(ask_properties())

    def _judge_silence(self, device: IndiDevice, now_ns: int) -> None:
        silent = now_ns - device.heard_ns > SILENT_NS
        if silent == (device.name in self._silent):
            return
        if silent:
            self._silent.add(device.name)
            log.warning("the INDI driver of %s does not answer", device.name)
            self._report("driver_silent", device.name, "its driver does not answer", good=False)
        else:
            self._silent.discard(device.name)
            log.info("the INDI driver of %s answers again", device.name)
            self._report("driver_back", device.name, "its driver answers again", good=True)
