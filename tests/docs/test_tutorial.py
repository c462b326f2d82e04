"""Each command of the tutorial does what the page says: the page is read, and they are run."""

from __future__ import annotations

import os
import re
import shlex
import shutil
import signal
import subprocess
import sys
import threading
import urllib.request
from pathlib import Path

import pytest
from patience import PATIENCE_S
from ports import free_port

ROOT = Path(__file__).parents[2]
PAGE = (ROOT / "docs/tutorial.md").read_text()
BLOCK = re.compile(r"^```(\w+)\n(.*?)^```$", re.MULTILINE | re.DOTALL)
COMMANDS = [
    line.partition("#")[0].strip()
    for kind, text in BLOCK.findall(PAGE)
    if kind == "sh"
    for line in text.splitlines()
    if line.strip()
]
# What these need of the machine, beside Python packages.
PROGRAMS = {"demo-indi": "indiserver"}

pytestmark = pytest.mark.robot


def talaia_words(command: str) -> list[str]:
    """Give the words behind ``talaia`` of a command, also of one that the Makefile has."""
    words = shlex.split(command)
    if words[0] == "make":
        makefile = (ROOT / "Makefile").read_text()
        recipe = re.search(rf"^{words[1]}:.*\n(?:\t.*\n)*?\t@exec \S+/talaia (\S+)", makefile, re.M)
        assert recipe is not None, command
        return [recipe[1], *words[2:]]
    assert words[0] == "talaia", f"what runs {command!r}?"
    return words[1:]


def write_files(folder: Path) -> None:
    """Write the files that the page has; the first line of each names it."""
    for kind, text in BLOCK.findall(PAGE):
        if kind == "yaml":
            name = text.partition("\n")[0].removeprefix("#").strip()
            (folder / name).write_text(text)


def test_the_page_goes_from_the_vehicle_to_the_observatory_to_something_of_ones_own() -> None:
    assert [talaia_words(command)[0] for command in COMMANDS] == [
        *("demo", "demo-indi", "check", "up")
    ]


@pytest.mark.parametrize("command", COMMANDS)
def test_a_command_of_the_tutorial_does_what_the_page_says(command: str, tmp_path: Path) -> None:
    words = talaia_words(command)
    program = PROGRAMS.get(words[0])
    if program and not shutil.which(program):
        pytest.skip(f"{program} is not installed")
    write_files(tmp_path)
    environment = {**os.environ, "PYTHONPATH": str(ROOT / "src"), "TMPDIR": str(tmp_path)}
    # What serves until Ctrl-C gets a port and a folder of its own; else it is as on the page.
    serves = words[0] in {"demo", "demo-indi", "up"}
    if serves:
        words += ["--no-browser", "--port", str(free_port()), "--data", str(tmp_path / "data")]
    if words[0] == "demo":
        words.append("--no-time-lapse")
    running = subprocess.Popen(
        [sys.executable, "-m", "talaia", *words],
        cwd=tmp_path,
        env=environment,
        stdout=subprocess.PIPE,
        stderr=subprocess.STDOUT,
        text=True,
    )
    alarm = threading.Timer(2 * PATIENCE_S, running.kill)
    alarm.start()
    assert running.stdout is not None
    try:
        said = ""
        for line in running.stdout:
            said += line
            if serves and "Ctrl-C" in line:
                break
        if serves:
            address = re.search(r"\([\d.]+ s\):\s+(\S+)", said)
            assert address is not None, said
            with urllib.request.urlopen(f"{address[1]}/api/health", timeout=PATIENCE_S) as answer:  # noqa: S310 - loopback
                assert answer.status == 200
            running.send_signal(signal.SIGINT)
        running.communicate(timeout=PATIENCE_S)
        assert running.returncode in ((0, 130) if serves else (0,)), said
    finally:
        alarm.cancel()
        running.kill()
        running.wait()
