"""A gateway's watchdog over the end of one of its runs: real processes, nothing to close."""

from __future__ import annotations

import time
from pathlib import Path

import psutil
from patience import PATIENCE_S

from talaia.gateway.watchdog.feeding import WatchdogClient
from talaia.model.yaml_text.load import load_site

EXAMPLE = Path(__file__).parents[3] / "examples" / "clamshell" / "site.yaml"


def begun(data: Path) -> WatchdogClient:
    watchdog = WatchdogClient(data, data, None, lambda why: None)
    text = EXAMPLE.read_text()
    watchdog.watch_site(load_site(text), text)
    return watchdog


def process_of(data: Path) -> psutil.Process:
    """Wait for the process that holds the lock."""
    ends = time.monotonic() + PATIENCE_S
    while not (said := (data / "watchdog.lock").read_text().strip()):
        assert time.monotonic() < ends
        time.sleep(0.01)
    return psutil.Process(int(said))


def alive(process: psutil.Process) -> bool:
    """Whether it runs; one that nobody has waited for yet does not."""
    return process.is_running() and process.status() != psutil.STATUS_ZOMBIE


async def test_a_gateway_that_begins_anew_is_watched_until_its_next_run_takes_over(
    tmp_path: Path,
) -> None:
    before = begun(tmp_path)
    await before.keep_running(0.0)
    process = process_of(tmp_path)
    # Its description is made anew: were it to die now, somebody must close.
    before.let_go()
    assert alive(process)
    after = begun(tmp_path)
    await after.take_over()
    assert not alive(process)
    await after.keep_running(0.0)
    again = process_of(tmp_path)
    await after.end_process()
    assert not alive(again)
