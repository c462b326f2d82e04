"""A simulated observatory and the gateway beside it, without any hub."""

from __future__ import annotations

import itertools
import json
import time
from pathlib import Path
from typing import Any

from patience import PATIENCE_S
from ports import free_port

from talaia.gateway.watchdog.feeding import dismiss_watchdog
from talaia.model.yaml_text.load import dump_site, load_site
from talaia.sim import ros_domain
from talaia.sim.observatory.night import at_night, longitude_of_night

from .stack import Process, until

EXAMPLE = Path(__file__).parents[2] / "examples" / "observatory" / "site.yaml"
SPEED = 4


class Observatory:
    """Processes of one observatory in a folder; the hub's port is one where nobody answers."""

    def __init__(
        self, folder: Path, description: str = "", *, ros1: bool = False, hours: int = 0,
        roof: str = "dome", speed: int = SPEED,
    ) -> None:  # fmt: skip
        """Start the simulator, as ROS 2 or ROS 1 nodes; see `start_gateway`.

        It stands where it is so many hours after midnight, under a roof of that kind, and moves so
        many times as fast.
        """
        self._roof, self._speed = roof, speed
        self.folder = folder
        self._ros1 = ["--ros1"] if ros1 else []
        self._clients = itertools.count()
        self._world = ros_domain.reserve_domain()
        self.environment = ros_domain.domain_environment(self._world.domain)
        if ros1:
            uri = f"http://127.0.0.1:{free_port()}"
            self.environment = {
                "ROS_MASTER_URI": uri, "ROS_IP": "127.0.0.1", "ROS_HOME": str(folder)
            }  # fmt: skip
        self.ledger_file = folder / "ledger.jsonl"
        # It observes by night only; tests run by day, too.
        self._now = time.time() - 3600 * hours
        site = at_night(load_site(description or EXAMPLE.read_text()), self._now)
        (folder / "site.yaml").write_text(dump_site(site))
        (folder / "key").write_text("a-key-that-no-hub-knows-of-forty-letters")
        self.parts: list[Process] = [self._simulator()]

    def _simulator(self, *more: str) -> Process:
        words = ["-m", "talaia", "sim", "observatory", "--speed", str(self._speed)]
        words += self._ros1 or ["--domain", str(self._world.domain)]
        words += ["--longitude", str(longitude_of_night(self._now))]
        words += ["--enclosure", self._roof, "--log", str(self.ledger_file)]
        words += ["--orders", str(self.folder / "orders"), *more]
        return Process(words, self.folder / "sim.log", self.environment)

    def start_gateway(self, *more: str) -> Process:
        nobody = free_port()
        words = ["-m", "talaia", "gateway", str(self.folder / "site.yaml"), "--allow-plain"]
        words += ["--hub", f"ws://127.0.0.1:{nobody}", "--key-file", str(self.folder / "key")]
        words += ["--data", str(self.folder / "gateway"), *more]
        words += ["--ros-domain", str(self._world.domain)]
        gateway = Process(words, self.folder / "gateway.log", self.environment)
        self.parts.append(gateway)
        return gateway

    @property
    def words(self) -> list[str]:
        """The prefix of a client's words, in place of ``ros2 run``."""
        return ["-m", "talaia", "sim", "run", *self._ros1]

    def client(self, *words: str, within: float = PATIENCE_S) -> str:
        """What a client of a person on site says."""
        log = self.folder / f"client-{next(self._clients)}.log"
        client = Process([*self.words, *words], log, self.environment)
        try:
            client.popen.wait(within)
        finally:
            client.end()
        return client.said()

    def fault(self, words: str) -> None:
        """Bring a fault about with the client of a person on site."""
        assert words in self.client("observatory_servcli", "client", "fault", *words.split())

    async def cause_fault(self, words: str) -> None:
        """Bring a fault about as `fault` does, without a program of its own; it is there then."""
        begun = time.monotonic_ns()
        self.order(words)
        device, _, fault = words.partition(" ")
        what = {"device": device, "asked": fault, "phase": "fault"}
        await until(
            lambda: any(
                line["t"] > begun and what.items() <= line.items() for line in self.ledger()
            ),
            what=words,
        )

    def order(self, words: str) -> None:
        """Bring a fault about, or act by hand, at once and without a program of its own."""
        with (self.folder / "orders").open("w") as pipe:
            pipe.write(f"{words}\n")

    def ledger(self) -> list[dict[str, Any]]:
        return [json.loads(line) for line in self.ledger_file.read_text().splitlines()]

    def asked(self, device: str, what: str, since: int = 0) -> list[dict[str, Any]]:
        """What a server was asked after a moment (monotonic, ns)."""
        return [
            each
            for each in self.ledger()
            if each["device"] == device and each["asked"] == what and each["t"] > since
        ]

    def note(self, words: str) -> list[str]:
        """What the gateway has said with these words in it."""
        said = (self.folder / "gateway.log").read_text()
        return [line for line in said.splitlines() if words in line]

    def silence_before_closing_s(self) -> float:
        """How long the watchdog had heard nothing when it began to close, by its own clock."""
        (said, *_) = self.note("talaia watchdog: the gateway is dead or stands still")
        return float(said.partition("nothing heard for ")[2].partition(" s")[0])

    async def told(self, words: str, within: float) -> None:
        await until(lambda: self.note(words), within, words)

    def close(self) -> None:
        for part in reversed(self.parts):
            part.end()
        # That of a gateway that was killed.
        dismiss_watchdog(self.folder / "gateway" / "watchdog.lock")
        self._world.release()
