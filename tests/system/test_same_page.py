"""One page for a dome, however it is reached: a person opens and closes it in a real Chromium.

Each time the page is the same, and behind it stands the real thing: the simulated observatory's
services of ROS 2 and of ROS 1, INDI's own dome simulator, and the founding design's JSON command
file with its command-line clients.
"""

from __future__ import annotations

import json
import re
import subprocess
import sys
from collections.abc import Callable, Iterator
from pathlib import Path
from typing import ClassVar

import msgspec
import pytest
from patience import PATIENCE_MS, PATIENCE_S
from playwright.sync_api import Browser, Locator, Page, expect
from ports import free_port

sys.path.insert(0, str(Path(__file__).parents[1] / "gateway"))
from observatory_site import as_ros1

from talaia.model.site import Site
from talaia.model.yaml_text.load import dump_site, read_site

from .conftest import need_indi, need_ros1, need_ros2
from .pages import picture, visit
from .stack import SITE, Process, Stack, finish

pytestmark = [pytest.mark.robot, pytest.mark.browser]

EXAMPLES = Path(__file__).parents[2] / "examples"
COMMANDS = Path(__file__).parents[1] / "wire" / "recorded" / "observatory_commands.json"
# Motions of the simulators, and the start of a client for each command.
MOVED_MS = 60_000


def only_dome(site: Site) -> Site:
    """The dome of an example without what looks at other devices: this is about its page."""
    dome = msgspec.structs.replace(site.devices["dome"], link_loss=None)
    return msgspec.structs.replace(
        site,
        site=SITE,
        devices={"dome": dome},
        interlocks={},
        enclosures={},
        alarms={},
        night=None,
    )


class Dome(Stack):
    """A hub, a gateway and a dome of the simulated observatory, by ROS 2 services."""

    needs: ClassVar[Callable[[], None]] = staticmethod(need_ros2)
    ready_word: ClassVar[str] = '"ready": true'
    # The description asks for a second yes.
    asks_again: ClassVar[bool] = True

    def __init__(self, folder: Path) -> None:
        """Start all three."""
        self.folder, self.port = folder, 0
        super().__init__(folder, self.describe(), {"driver": "operator"})

    def describe(self) -> str:
        return dump_site(only_dome(read_site(EXAMPLES / "observatory" / "site.yaml")))

    def words(self) -> list[str]:
        return ["--domain", str(self._world.domain)]

    def start_robot(self) -> Process:
        words = ["-m", "talaia", "sim", "observatory", "--speed", "6", "--only", "dome"]
        words += ["--log", str(self.ledger_file), *self.words()]
        return Process(words, self.folder / "dome.log", self._ros)

    async def ready(self) -> None:
        await self.robot.says(self.ready_word)
        await self.hub.says("ready")
        await self.gateway.says("linked to")

    def shutter(self) -> str:
        """Where the dome itself says that its shutter ended."""
        rows = [json.loads(line) for line in self.ledger_file.read_text().splitlines()]
        ends = [row["asked"] for row in rows if row["phase"] == "done"]
        return {"open": "open", "close": "closed"}[ends[-1]]


class Ros1Dome(Dome):
    """The same by ROS 1 services; the simulator brings its own master."""

    needs = staticmethod(need_ros1)

    def describe(self) -> str:
        port = free_port()
        self.more = {"ROS_MASTER_URI": f"http://127.0.0.1:{port}", "ROS_IP": "127.0.0.1"}
        self.more |= {"ROS_HOME": str(self.folder)}
        return dump_site(as_ros1(only_dome(read_site(EXAMPLES / "observatory" / "site.yaml"))))

    def words(self) -> list[str]:
        return ["--ros1"]


class CommandsDome(Dome):
    """The founding design's command file; its clients ask the ROS 2 services."""

    asks_again = False

    def describe(self) -> str:
        asked = json.loads(COMMANDS.read_text())
        asked["command"]["ros"] = f"{sys.executable} -m talaia sim run"
        # Each line is a client that is started once a second; one tells all that is needed here.
        del asked["devices"]["dome"]["commands"]["info"]["rt"]
        del asked["devices"]["dome"]["messages"]["rt"]
        asked["devices"] = {"dome": asked["devices"]["dome"]}
        (self.folder / "commands.json").write_text(json.dumps(asked))
        return (
            f"{{talaia: 1, site: {SITE}, name: Commands, "
            "connections: {commands: {kind: process, file: commands.json}}}"
        )


class IndiDome(Dome):
    """INDI's own simulator behind a real indiserver."""

    needs = staticmethod(lambda: need_indi("indi_simulator_dome", "indi_getprop"))
    ready_word = "listening to port"

    def describe(self) -> str:
        self.indi = free_port()
        site = only_dome(read_site(EXAMPLES / "indi" / "site.yaml"))
        links = {name: msgspec.structs.replace(each, port=self.indi)
                 for name, each in site.connections.items()}  # fmt: skip
        return dump_site(msgspec.structs.replace(site, connections=links))

    def start_robot(self) -> Process:
        words = ["indiserver", "-v", "-p", str(self.indi), "-u", str(self.folder / "indi")]
        become = f"import os; os.execvp('indiserver', {[*words, 'indi_simulator_dome']!r})"
        home = {**self._ros, "HOME": str(self.folder)}
        return Process(["-c", become], self.folder / "dome.log", home)

    def shutter(self) -> str:
        """Where the driver says that its shutter ended."""
        asked = "Dome Simulator.DOME_SHUTTER.SHUTTER_OPEN"
        is_open = subprocess.run(
            ["indi_getprop", "-1", "-p", str(self.indi), asked],
            capture_output=True, text=True, timeout=PATIENCE_S, check=True,
        )  # fmt: skip
        return "open" if is_open.stdout.strip() == "On" else "closed"


WAYS = {"ROS 2": Dome, "ROS 1": Ros1Dome, "INDI": IndiDome, "command file": CommandsDome}


@pytest.fixture(params=WAYS)
def dome(request: pytest.FixtureRequest, tmp_path: Path) -> Iterator[Dome]:
    kind = WAYS[request.param]
    kind.needs()
    running = kind(tmp_path)
    try:
        finish(running.ready())
        yield running
    finally:
        running.close()


def words(page: Page, *said: str) -> Locator:
    """One of these words, alone, somewhere on the page."""
    either = re.compile(rf"^\s*({'|'.join(said)})\s*$")
    return page.get_by_role("main").get_by_text(either).filter(visible=True).first


def press(page: Page, deed: str, *, asks_again: bool) -> None:
    """Press what the page has for a deed: a button of that name, or the one under that heading."""
    heading = page.get_by_role("heading", name=deed, exact=True)
    button = page.get_by_role("button", name=re.compile(r"^(Send|Open|Close)"))
    named = page.get_by_role("button", name=re.compile(rf"^{deed}\b"))
    under = page.locator("form").filter(has=heading).locator(button)
    there = named.or_(under).first
    expect(there).to_be_enabled(timeout=PATIENCE_MS)
    there.click()
    if asks_again:
        expect(page.get_by_role("dialog").filter(visible=True)).to_be_visible()
        # Its buttons stand in the page's own tree, not below the element with the role.
        page.locator("t-dialog[open]").locator(button).click()


def test_the_same_page_opens_and_closes_a_dome(
    dome: Dome, chrome: Browser, request: pytest.FixtureRequest
) -> None:
    page = visit(chrome, dome, "driver", width=1280, path=f"/sites/{SITE}/devices/dome")
    expect(page.get_by_role("heading", name="Dome", level=1)).to_be_visible()
    expect(words(page, "closed")).to_be_visible(timeout=PATIENCE_MS)
    press(page, "Open", asks_again=dome.asks_again)
    expect(words(page, "opened", "open")).to_be_visible(timeout=MOVED_MS)
    outcome = page.get_by_role("main").get_by_text(re.compile(r"\bsucceeded\b"))
    expect(outcome.filter(visible=True).first).to_be_visible(timeout=MOVED_MS)
    assert dome.shutter() == "open"
    picture(page, f"dome-{request.node.callspec.id}")
    press(page, "Close", asks_again=False)
    expect(words(page, "opened", "open", "closing", "moving")).not_to_be_visible(timeout=MOVED_MS)
    expect(words(page, "closed")).to_be_visible()
    assert dome.shutter() == "closed"
