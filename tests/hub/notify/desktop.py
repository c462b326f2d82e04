"""A desktop's notification service, on a message bus of its own: what is shown, and a click on it.

A real Chromium shows its notifications by the desktop's service (freedesktop.org, *Desktop
Notifications*) and hears from it that somebody clicked. So the click here is one that Chromium
takes for a person's: only after such a one may a service worker open a window.
"""

# ruff: noqa: D107

from __future__ import annotations

import asyncio
from typing import NamedTuple

from jeepney import DBusAddress, MessageType, new_method_return, new_signal
from jeepney.bus_messages import message_bus
from jeepney.io.asyncio import open_dbus_connection

__all__ = ["Desktop", "Shown"]

_NAME = "org.freedesktop.Notifications"
_AT = DBusAddress("/org/freedesktop/Notifications", _NAME, _NAME)


class Shown(NamedTuple):
    """A notification on the screen."""

    number: int
    title: str
    text: str


class Desktop:
    """Shows notifications, and clicks on them."""

    def __init__(self) -> None:
        self.shown: asyncio.Queue[Shown] = asyncio.Queue()
        self.address = ""
        self._count = 0

    async def open(self) -> None:
        """Start the bus and serve."""
        self._bus = await asyncio.create_subprocess_exec(
            "dbus-daemon", "--session", "--nofork", "--nopidfile", "--nosyslog", "--print-address",
            stdout=asyncio.subprocess.PIPE, stderr=asyncio.subprocess.DEVNULL,
        )  # fmt: skip
        assert self._bus.stdout is not None
        self.address = (await self._bus.stdout.readline()).decode().strip()
        self._connection = await open_dbus_connection(self.address)
        await self._connection.send(message_bus.RequestName(_NAME))
        self._serving = asyncio.create_task(self._serve())

    async def close(self) -> None:
        """End the bus."""
        self._serving.cancel()
        await self._connection.close()
        self._bus.terminate()
        await self._bus.wait()

    async def click(self, shown: Shown) -> None:
        """Click on a notification."""
        await self._connection.send(
            new_signal(_AT, "ActionInvoked", "us", (shown.number, "default"))
        )

    async def _serve(self) -> None:
        while True:
            message = await self._connection.receive()
            if message.header.message_type is MessageType.method_call:
                await self._connection.send(self._answer(message))

    def _answer(self, asked):
        fields = asked.header.fields
        # Field 3 of a D-Bus message is the method's name.
        match fields.get(3):
            case "GetCapabilities":
                return new_method_return(asked, "as", (["actions", "body"],))
            case "GetServerInformation":
                return new_method_return(asked, "ssss", ("test", "test", "1", "1.2"))
            case "Notify":
                self._count += 1
                self.shown.put_nowait(Shown(self._count, asked.body[3], asked.body[4]))
                return new_method_return(asked, "u", (self._count,))
            case _:
                return new_method_return(asked)
