"""One simulated observatory, its gateway, and a hub of ours, used again for many trials.

The hub is `tests/gateway/fake_hub.py`: people ask through it, and what a person is told comes to
it. What the roof did is in the simulator's ledger alone. Each world has a ROS domain of its own.

Long, because all that can be done to the parts of one world stands together.
"""

from __future__ import annotations

import asyncio
import contextlib
import errno
import fcntl
import itertools
import json
import os
import shlex
import shutil
import signal
import subprocess
import sys
import time
from pathlib import Path

from ports import free_port
from websockets.asyncio.server import Server, serve
from websockets.exceptions import ConnectionClosed

from talaia.gateway.watchdog.feeding import dismiss_watchdog
from talaia.model.yaml_text.load import load_site
from talaia.sim.observatory.night import longitude_of_night
from talaia.wire.columns import unpack_columns
from talaia.wire.frames import (
    CommandPhase,
    CommandRequest,
    CommandState,
    Event,
    FromGateway,
    InterlockState,
    OverrideRequest,
    SampleBatch,
)

from ..observatory import Observatory
from ..stack import Process
from .description import SPEED, described
from .judge import Line, truth_at

sys.path.insert(0, str(Path(__file__).parents[2] / "gateway"))
from fake_hub import FakeHub

DRIVER = Path(__file__).with_name("indi_dome.py")
STARTER = Path(__file__).with_name("failing_disk.py")
KEY = "a-key-that-no-hub-knows-of-forty-letters"
DISK_MB = 4
WITHIN_S = 60.0
ENDED = frozenset(CommandPhase) - {CommandPhase.ACCEPTED, CommandPhase.RUNNING}


class Hub(FakeHub):
    """A hub that keeps no values: it lives for thousands of trials."""

    def __init__(self) -> None:
        """Know nobody yet."""
        super().__init__()
        self.key = KEY
        self.catalogue = lambda hello: [
            each.address for each in load_site(hello.description).channels()
        ]
        self._next: dict[str, int] = {}

    def below(self, boot: str) -> int:
        return self._next.get(boot, 0)

    def _store(self, frame: SampleBatch) -> None:
        size = len(unpack_columns(frame))
        self._next[frame.boot] = max(self.below(frame.boot), frame.first + size)

    async def _take(self, socket, message: FromGateway) -> None:
        await super()._take(socket, message)
        del self.messages[:-5000]


class World(Observatory):
    """See the module."""

    def __init__(self, folder: Path, protocol: str = "ROS 2", roof: str = "dome") -> None:
        """Start the simulator, with a roof of this kind; `open` brings up the rest."""
        self.orders_file = folder / "orders"
        os.mkfifo(self.orders_file)
        self.hub = Hub()
        self.port = free_port()
        self.url = f"ws://127.0.0.1:{self.port}"
        self._server: Server | None = None
        self._ids = itertools.count()
        self._lines: list[Line] = []
        self._read_to = 0
        self.states: dict[str, InterlockState] = {}
        self.gateway: Process | None = None
        self.data = folder / "gateway"
        self.trouble = folder / "disk-trouble"
        self.notices_file = folder / "notices.jsonl"
        self.data.mkdir()
        self.small_disk = _mount(self.data)
        self.protocol = protocol
        self.roof = roof
        self.indi_port = free_port()
        site = described(protocol, self.indi_port, roof)
        super().__init__(folder, site, ros1=protocol == "ROS 1", roof=roof)
        (folder / "notices.toml").write_text(
            f'after = 2\n\n[[command]]\nwords = ["/bin/sh", "-c", "cat >> {self.notices_file}"]\n'
        )
        self._orders = os.open(self.orders_file, os.O_RDWR | os.O_NONBLOCK)

    def _simulator(self, *more: str) -> Process:
        if self.protocol == "INDI":
            return self._indi()
        words = ["-m", "talaia", "sim", "observatory", "--speed", str(SPEED)]
        words += self._ros1 or ["--domain", str(self._world.domain)]
        words += ["--longitude", str(longitude_of_night(self._now))]
        words += ["--log", str(self.ledger_file), "--orders", str(self.orders_file)]
        words += ["--enclosure", self._roof]
        for device in ("dome", "telescope", "weather", "camera", "pdu"):
            words += ["--only", device]
        return Process([*words, *more], self.folder / "sim.log", self.environment)

    def _indi(self) -> Process:
        """Start a real indiserver with the scriptable driver."""
        words = [sys.executable, str(DRIVER), str(self.ledger_file), str(self.orders_file)]
        words += [str(SPEED), str(self.folder / "driver")]
        starter = self.folder / "indi_trial"
        starter.write_text(f"#!/bin/sh\nexec {shlex.join(words)}\n")
        starter.chmod(0o755)
        server = ["indiserver", "-p", str(self.indi_port), "-u", str(self.folder / "indi")]
        code = f"import os; os.execvp('indiserver', {[*server, str(starter)]!r})"
        return Process(["-c", code], self.folder / "sim.log", {"HOME": str(self.folder)})

    def driver_killed(self) -> int:
        """Kill the INDI driver, which the server starts again; gives the moment."""
        at = time.monotonic_ns()
        os.kill(self.driver(), signal.SIGKILL)
        return at

    def driver(self) -> int:
        """Give the INDI driver's process; 0 while its file is being written."""
        words = (self.folder / "driver").read_text().split()
        return int(words[0]) if words else 0

    # ── its parts ──

    async def open(self) -> None:
        """Start hub and gateway."""
        if self.protocol == "INDI":
            await self.until((self.folder / "driver").exists, "the driver")
        else:
            await self.parts[0].says("ready")
        await self.hub_up()
        await self.gateway_up()

    async def hub_up(self) -> None:
        hub = self.hub
        self._server = await serve(
            hub._serve,
            "127.0.0.1",
            self.port,
            process_request=hub._admit,
            compression=None,
            ping_interval=None,
            max_size=16 * 1024 * 1024,
            close_timeout=0.2,
        )

    async def hub_away(self) -> int:
        """Take the hub away as a lost cable does; gives the moment (monotonic, ns)."""
        assert self._server is not None
        at = time.monotonic_ns()
        for each in self.hub.links:
            each.transport.abort()
        self._server.close()
        self._server = None
        return at

    async def gateway_up(self, site: Path | None = None, data: Path | None = None) -> Process:
        """Start a gateway, and wait for its link."""
        links = len(self.hub.links)
        self.states.clear()
        words = [str(STARTER), "gateway", str(site or self.folder / "site.yaml"), "--allow-plain"]
        words += ["--hub", self.url, "--key-file", str(self.folder / "key")]
        words += ["--data", str(data or self.data), "--spool-mb", "1"]
        words += ["--notices", str(self.folder / "notices.toml")]
        if self.protocol == "ROS 2":
            words += ["--ros-domain", str(self._world.domain)]
        environment = {
            **self.environment,
            "TALAIA_DISK": str(self.data),
            "TALAIA_DISK_FAULT": str(self.trouble),
        }
        self.gateway = Process(words, self.folder / "gateway.log", environment)
        self.parts[1:] = [self.gateway]
        gateway = self.gateway
        await self.until(
            lambda: len(self.hub.links) > links or gateway.popen.poll() is not None, "a link"
        )
        assert gateway.popen.poll() is None, gateway.said()[-3000:]
        return gateway

    def alive(self) -> bool:
        return self.gateway is not None and self.gateway.popen.poll() is None

    # ── what is done to it ──

    def order(self, words: str) -> None:
        """Tell the simulator a fault; see `talaia.sim.observatory.control_pipe`."""
        os.write(self._orders, f"{words}\n".encode())

    async def fault_at(self, words: str) -> int:
        """Bring a fault about; gives its moment by the simulator (monotonic, ns)."""
        since = time.monotonic_ns()
        device, _, word = words.partition(" ")
        word = word.removeprefix("do ")
        self.order(words)

        def found() -> int:
            return next(
                (
                    each["t"]
                    for each in self.lines(since)
                    if each["device"] == device
                    and each["asked"] == word
                    and each["phase"] in ("fault", "by hand")
                ),
                0,
            )

        await self.until(found, words)
        return found()

    def signal(self, number: signal.Signals) -> int:
        """Send the gateway a signal; gives the moment just before."""
        assert self.gateway is not None
        at = time.monotonic_ns()
        self.gateway.popen.send_signal(number)
        return at

    def disk(self, trouble: str) -> None:
        """Make the gateway's disk full, read-only or failing; empty ends it."""
        ballast = self.data / "ballast"
        ballast.unlink(missing_ok=True)
        number = {"read-only": errno.EROFS, "failing": errno.EIO}.get(trouble, 0)
        if trouble == "full" and self.small_disk:
            with ballast.open("wb", buffering=0) as file, contextlib.suppress(OSError):
                while True:
                    file.write(bytes(512))
        elif trouble == "full":
            number = errno.ENOSPC
        self.trouble.write_text(f"{number}")

    # ── what people do ──

    async def ask(self, device: str, command: str, who: str = "Ada", **args: object) -> str:
        """Ask for a command through the hub; gives its id."""
        name = f"c{os.getpid()}-{time.monotonic_ns()}-{next(self._ids)}"
        await self.hub.send(
            CommandRequest(id=name, device=device, command=command, args=args, ttl_ms=5000, who=who)
        )
        return name

    async def ended(self, name: str, within: float = WITHIN_S) -> CommandState:
        """Wait for a command's end."""

        def found() -> CommandState | None:
            return next(
                (x for x in self.hub.of(CommandState) if x.id == name and x.phase in ENDED), None
            )

        await self.until(found, f"the end of {name}", within)
        state = found()
        assert state is not None
        return state

    async def does(self, device: str, command: str, who: str = "Ada", **args: object) -> str:
        """Ask, and give how it ended."""
        return str((await self.ended(await self.ask(device, command, who, **args))).phase)

    async def override(self, interlock: str, seconds: float) -> None:
        await self.hub.send(
            OverrideRequest(interlock=interlock, who="Ada", reason="a trial", seconds=seconds)
        )

    # ── what is seen ──

    def lines(self, since: int = 0) -> list[Line]:
        """Give the ledger's lines after a moment (monotonic, ns)."""
        if self.ledger_file.exists():
            with self.ledger_file.open("rb") as file:
                file.seek(self._read_to)
                data = file.read()
            whole = data[: data.rfind(b"\n") + 1]
            self._read_to += len(whole)
            self._lines += [json.loads(each) for each in whole.splitlines()]
        return [each for each in self._lines if each["t"] >= since]

    def truth(self) -> str:
        """Give how the roof really stands."""
        self.lines()
        return truth_at(self._lines, time.monotonic_ns())

    def locked(self) -> list[str]:
        """Give the interlocks that lock, or have said nothing yet."""
        for each in self.hub.of(InterlockState):
            self.states[each.interlock] = each
        names = ("rain", "weather", "daylight", "on_site")
        return [x for x in names if x not in self.states or self.states[x].locked]

    def overridden(self, interlock: str) -> bool:
        """Tell whether an interlock is overridden now."""
        self.locked()
        return interlock in self.states and self.states[interlock].override_ms > 0

    def events(self, since_wall_ns: int, *kinds: str) -> list[Event]:
        """Give what people were told after a moment (UTC, ns), of these kinds."""
        return [
            each
            for each in self.hub.of(Event)
            if each.kind in kinds and each.time_us * 1000 >= since_wall_ns
        ]

    async def until(self, holds, what: str, within: float = WITHIN_S) -> None:
        deadline = time.monotonic() + within
        while not holds():
            assert time.monotonic() < deadline, f"not within {within:g} s: {what}"
            await asyncio.sleep(0.03)

    # ── between two trials ──

    async def settle(self) -> None:
        """End every fault, and wait until the gateway lets anybody open."""
        self.disk("")
        for device in ("dome", "telescope", "weather", "camera", "pdu"):
            self.order(f"{device} ok")
        self.order("pdu do outlet1 on")
        self.order("pdu do outlet2 on")
        if self._server is None or not self._server.is_serving():
            await self.hub_up()
        if not self.alive():
            await self.gateway_up()
        self.signal(signal.SIGCONT)
        self.hub.messages[:] = [x for x in self.hub.messages if isinstance(x, InterlockState)][-40:]
        del self._lines[:-400]
        try:
            await self.until(lambda: not self.locked(), "released")
        except AssertionError as error:
            why = {x: self.states[x].why if x in self.states else "silent" for x in self.locked()}
            said = self.gateway.said()[-1500:] if self.gateway is not None else ""
            raise AssertionError(f"{error}: {why}\n{said}") from None

    async def opened(self, *, tracking: bool) -> None:
        """Let somebody open the roof through the gateway, and perhaps unpark and point."""
        await self._open()
        if tracking:
            await self.does("telescope", "unpark")
            self.order("telescope do goto_altaz 70 0")
        # Where the machine stood for longer than values count it has been closed again meanwhile.
        if self.truth() != "open":
            await self._open()

    async def _open(self) -> None:
        """Have a person open, for as long as it takes."""
        answers: list[str] = []
        ends = time.monotonic() + WITHIN_S
        while time.monotonic() < ends:
            # A gateway that stood still may have given up the link on which this goes.
            with contextlib.suppress(AssertionError, ConnectionClosed):
                ended = await self.ended(await self.ask("dome", "open"), 6.0)
                answers.append(f"{ended.phase} {ended.message}")
                if ended.phase is CommandPhase.SUCCEEDED and self.truth() == "open":
                    return
            await asyncio.sleep(0.5)
        raise AssertionError(f"not within {WITHIN_S:g} s: the roof is open: {answers[-3:]}")

    async def aclose(self) -> None:
        """End everything."""
        if self._server is not None:
            self._server.close()
        self.close()
        os.close(self._orders)
        lock = self.data / "watchdog.lock"
        with lock.open("ab") as held:
            dismiss_watchdog(lock)
            if self.small_disk:
                subprocess.run(["umount", "-l", str(self.data)], check=False)
            shutil.rmtree(self.folder, ignore_errors=True)
            # One that found the disk full could not say which process it is, so nobody can ask it
            # to end: it does so by itself when its file is gone.
            await self.until(lambda: _is_free(held.fileno()), "the watchdog's end")


def _is_free(lock: int) -> bool:
    try:
        fcntl.flock(lock, fcntl.LOCK_EX | fcntl.LOCK_NB)
    except BlockingIOError:
        return False
    return True


def _mount(folder: Path) -> bool:
    """Put a real small file system there, where this user may."""
    words = ["mount", "-t", "tmpfs", "-o", f"size={DISK_MB}m", "tmpfs", str(folder)]
    try:
        return subprocess.run(words, check=False, capture_output=True).returncode == 0
    except FileNotFoundError:
        return False
