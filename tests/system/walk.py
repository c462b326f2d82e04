"""``talaia init``, then ``talaia up``: as a person does it, and what the history has of it."""

from __future__ import annotations

import contextlib
import re
import signal
import subprocess
import sys
import threading
import time
from collections.abc import Iterable, Iterator
from pathlib import Path
from typing import NamedTuple

import httpx
from patience import PATIENCE_S
from ports import free_port
from shared_trust import usual_trust

from talaia.model.site import Site
from talaia.model.yaml_text.load import read_site

PASSWORD = "a long enough password 7"  # noqa: S105 - of a hub that lives for one test


class Walked(NamedTuple):
    """A site that is up: its description, a client of its first admin, and since when."""

    site: Site
    client: httpx.Client
    address: str
    began: float

    def seconds(self) -> float:
        """How long it is since ``talaia init`` was entered."""
        return time.monotonic() - self.began

    def tell(self) -> None:
        """Say how long it took, for whoever runs the test with ``-rP``."""
        said = f"{self.site.site}: {len(self.numbers())} numbers, {self.seconds():.1f} s after init"
        sys.stdout.write(f"{said}\n")

    def numbers(self) -> set[str]:
        """The addresses of all channels that hold a number."""
        return {each.address for each in self.site.channels() if not each.text}


def talaia(here: dict[str, str], *words: str, given: str = "") -> subprocess.CompletedProcess[str]:
    return subprocess.run(
        [sys.executable, "-m", "talaia", *words],
        env=here,
        input=given,
        capture_output=True,
        text=True,
        timeout=PATIENCE_S,
        check=False,
    )


@contextlib.contextmanager
def walked(here: dict[str, str], folder: Path, *init: str) -> Iterator[Walked]:
    """Look, write and run, without a touch of the file between; ends with Ctrl-C."""
    began = time.monotonic()
    target = folder / "site.yaml"
    made = talaia(here, "init", "-o", str(target), *init)
    assert made.returncode == 0, made.stderr
    with up(here, target, folder / "data") as (client, address):
        yield Walked(read_site(target), client, address, began)


@contextlib.contextmanager
def up(here: dict[str, str], site: Path, data: Path) -> Iterator[tuple[httpx.Client, str]]:
    """Run ``talaia up``; gives a client that is signed in, and the address."""
    words = ["up", str(site), "--no-browser", "--data", str(data), "--port", str(free_port())]
    process = subprocess.Popen(
        [sys.executable, "-m", "talaia", *words],
        env=here, stdout=subprocess.PIPE, stderr=subprocess.STDOUT, text=True,
    )  # fmt: skip
    alarm = threading.Timer(90, process.kill)
    alarm.start()
    assert process.stdout is not None
    try:
        said = ""
        for line in process.stdout:
            said += line
            if "Ctrl-C" in line:
                break
        ready = re.search(r"is up \([\d.]+ s\):\s+(http://\S+)", said)
        assert ready is not None, said + _logs(data)
        with httpx.Client(
            base_url=ready[1],
            timeout=PATIENCE_S,
            headers={"origin": ready[1]},
            verify=usual_trust(),
        ) as client:
            words = {"name": "ada", "password": PASSWORD}
            setup = re.search(r"/setup#(\S+)", said)
            asked = {**words, "token": setup[1]} if setup else words
            answer = client.post("/api/setup" if setup else "/api/login", json=asked)
            assert answer.status_code == 200, answer.text
            yield client, ready[1]
    finally:
        alarm.cancel()
        process.send_signal(signal.SIGINT)
        assert process.wait(30) in (0, -signal.SIGKILL)
        process.stdout.close()


def _logs(data: Path) -> str:
    return "".join(f"\n{each.name}:\n{each.read_text()[-3000:]}" for each in data.glob("*.log"))


def stored(client: httpx.Client, site: str, wanted: Iterable[str]) -> dict[str, dict[str, object]]:
    """Give the newest stored value of each channel that has one."""
    found: dict[str, dict[str, object]] = {}
    addresses = sorted(wanted)
    now_us = int(time.time() * 1e6)
    for start in range(0, len(addresses), 20):
        asked = [("channel", each) for each in addresses[start : start + 20]]
        answer = client.get(f"/api/sites/{site}/last", params=[("before_us", str(now_us)), *asked])
        if answer.status_code == 404:
            # A site whose devices are found by its gateway is not there before the first of them.
            return found
        assert answer.status_code == 200, answer.text
        found |= {each["address"]: each for each in answer.json()["values"]}
    return found


def until_stored(
    client: httpx.Client, site: str, wanted: Iterable[str], within: float = 25
) -> None:
    """Wait until the history has a value of each."""
    missed, end = set(wanted), time.monotonic() + within
    while missed:
        missed -= stored(client, site, missed).keys()
        assert not missed or time.monotonic() < end, f"never stored: {sorted(missed)[:40]}"
        # A hub refuses who asks without a pause.
        time.sleep(0.25 if missed else 0)
