"""Real gateways of several releases at a real hub: changed at rest, kept, and left again."""

from __future__ import annotations

import contextlib
import os
import select
import signal
import subprocess
import sys
import time
from collections.abc import Callable, Iterator
from pathlib import Path

import pytest
from bare_release import bare_release
from patience import PATIENCE_S
from ports import free_port

from talaia.updates.release_runner import PassedSignals
from talaia.updates.slot_folder import SlotFolder
from talaia.updates.slots import SlotPhase

ROOT = Path(__file__).parents[2]
ENVIRONMENT = {**os.environ, "PYTHONPATH": str(ROOT / "src"), "PYTHONUNBUFFERED": "1"}
SITE = """\
talaia: 1
site: hut
name: Hut
connections: {{run: {{kind: process, poll: 0.2}}}}
interlocks:
  rain: {{name: Rain, when: [{{signal: dome/rain, is: [wet]}}], refuse: [dome/open]}}
enclosures:
  dome:
    name: Dome
    unsafe: [rain]
    closed: [{{signal: dome/shutter, is: [closed]}}]
    close: {{command: dome/close}}
devices:
  dome:
    name: Dome
    signals:
      shutter:
        {{name: Shutter, type: state, states: [open, closed], source: {{run: cat {shutter}}}}}
      rain: {{name: Rain, type: state, states: [dry, wet], source: {{run: echo dry}}}}
    commands:
      open: {{name: Open, kind: process, target: "true"}}
      close: {{name: Close, kind: process, target: "true"}}
"""
# The package under test, which calls itself by the version of its release.
PROGRAM = """\
#!{python}
import sys
import talaia
talaia.__version__ = "{version}"
from talaia.cli.main import main
sys.exit(main())
"""


class RunningSite:
    """A hub, and a gateway that is started as systemd would start it."""

    def __init__(self, folder: Path) -> None:
        """Start the hub, and install the first release."""
        self.folder, self.port = folder, free_port()
        self.slots = SlotFolder(folder / "software")
        self.shutter = folder / "shutter"
        (folder / "site.yaml").write_text(SITE.format(shutter=self.shutter))
        hub = ["--data", str(folder / "hub")]
        words = ["enrol", "hut", *hub, "--to", str(folder / "key"), "--allow-plain"]
        run_talaia([*words, "--hub", f"ws://127.0.0.1:{self.port}"])
        self.processes = [start_talaia(["hub", *hub, "--plain", "--port", str(self.port)])]
        self.slots.set_up(bare_release("1.0.0"), write_program("1.0.0"))

    def start(self, link_s: float = PATIENCE_S) -> subprocess.Popen[bytes]:
        """Start the gateway."""
        words = ["update", "run", "--root", str(self.folder / "software")]
        words += ["--link-within", str(link_s), "--", str(self.folder / "site.yaml")]
        words += ["--key-file", str(self.folder / "key"), "--data", str(self.folder / "data")]
        self.processes.append(start_talaia([*words, "--update-rest", "0.5"]))
        return self.processes[-1]

    def close(self) -> None:
        """End all that runs, each also where another one does not end."""
        with contextlib.ExitStack() as ends:
            for process in self.processes:
                ends.callback(process.wait, PATIENCE_S)
                process.send_signal(signal.SIGTERM)


def write_program(
    version: str, text: str = PROGRAM, says: str = ""
) -> Callable[[list[Path], Path], None]:
    """Give what builds a release of one program, which may call itself by another version."""

    def build(_wheels: list[Path], slot: Path) -> None:
        program = slot / "bin" / "talaia"
        program.parent.mkdir()
        program.write_text(text.format(python=sys.executable, version=says or version))
        program.chmod(0o700)

    return build


def run_talaia(words: list[str]) -> None:
    """Run one command to its end."""
    subprocess.run([sys.executable, "-m", "talaia", *words], env=ENVIRONMENT, check=True)


def start_talaia(words: list[str]) -> subprocess.Popen[bytes]:
    """Start a program that runs for long."""
    return subprocess.Popen(
        [sys.executable, "-m", "talaia", *words], env=ENVIRONMENT, stderr=subprocess.DEVNULL
    )


def until(holds: Callable[[], object], what: str) -> None:
    """Wait for a condition."""
    end = time.monotonic() + 2 * PATIENCE_S
    while not holds():
        assert time.monotonic() < end, what
        select.select([], [], [], 0.05)


@pytest.fixture
def site(tmp_path: Path) -> Iterator[RunningSite]:
    running = RunningSite(tmp_path)
    yield running
    running.close()


def test_a_release_is_tried_when_the_roof_is_closed_and_kept_when_its_link_is_there(
    site: RunningSite,
) -> None:
    site.shutter.write_text("open")
    gateway = site.start()
    # Without a trial the runner becomes the gateway: a service manager watches that.
    until(lambda: site.slots.is_linked("1.0.0"), "the first release is linked")
    assert b"software/releases/1.0.0" in Path(f"/proc/{gateway.pid}/cmdline").read_bytes()
    # Signed by hand as what it is not: its link counts all the same.
    build = write_program("1.1.0", says="1.1.0rc1")
    site.slots.install_release(bare_release("1.1.0"), build)
    with pytest.raises(subprocess.TimeoutExpired):
        # Long over the time that it has to be at rest.
        gateway.wait(5)
    assert site.slots.read_state().phase is SlotPhase.WAITING
    site.shutter.write_text("closed")
    assert gateway.wait(PATIENCE_S) == 0
    assert site.slots.read_state().phase is SlotPhase.ALLOWED
    trial = site.start()
    until(lambda: site.slots.read_state().current == "1.1.0", "the new release is kept")
    assert site.slots.read_state().previous == "1.0.0"
    # What is written down first holds; the link, for people, follows it.
    link = site.folder / "software" / "current"
    until(lambda: link.resolve().name == "1.1.0", "the link leads to the new release")
    # It goes on as it is.
    assert trial.poll() is None


@pytest.mark.parametrize(
    ("program", "said"),
    [
        ("#!/bin/sh\nexec sleep 1000\n", "no link to the hub within 1 s"),
        ("#!/bin/sh\nexit 3\n", "it ended with 3 before"),
        ("#!/no/such/python\n", "it cannot be started"),
    ],
)
def test_a_release_whose_link_does_not_return_is_left_by_itself(
    site: RunningSite, program: str, said: str
) -> None:
    site.slots.install_release(bare_release("1.1.0"), write_program("1.1.0", program))
    site.slots.allow_trial()
    assert site.start(link_s=1).wait(PATIENCE_S) != 0
    state = site.slots.read_state()
    assert state.current == "1.0.0"
    assert said in state.failed["1.1.0"]
    assert not site.slots.slot_path("1.1.0").exists()
    # What the service manager starts next.
    slot = site.slots.start_slot()
    assert (slot.version, slot.on_trial) == ("1.0.0", False)


def test_a_service_that_is_ended_in_a_trial_tries_it_again(site: RunningSite) -> None:
    slow = "#!/bin/sh\ntrap 'exit 0' TERM\ntouch {version}.began\nwhile :; do sleep 0.1; done\n"
    slow = slow.replace("{version}", str(site.folder / "{version}"))
    site.slots.install_release(bare_release("1.1.0"), write_program("1.1.0", slow))
    site.slots.allow_trial()
    running = site.start()
    until((site.folder / "1.1.0.began").exists, "the trial has begun")
    running.send_signal(signal.SIGTERM)
    running.wait(PATIENCE_S)
    state = site.slots.read_state()
    assert (state.phase, state.candidate, state.tries) == (SlotPhase.TRYING, "1.1.0", 1)


def test_who_ends_the_service_before_the_gateway_is_there_ends_the_gateway_too() -> None:
    before = [(number, signal.getsignal(number)) for number in (signal.SIGTERM, signal.SIGINT)]
    try:
        signals = PassedSignals()
        os.kill(os.getpid(), signal.SIGTERM)
        gateway = subprocess.Popen(["sleep", "1000"])
        signals.pass_to(gateway)
        assert gateway.wait(PATIENCE_S) == -signal.SIGTERM
        assert signals
    finally:
        for number, handler in before:
            signal.signal(number, handler)
