"""Who closes a roof of INDI, or of plain commands, whose gateway is dead or stands still.

ROS is in `test_watchdog`. What the roof did is in its own ledger, and where it stands is computed
by the roof; neither is the gateway's word.
"""

from __future__ import annotations

import asyncio
import contextlib
import json
import os
import shlex
import signal
import sys
from abc import ABC, abstractmethod
from collections.abc import AsyncIterator, Iterator
from email import message_from_bytes
from email.policy import default
from pathlib import Path

import psutil
import pytest
import yaml
from aiosmtpd.smtp import SMTP
from ports import free_port

from talaia.gateway.watchdog.feeding import dismiss_watchdog

from . import command_roof
from .conftest import need_indi
from .stack import Process, until

pytestmark = pytest.mark.timeout(150)
HERE = Path(__file__).parent
# As short as a gateway on a machine that others use is never late (s).
AFTER_S = 4.0
SPEED = 20


class Site(ABC):
    """A roof and the gateway beside it, without any hub."""

    connection: dict[str, object]
    closed: dict[str, object]

    def __init__(self, folder: Path) -> None:
        """Begin the roof, closed."""
        self.folder = folder
        self.parts: list[Process] = []
        (folder / "key").write_text("a-key-that-no-hub-knows-of-forty-letters")
        (folder / "site.yaml").write_text(yaml.safe_dump(self.described()))

    @abstractmethod
    def devices(self) -> dict[str, object]:
        """Give its devices, as the description has them."""

    def described(self) -> dict[str, object]:
        return {
            "talaia": 1,
            "site": "hill",
            "name": "Hill",
            "connections": {"roof": self.connection},
            "devices": self.devices(),
            # Unsafe never: what closes here is the watchdog.
            "interlocks": {
                "away": {
                    "name": "Away",
                    "when": [{"link_lost": 3600}],
                    "refuse": ["dome/open"],
                    "dwell": 1,
                }
            },
            "enclosures": {
                "dome": {
                    "name": "Dome",
                    "unsafe": ["away"],
                    "closed": [self.closed],
                    "close": {"command": "dome/close"},
                    "order": "close_first",
                    "move_within": 3,
                    "retries": 1,
                    "watchdog_after": AFTER_S,
                }
            },
        }

    @abstractmethod
    def position(self) -> float:
        """Give how far the roof is really open (0 to 1)."""

    @abstractmethod
    def asked(self) -> list[str]:
        """Give what the roof was asked."""

    @abstractmethod
    def open(self) -> None:
        """Open it at the roof itself."""

    def start_gateway(self, *more: str) -> Process:
        words = ["-m", "talaia", "gateway", str(self.folder / "site.yaml"), "--allow-plain"]
        words += ["--hub", f"ws://127.0.0.1:{free_port()}", "--data", str(self.folder / "gateway")]
        words += ["--key-file", str(self.folder / "key"), *more]
        gateway = Process(words, self.folder / "gateway.log", {})
        self.parts.append(gateway)
        return gateway

    async def supervised(self, *more: str) -> Process:
        """The roof is open under a gateway that lets it be, and has its watchdog."""
        gateway = self.start_gateway(*more)
        await gateway.says("interlock_released  away")
        await until(self.watchdog, what="a watchdog")
        await until(self.opened, what="the roof is open")
        return gateway

    def watchdog(self) -> int:
        try:
            return int((self.folder / "gateway" / "watchdog.lock").read_text() or 0)
        except (FileNotFoundError, ValueError):
            return 0

    def opened(self) -> bool:
        """Open it at the roof itself, and say whether it is open."""
        if self.position() == 0.0:
            self.open()
        return self.position() == 1.0

    def left_alone(self) -> bool:
        """Whether a watchdog watches, and closes nothing."""
        try:
            return not psutil.Process(self.watchdog()).children()
        except psutil.NoSuchProcess:
            return False

    def close(self) -> None:
        for part in reversed(self.parts):
            part.end()
        dismiss_watchdog(self.folder / "gateway" / "watchdog.lock")


class CommandSite(Site):
    """A command file of the founding observatory, in a description that adds the roof's rule."""

    connection = {"kind": "process", "file": "commands.json", "poll": 0.3, "timeout": 5}  # noqa: RUF012 - replaced, never changed
    closed = {"signal": "dome/status", "is": ["closed"]}  # noqa: RUF012

    def devices(self) -> dict[str, object]:
        words = [sys.executable, "-S", str(HERE / "command_roof.py"), str(self.folder)]
        commands = {
            "command": {"ros": shlex.join(words)},
            "devices": {
                "dome": {
                    "commands": {"info": {"status": "status"}, "open": "open", "close": "close"},
                    "messages": {
                        "status": {"opened": "the dome is opened", "closed": "the dome is closed"}
                    },
                }
            },
        }
        (self.folder / "commands.json").write_text(json.dumps(commands))
        return {}

    def position(self) -> float:
        return command_roof.position(self.folder)

    def asked(self) -> list[str]:
        lines = (self.folder / "ledger.jsonl").read_text().splitlines()
        return [json.loads(x)["asked"] for x in lines]

    def open(self) -> None:
        command_roof.main(str(self.folder), "open")


class IndiSite(Site):
    """The scriptable driver of `enclosure.indi_dome` under a real indiserver."""

    closed = {"signal": "dome/closed", "is": ["yes"]}  # noqa: RUF012

    def __init__(self, folder: Path) -> None:
        """Begin the server."""
        self.folder = folder
        self.ledger, self.orders = self.folder / "ledger.jsonl", self.folder / "orders"
        os.mkfifo(self.orders)
        self._fifo = os.open(self.orders, os.O_RDWR | os.O_NONBLOCK)
        self.state = self.folder / "driver"
        driver = [sys.executable, str(HERE / "enclosure" / "indi_dome.py")]
        driver += [str(self.ledger), str(self.orders), str(SPEED), str(self.state)]
        starter = self.folder / "indi_trial"
        starter.write_text(f"#!/bin/sh\nexec {shlex.join(driver)}\n")
        starter.chmod(0o755)
        port = free_port()
        server = ["indiserver", "-p", str(port), "-u", str(self.folder / "indi"), str(starter)]
        code = f"import os; os.execvp('indiserver', {server!r})"
        self.connection = {"kind": "indi", "host": "127.0.0.1", "port": port}
        self.server = Process(["-c", code], folder / "indi.log", {"HOME": str(folder)})
        super().__init__(folder)
        self.parts.append(self.server)

    def devices(self) -> dict[str, object]:
        def switch(name: str, element: str) -> dict[str, object]:
            return {
                "name": name, "kind": "indi", "target": "DOME_SHUTTER",
                "fixed": {element: True}, "timeout": 30,
            }  # fmt: skip

        closed = {"name": "Closed", "type": "state", "states": ["no", "yes"], "max_age": 4}
        source = {"property": "DOME_SENSORS", "element": "CLOSED"}
        dome = {"name": "Dome", "kind": "dome", "indi": "Trial Dome"}
        commands = {
            "open": switch("Open", "SHUTTER_OPEN"), "close": switch("Close", "SHUTTER_CLOSE"),
        }  # fmt: skip
        # All that the driver has: what was found besides would make the description anew.
        others = {
            name: {"name": name.title(), "indi": f"Trial {name.title()}"}
            for name in ("telescope", "weather")
        }
        signals = {"closed": {**closed, "source": source}}
        return {"dome": {**dome, "signals": signals, "commands": commands}, **others}

    def position(self) -> float:
        with contextlib.suppress(OSError, IndexError):
            return float(self.state.read_text().split()[1])
        return -1.0

    def asked(self) -> list[str]:
        lines = [json.loads(x) for x in self.ledger.read_text().splitlines()]
        return [x["asked"] for x in lines if x["device"] == "dome" and x["phase"] == "asked"]

    def open(self) -> None:
        os.write(self._fifo, b"dome do open\n")

    def close(self) -> None:
        super().close()
        os.close(self._fifo)


@pytest.fixture(params=["INDI", "commands"])
def site(request: pytest.FixtureRequest, tmp_path: Path) -> Iterator[Site]:
    if request.param == "INDI":
        need_indi()
    running = (IndiSite if request.param == "INDI" else CommandSite)(tmp_path)
    try:
        yield running
    finally:
        running.close()


async def test_a_roof_is_closed_for_a_gateway_that_stands_still_and_for_one_that_is_killed(
    site: Site,
) -> None:
    gateway = await site.supervised()
    os.kill(gateway.popen.pid, signal.SIGSTOP)
    try:
        await until(lambda: site.position() == 0.0, what="closed for the frozen gateway")
    finally:
        os.kill(gateway.popen.pid, signal.SIGCONT)
    await gateway.says("watchdog_closes watchdog:")
    await until(site.left_alone, what="nothing closes beside the gateway")
    # A command that the watchdog began last may still be on its way.
    await until(site.opened, what="open again")
    asked = site.asked().count("close")
    gateway.kill()
    await until(lambda: site.asked().count("close") > asked, what="closed for the killed gateway")
    await until(lambda: site.position() == 0.0, what="closed")


class Mailbox:
    """A mail server's folder: the subjects of what it got."""

    def __init__(self) -> None:
        """Begin empty."""
        self.subjects: list[str] = []

    async def handle_DATA(self, _server, _session, envelope) -> str:  # noqa: N802 - aiosmtpd's name
        message = message_from_bytes(envelope.original_content, policy=default)
        self.subjects.append(message["Subject"])
        return "250 OK"


@contextlib.asynccontextmanager
async def roof_with_mail(folder: Path) -> AsyncIterator[tuple[CommandSite, list[str], Process]]:
    """A roof of commands, the subjects of the mails that its site sent, and the gateway.

    The gateway itself would not tell people of anything within a test.
    """
    mailbox = Mailbox()
    loop = asyncio.get_running_loop()
    mail = await loop.create_server(lambda: SMTP(mailbox, hostname="test"), "127.0.0.1", 0)
    port = mail.sockets[0].getsockname()[1]
    (folder / "notices.toml").write_text(
        f'after = 86400\n[[mail]]\nserver = "127.0.0.1"\nport = {port}\nsecurity = "none"\n'
        'sender = "roof@example.org"\nto = ["anna@example.org"]\n'
    )
    site = CommandSite(folder)
    try:
        gateway = await site.supervised("--notices", str(folder / "notices.toml"))
        yield site, mailbox.subjects, gateway
    finally:
        site.close()
        mail.close()


async def test_people_are_told_that_the_watchdog_closes_a_roof_that_it_cannot_and_that_it_has(
    tmp_path: Path,
) -> None:
    async with roof_with_mail(tmp_path) as (site, subjects, gateway):
        stuck = tmp_path / "roof stuck"
        stuck.touch()
        gateway.kill()
        await until(lambda: len(subjects) >= 2, what="two notices")
        gone = "the gateway is dead or stands still"
        assert f"Hill: {gone.capitalize()}; the watchdog closes the roof (Dome)" in subjects
        assert any(
            x.startswith("Hill: Dome: NOT CLOSED") and x.endswith(f"({gone})") for x in subjects
        )
        stuck.unlink()
        await until(lambda: site.position() == 0.0, what="closed")
        await until(lambda: len(subjects) >= 4, what="two more")
        has = "Hill: The watchdog has closed the roof (Dome), as its sensors say"
        assert f"{has}; the gateway is still away" in subjects
        assert any(x.startswith("Hill: over: Dome: NOT CLOSED") for x in subjects)


async def test_people_are_told_of_a_closing_that_ended_with_an_error_and_it_is_begun_again(
    tmp_path: Path,
) -> None:
    async with roof_with_mail(tmp_path) as (site, subjects, gateway):
        stuck = tmp_path / "roof stuck"
        stuck.touch()
        gateway.kill()
        await until(lambda: len(subjects) >= 1, what="a notice that it closes")
        watchdog = psutil.Process(site.watchdog())
        [closing] = watchdog.children()
        closing.kill()
        failed = "closing ended once with an error (ended by signal 9)"
        await until(lambda: any(failed in x for x in subjects), what=failed)
        [again] = watchdog.children()
        assert again.pid != closing.pid
        stuck.unlink()
        await until(lambda: site.position() == 0.0, what="closed by the one begun again")
