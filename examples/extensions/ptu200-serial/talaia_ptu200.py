"""An adapter for Vaisala's PTU200 (pressure, temperature, humidity) on a serial line.

The transmitter is asked with ``SEND`` and answers with one line, ``1010.3 21.5 45.2`` as it leaves
the factory: pressure (hPa), temperature (°C), relative humidity (%).
"""

from __future__ import annotations

import asyncio
import os
import re
import termios
from typing import TYPE_CHECKING, Literal

from talaia.extend.adapter import AdapterExtension, ConnectionLost, ExtensionKeys

if TYPE_CHECKING:
    from talaia.extend.adapter import AdapterHost

QUANTITIES = ("pressure", "temperature", "humidity")
MAX_LINE = 1024
_NUMBER = re.compile(rb"[+-]?\d+(?:\.\d+)?|\*[*.]*")
_FRAMES = {"7E1": termios.CS7 | termios.PARENB, "8N1": termios.CS8}
_BAUDS = {
    1200: termios.B1200, 2400: termios.B2400, 4800: termios.B4800, 9600: termios.B9600,
    19200: termios.B19200,
}  # fmt: skip


class Ptu200Connection(ExtensionKeys, frozen=True, kw_only=True):
    """The serial line.

    Attributes:
        port: the device file: /dev/ttyUSB0, or /dev/serial/by-id/….
        baud: bits a second.
        frame: data bits, parity and stop bits; 7E1 as it leaves the factory.
        poll: it is asked so often (s).
        timeout: without an answer for so long it is not reached (s).

    """

    port: str
    baud: Literal[1200, 2400, 4800, 9600, 19200] = 9600
    frame: Literal["7E1", "8N1"] = "7E1"
    poll: float = 5.0
    timeout: float = 3.0

    def __post_init__(self) -> None:
        """Refuse what makes no sense."""
        if not self.port.startswith("/dev/"):
            raise ValueError("port: expected a device file such as /dev/ttyUSB0")
        if not (self.poll > 0 and self.timeout > 0):
            raise ValueError("expected poll and timeout above 0")


class Ptu200Source(ExtensionKeys, frozen=True, kw_only=True):
    """Which of its values a signal is.

    Attributes:
        quantity: pressure (hPa), temperature (°C) or humidity (%).

    """

    quantity: Literal["pressure", "temperature", "humidity"]


class Ptu200:
    """Asks the transmitter again and again."""

    def __init__(self, keys: Ptu200Connection, host: AdapterHost) -> None:
        """Nothing is opened yet."""
        self._keys, self._host = keys, host

    async def run(self) -> None:
        """Open the line, and publish what is answered."""
        loop = asyncio.get_running_loop()
        line = self._open()
        heard = asyncio.Queue[bytes]()
        loop.add_reader(line, lambda: heard.put_nowait(_read(line)))
        try:
            # Ends what it may be sending by itself.
            os.write(line, b"S\r")
            while True:
                await self._measure(line, heard)
                await asyncio.sleep(self._keys.poll)
        finally:
            loop.remove_reader(line)
            os.close(line)

    async def execute(self, request: object) -> str:
        """Do nothing: it declares no commands."""
        raise AssertionError(request)

    def _open(self) -> int:
        try:
            line = os.open(self._keys.port, os.O_RDWR | os.O_NOCTTY | os.O_NONBLOCK)
        except OSError as error:
            raise ConnectionLost(f"{self._keys.port}: {error.strerror}") from error
        try:
            speed = _BAUDS[self._keys.baud]
            mode = _FRAMES[self._keys.frame] | termios.CREAD | termios.CLOCAL
            none: list[bytes | int] = [b"\0"] * 32
            termios.tcsetattr(line, termios.TCSANOW, [0, 0, mode, 0, speed, speed, none])
        except termios.error as error:
            os.close(line)
            raise ConnectionLost(f"{self._keys.port} is no serial line: {error}") from error
        return line

    async def _measure(self, line: int, heard: asyncio.Queue[bytes]) -> None:
        while not heard.empty():
            heard.get_nowait()
        os.write(line, b"SEND\r")
        try:
            async with asyncio.timeout(self._keys.timeout):
                values = await self._answer(heard)
        except TimeoutError:
            raise ConnectionLost(f"the transmitter at {self._keys.port} does not answer") from None
        for signal in self._host.signals:
            value = values[signal.keys.quantity]  # type: ignore[attr-defined]
            if value is not None:
                self._host.publish(signal.address, value)
        self._host.connected()

    async def _answer(self, heard: asyncio.Queue[bytes]) -> dict[str, float | None]:
        """Wait for a line of three numbers; asterisks stand for a sensor that has none."""
        text = b""
        while True:
            piece = await heard.get()
            if not piece:
                raise ConnectionLost(f"{self._keys.port} was pulled out")
            text = (text + piece)[-MAX_LINE:]
            *lines, text = re.split(rb"[\r\n]+", text)
            for each in lines:
                words = _NUMBER.findall(each)
                if len(words) == len(QUANTITIES):
                    numbers = [None if word.startswith(b"*") else float(word) for word in words]
                    return dict(zip(QUANTITIES, numbers, strict=True))


def _read(line: int) -> bytes:
    try:
        return os.read(line, MAX_LINE)
    except OSError:
        return b""


extension = AdapterExtension(
    api=1,
    summary="Vaisala PTU200: pressure, temperature and humidity on a serial line",
    connection=Ptu200Connection,
    source=Ptu200Source,
    make=Ptu200,
)
