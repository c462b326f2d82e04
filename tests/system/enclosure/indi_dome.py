"""A scriptable INDI driver under a real indiserver: dome, telescope and weather station.

    python indi_dome.py LEDGER ORDERS SPEED STATE

INDI's own simulators cannot stick, lie or repeat old values. This one moves the models of
`talaia.sim.observatory`, takes the same orders, and writes the same ledger. It speaks INDI's XML
on its standard input and output. STATE keeps where the shutter stands over a crash of the driver.
"""

from __future__ import annotations

import os
import select
import sys
import time
from datetime import UTC, datetime
from pathlib import Path
from xml.etree.ElementTree import Element, SubElement, XMLPullParser, tostring

from talaia.sim.observatory.control_pipe import ControlPipe, act_on
from talaia.sim.observatory.models.ticket import Ticket
from talaia.sim.observatory.request_log import RequestLog
from talaia.sim.observatory.servers.base import Server, Stamped
from talaia.sim.observatory.servers.catalog import make_server
from talaia.sim.observatory.servers.dome import DomeServer
from talaia.sim.observatory.servers.telescope import TelescopeServer
from talaia.sim.observatory.servers.weather import WeatherServer

STEP_S = 0.05
EVERY_S = 0.5
NAMES = {"dome": "Trial Dome", "telescope": "Trial Telescope", "weather": "Trial Weather"}
# By property: what a switch that is set asks of which server.
ACTS = {
    ("DOME_SHUTTER", "SHUTTER_OPEN"): "open",
    ("DOME_SHUTTER", "SHUTTER_CLOSE"): "close",
    ("DOME_ABORT_MOTION", "ABORT"): "stop",
    ("TELESCOPE_PARK", "PARK"): "park",
    ("TELESCOPE_PARK", "UNPARK"): "unpark",
}
SHUTTER = {
    "closed": ("SHUTTER_CLOSE", "Ok"),
    "closing": ("SHUTTER_CLOSE", "Busy"),
    "opened": ("SHUTTER_OPEN", "Ok"),
    "opening": ("SHUTTER_OPEN", "Busy"),
    "error": ("", "Alert"),
    "stopped": ("", "Idle"),
}
VALUES = ("clouds", "rain", "wind", "gust", "humidity", "dew_point", "temperature")


class Device:
    """One device, as INDI sees it."""

    def __init__(self, server: Server, ledger: RequestLog) -> None:
        """Take the model and where to write down."""
        self.server = server
        self.name = NAMES[server.name]
        self.ledger = ledger
        self.connected = False
        self.lying: list[Element] = []
        self._waiting: list[tuple[str, Ticket]] = []
        self._truth = ""
        self._shown = ""

    # ── what it has ──

    def vectors(self) -> dict[str, tuple[str, str, dict[str, str]]]:
        """Give kind, state and elements by property."""
        on = {"CONNECT": _on(self.connected), "DISCONNECT": _on(not self.connected)}
        found = {"CONNECTION": ("Switch", "Ok", on)}
        if not self.connected:
            return found
        if isinstance(self.server, DomeServer):
            model = self.server.model
            which, state = SHUTTER[model.state]
            ways = ("SHUTTER_OPEN", "SHUTTER_CLOSE")
            found["DOME_SHUTTER"] = ("Switch", state, {x: _on(x == which) for x in ways})
            found["DOME_ABORT_MOTION"] = ("Switch", "Ok", {"ABORT": "Off"})
            numbers = {
                "CLOSED": float(model.closed),
                "POSITION": model.position * 100.0,
                "LOCAL": float(model.local),
            }
            found["DOME_SENSORS"] = ("Number", "Ok", {x: repr(y) for x, y in numbers.items()})
        elif isinstance(self.server, TelescopeServer):
            at = self.server.model.state
            parks = at in ("parked", "parking")
            elements = {"PARK": _on(parks), "UNPARK": _on(not parks)}
            found["TELESCOPE_PARK"] = ("Switch", "Busy" if at == "parking" else "Ok", elements)
        elif isinstance(self.server, WeatherServer):
            said = self.server.topic_values()
            values = {each.upper(): repr(said[each]) for each in VALUES}
            found["WEATHER_PARAMETERS"] = ("Number", "Ok", values)
        return found

    def _stamp(self) -> str:
        stamped = self.server.topic_values().get("stamped")
        unix_s = stamped.unix_s if isinstance(stamped, Stamped) else time.time()
        return datetime.fromtimestamp(unix_s, UTC).strftime("%Y-%m-%dT%H:%M:%S.%f")[:-3]

    def define(self, only: str = "") -> None:
        """Tell what there is."""
        for name, (kind, state, elements) in self.vectors().items():
            if only in ("", name):
                more = {"perm": "rw" if kind == "Switch" else "ro", "timeout": "60"}
                if kind == "Switch":
                    more["rule"] = "AtMostOne"
                more |= {"label": name, "group": "Main"}
                self._send(f"def{kind}Vector", name, state, f"def{kind}", elements, more)

    def show(self, *names: str) -> None:
        """Tell how it stands."""
        for name, (kind, state, elements) in self.vectors().items():
            if not names or name in names:
                self._send(f"set{kind}Vector", name, state, f"one{kind}", elements, {})

    def _send(
        self,
        tag: str,
        name: str,
        state: str,
        one: str,
        elements: dict[str, str],
        more: dict[str, str],
    ) -> None:
        vector = Element(
            tag, device=self.name, name=name, state=state, timestamp=self._stamp(), **more
        )
        for each, value in elements.items():
            part = SubElement(vector, one, name=each)
            if one == "defNumber":
                part.attrib |= {"format": "%g", "min": "0", "max": "0", "step": "0", "label": each}
            part.text = value
        sys.stdout.buffer.write(tostring(vector) + b"\n")
        sys.stdout.buffer.flush()

    # ── what it is told ──

    def take(self, message: Element) -> None:
        """Take a message; one that hangs leaves it lying."""
        if self.server.hanging:
            self.lying.append(message)
        elif message.tag == "getProperties":
            self.define(message.get("name", ""))
        else:
            self._set(message)

    def _set(self, message: Element) -> None:
        name = message.get("name", "")
        for part in message:
            if (part.text or "").strip() != "On":
                continue
            element = part.get("name", "")
            if name == "CONNECTION":
                before, self.connected = self.connected, element == "CONNECT"
                self.show("CONNECTION")
                if self.connected and not before:
                    self.define()
            elif (name, element) in ACTS and self.connected:
                self._act(ACTS[name, element])
        self.show(name)

    def _act(self, what: str) -> None:
        ticket = self.server.triggers[what]()
        phase = "answered" if ticket.ended else "asked"
        self.ledger.write_entry(self.server.name, what, phase, ticket.message, good=ticket.good)
        if not ticket.ended:
            self._waiting.append((what, ticket))

    def obey(self, words: str) -> None:
        """Do an order; see `talaia.sim.observatory.control_pipe`."""
        name = self.server.name
        ticket = act_on(self.server, words)
        if ticket is None:
            self.ledger.write_entry(name, words, "fault", self.server.inject_fault(words))
            return
        said = ticket.message or "by hand"
        self.ledger.write_entry(name, words.partition(" ")[2], "by hand", said, good=ticket.good)

    def step(self, seconds: float, *, publish: bool) -> None:
        """Let time pass, and tell."""
        self.server.pass_time(seconds, time.time())
        if self.server.truth != self._truth:
            self._truth = self.server.truth
            self.ledger.write_entry(self.server.name, "truth", "truth", self._truth)
        if self.server.hanging:
            return
        while self.lying:
            self.take(self.lying.pop(0))
        for each in [each for each in self._waiting if each[1].ended]:
            self._waiting.remove(each)
            what, ticket = each
            phase = "done" if ticket.good else "failed"
            self.ledger.write_entry(self.server.name, what, phase, ticket.message, good=ticket.good)
        shown = self.server.model.state if isinstance(self.server, DomeServer) else ""
        if self.connected and (publish or shown != self._shown):
            self._shown = shown
            self.show()


def _on(yes: bool) -> str:  # noqa: FBT001 - a switch's value
    return "On" if yes else "Off"


def main(ledger: str, orders_file: str, speed: str, state: str) -> None:
    """Run until the server ends."""
    kept, orders = Path(state), ControlPipe(Path(orders_file))
    beside = kept.with_suffix(".new")
    book = RequestLog(Path(ledger))
    devices = [
        Device(make_server(x, seed=1, unix_s=time.time(), call=lambda *_: Ticket.refused("")), book)
        for x in NAMES
    ]
    dome = devices[0].server
    assert isinstance(dome, DomeServer)
    if kept.exists():
        dome.model.position = float(kept.read_text().split()[1])
    words = XMLPullParser(["start", "end"])
    words.feed("<indi>")
    depth = tick = 0
    before = time.monotonic()
    while True:
        if select.select([0], [], [], STEP_S)[0]:
            data = os.read(0, 65536)
            if not data:
                return
            words.feed(data)
            for event, element in words.read_events():
                depth += 1 if event == "start" else -1
                if event == "end" and depth == 1:
                    for each in devices:
                        if element.get("device", each.name) == each.name:
                            each.take(element)
        for name, rest in orders.read_orders():
            for each in devices:
                if each.server.name == name:
                    each.obey(rest)
        now = time.monotonic()
        if now - before >= STEP_S:
            tick += 1
            for each in devices:
                each.step(
                    min(now - before, 1.0) * float(speed),
                    publish=tick % round(EVERY_S / STEP_S) == 0,
                )
            beside.write_text(f"{os.getpid()} {dome.model.position}")
            beside.replace(kept)
            before = now


if __name__ == "__main__":
    main(*sys.argv[1:])
