"""The serial example, against a peer that speaks the transmitter's text protocol over a pty."""

from __future__ import annotations

import asyncio
import os
import pty
import tty
from typing import TYPE_CHECKING

from .adapter_bench import adapting

if TYPE_CHECKING:
    from pathlib import Path

SITE = """
talaia: 1
site: dome
name: Dome
connections:
  weather:
    kind: extension
    extension: ptu200
    # A pty has no parity.
    keys: {{port: {port}, poll: 0.05, timeout: 5, frame: 8N1}}
devices:
  station:
    name: Station
    kind: weather
    signals:
      pressure: {{name: P, unit: hPa, source: {{keys: {{quantity: pressure}}}}}}
      temperature: {{name: T, unit: °C, source: {{keys: {{quantity: temperature}}}}}}
      humidity: {{name: H, unit: "%", source: {{keys: {{quantity: humidity}}}}}}
"""


class Transmitter:
    """A PTU200 at the other end of a pty."""

    def __init__(self) -> None:
        """Begin with a measurement of its own manual's kind."""
        self.line, peer = pty.openpty()
        tty.setraw(peer)
        self.port = os.ttyname(peer)
        self._peer = peer
        self.answer = b"  1010.3   21.5   45.2\r\n"
        self.asked: list[bytes] = []
        asyncio.get_running_loop().add_reader(self.line, self._hear)

    def _hear(self) -> None:
        for word in os.read(self.line, 1024).split(b"\r"):
            if word == b"SEND":
                # In two pieces, as a slow line brings it.
                os.write(self.line, self.answer[:9])
                os.write(self.line, self.answer[9:])
            if word:
                self.asked.append(word)

    def close(self) -> None:
        asyncio.get_running_loop().remove_reader(self.line)
        os.close(self.line)
        os.close(self._peer)


async def test_a_weather_sensor_on_a_serial_line_is_read(beside: Path, tmp_path: Path) -> None:
    sensor = Transmitter()
    async with adapting(SITE.format(port=sensor.port), tmp_path) as bench:
        await bench.until(lambda: len(bench.values) == 3)
        assert bench.values == {
            "station/pressure": 1010.3, "station/temperature": 21.5, "station/humidity": 45.2,
        }  # fmt: skip
        assert bench.ups
        # A sensor that has no value says so with asterisks; the others go on.
        sensor.answer = b"****.* -12.0 99.9\r\n"
        await bench.until(lambda: bench.values["station/temperature"] == -12.0)
        assert bench.values["station/pressure"] == 1010.3
        assert sensor.asked[0] == b"S"
    sensor.close()


async def test_a_sensor_that_is_silent_is_not_reached_and_is_read_again_when_it_is_back(
    beside: Path, tmp_path: Path
) -> None:
    sensor = Transmitter()
    said, sensor.answer = sensor.answer, b"                  "
    text = SITE.format(port=sensor.port).replace("timeout: 5", "timeout: 2")
    async with adapting(text, tmp_path) as bench:
        await bench.until(lambda: bench.lost)
        assert bench.lost[0] == f"the transmitter at {sensor.port} does not answer"
        sensor.answer = b"\r\n" + said
        await bench.until(lambda: len(bench.values) == 3)
    sensor.close()


async def test_a_line_that_is_not_there_is_told(beside: Path, tmp_path: Path) -> None:
    async with adapting(SITE.format(port="/dev/no_such_line"), tmp_path) as bench:
        await bench.until(lambda: bench.lost)
        assert bench.lost[0] == "/dev/no_such_line: No such file or directory"
