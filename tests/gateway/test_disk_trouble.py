"""A disk that is full, read-only or fails keeps no roof open and ends no gateway."""

from __future__ import annotations

import asyncio
import contextlib
import errno
import os
import subprocess
import time
from contextlib import asynccontextmanager, contextmanager
from typing import TYPE_CHECKING

import pytest
from fake_hub import fake_hub
from gateway_bench import addresses_of, running
from patience import PATIENCE_S

from talaia.gateway import persistence
from talaia.gateway.commands.command_journal import CommandJournal
from talaia.gateway.driving import persistent_state
from talaia.gateway.driving.stop_latch import LatchedStop
from talaia.gateway.errors import SpoolError
from talaia.wire.frames import CommandPhase, CommandRequest, CommandState, Event

if TYPE_CHECKING:
    from collections.abc import AsyncIterator, Callable, Iterator
    from pathlib import Path

    from fake_hub import FakeHub

SITE = """
talaia: 1
site: hill
name: Hill
connections: {{shell: {{kind: process, poll: 0.1, timeout: 5}}}}
devices:
  weather:
    name: Weather
    connection: shell
    signals:
      sky: {{name: Sky, type: state, states: [dry, wet], max_age: 9, source: {{run: cat {at}/sky}}}}
  roof:
    name: Roof
    connection: shell
    signals:
      shutter:
        name: Shutter
        type: state
        states: [closed, opened]
        max_age: 20
        source: {{run: cat {at}/roof}}
    commands:
      open: {{name: Open, kind: process, target: "sh {at}/act opened o"}}
      close: {{name: Close, kind: process, target: "sh {at}/act closed c"}}
      light: {{name: Light, kind: process, target: "sh -c 'echo l >> {at}/log'"}}
interlocks:
  rain:
    name: Rain
    when: [{{signal: weather/sky, is: [wet]}}]
    refuse: [roof/open]
    dwell: 1
enclosures:
  roof:
    name: Roof
    unsafe: [rain]
    closed: [{{signal: roof/shutter, is: [closed]}}]
    close: {{command: roof/close}}
"""


@contextmanager
def small_disk(folder: Path) -> Iterator[Path]:
    """A real file system of 1 MiB."""
    folder.mkdir()
    mounted = subprocess.run(
        ["mount", "-t", "tmpfs", "-o", "size=1m", "tmpfs", str(folder)],
        check=False, capture_output=True, text=True,
    )  # fmt: skip
    if mounted.returncode != 0:
        if os.environ.get("TALAIA_REQUIRE_ALL") == "1":
            pytest.fail(f"cannot mount: {mounted.stderr}, and TALAIA_REQUIRE_ALL=1")
        pytest.skip(f"needs a small file system: {mounted.stderr.strip()}")
    try:
        yield folder
    finally:
        subprocess.run(["umount", "-l", str(folder)], check=True)


def fill(folder: Path) -> None:
    """Leave no byte free, in the last page of the journal neither."""
    with (folder / "commands.jsonl").open("ab") as file:
        file.write(b"\n" * (-file.tell() % 4096))
    with (folder / "ballast").open("ab", buffering=0) as file, contextlib.suppress(OSError):
        while True:
            file.write(bytes(512))


@asynccontextmanager
async def kept_full(folder: Path) -> AsyncIterator[None]:
    """Leave no byte free, also when the spool lets go of its oldest."""

    async def refill() -> None:
        while True:
            fill(folder)
            await asyncio.sleep(0.02)

    task = asyncio.ensure_future(refill())
    try:
        yield
    finally:
        task.cancel()
        await asyncio.gather(task, return_exceptions=True)


def remount(folder: Path, how: str) -> None:
    """Mount it anew, once nobody writes: the watchdog of a gateway that has ended ends after it."""
    words = ["mount", "-o", f"remount,{how}", str(folder)]
    end = time.monotonic() + PATIENCE_S
    while (done := subprocess.run(words, check=False, capture_output=True)).returncode:
        assert time.monotonic() < end, done.stderr
        time.sleep(0.1)


class Hill:
    """A roof and a sky, as files, and what people ask of the gateway between them."""

    def __init__(self, at: Path, hub: FakeHub) -> None:  # noqa: D107
        self.at, self.hub = at, hub

    @staticmethod
    def made(at: Path, sky: str = "dry", roof: str = "closed") -> None:
        (at / "sky").write_text(sky)
        (at / "roof").write_text(roof)
        (at / "log").write_text("")
        (at / "act").write_text(f"echo $1 > {at}/roof; echo $2 >> {at}/log")

    def did(self) -> str:
        return (self.at / "log").read_text().replace("\n", "")

    async def until(self, holds: Callable[[], bool]) -> None:
        async with asyncio.timeout(PATIENCE_S):
            while not holds():  # noqa: ASYNC110 - told by nobody: a file
                await asyncio.sleep(0.05)

    async def ask(self, what: str, command_id: str) -> CommandState:
        await self.hub.send(
            CommandRequest(id=command_id, device="roof", command=what, ttl_ms=5000, who="Ada")
        )
        return await self.hub.next(
            CommandState,
            lambda each: (
                each.id == command_id
                and each.phase not in (CommandPhase.ACCEPTED, CommandPhase.RUNNING)
            ),
        )

    async def event(self, kind: str) -> Event:
        return await self.hub.next(Event, lambda each: each.kind == kind)

    async def opened_by_hand(self) -> None:
        """Open it once the gateway lets anybody."""
        await self.event("interlock_released")
        assert (await self.ask("open", "open")).phase is CommandPhase.SUCCEEDED
        await self.until(lambda: (self.at / "roof").read_text().strip() == "opened")


@pytest.mark.parametrize("how", ["full", "failing"])
async def test_a_roof_closes_in_the_rain_though_the_disk_takes_nothing(
    how: str, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    Hill.made(tmp_path)
    with small_disk(tmp_path / "data") as data:
        async with (
            fake_hub(addresses_of) as hub,
            running(hub.url, data, SITE.format(at=tmp_path)),
            asyncio.timeout(3 * PATIENCE_S),
        ):
            await hub.until(lambda: hub.hellos, "a hello")
            hill = Hill(tmp_path, hub)
            await hill.opened_by_hand()
            with monkeypatch.context() as patch:
                full = contextlib.AsyncExitStack()
                if how == "full":
                    await full.enter_async_context(kept_full(data))
                else:
                    fail_with(patch, errno.EIO)
                (tmp_path / "sky").write_text("wet")
                await hill.until(lambda: (tmp_path / "roof").read_text().strip() == "closed")
                assert "cannot be written" in (await hill.event("disk_failed")).message
                # Whoever opens it by other means sees it closed again; a person may close, too.
                closes = hill.did().count("c")
                assert (await hill.ask("close", "by hand")).phase is CommandPhase.SUCCEEDED
                assert (await hill.ask("close", "by hand")).phase is CommandPhase.SUCCEEDED
                assert hill.did().count("c") == closes + 1
                refused = await hill.ask("light", "light")
                assert "cannot write its journal" in refused.message
                assert "l" not in hill.did()
                await full.aclose()
            (data / "ballast").unlink(missing_ok=True)
            await hill.event("disk_recovered")
        remembered = {
            each.id: each.phase for each in CommandJournal(data / "commands.jsonl").remembered
        }
        assert remembered["by hand"] is CommandPhase.SUCCEEDED
        assert any(key.startswith("enclosure-roof-close") for key in remembered)


def fail_with(patch: pytest.MonkeyPatch, number: int) -> None:
    """Let the disk fail whenever something is forced to it."""

    def fails(_file: int) -> None:
        raise OSError(number, os.strerror(number))

    patch.setattr(os, "fsync", fails)
    patch.setattr(os, "fdatasync", fails)


@pytest.mark.parametrize("how", ["full", "read-only", "failing", "read-only and empty"])
async def test_a_gateway_that_starts_on_a_disk_that_takes_nothing_guards_all_the_same(
    how: str, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    text = SITE.format(at=tmp_path)
    Hill.made(tmp_path, roof="closed")
    with small_disk(tmp_path / "data") as data:
        if "empty" not in how:
            async with fake_hub(addresses_of) as hub, running(hub.url, data, text):
                await hub.until(lambda: hub.hellos, "a hello")
        if how == "full":
            fill(data)
        elif how == "failing":
            fail_with(monkeypatch, errno.EIO)
        else:
            remount(data, "ro")
        Hill.made(tmp_path, sky="wet", roof="opened")
        async with (
            fake_hub(addresses_of) as hub,
            running(hub.url, data, text),
            asyncio.timeout(3 * PATIENCE_S),
        ):
            await hub.until(lambda: hub.hellos, "a hello")
            hill = Hill(tmp_path, hub)
            await hill.until(lambda: (tmp_path / "roof").read_text().strip() == "closed")
            assert (await hill.ask("close", "by hand")).phase is CommandPhase.SUCCEEDED
            if how.startswith("read-only"):
                remount(data, "rw")
                await hill.event("disk_recovered")
                assert (await hill.ask("light", "light")).phase is CommandPhase.SUCCEEDED


def test_two_gateways_on_one_folder_are_told_apart_on_a_read_only_disk(tmp_path: Path) -> None:
    with small_disk(tmp_path / "data") as data:
        remount(data, "ro")
        lock = persistence.lock_folder(data)
        with pytest.raises(SpoolError, match="used by another gateway"):
            persistence.lock_folder(data)
        os.close(lock)


def test_a_stop_that_the_disk_did_not_take_is_written_when_it_does(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    stops = persistent_state.PersistentStops(tmp_path / "stops.json")
    latched = LatchedStop("id", "Ada", 5)
    with monkeypatch.context() as patch:
        fail_with(patch, errno.EROFS)
        with pytest.raises(OSError, match="Read-only"):
            stops.write_stop("base", latched)
    assert stops.behind
    assert stops.find_stop("base") == latched
    stops.write_waiting()
    assert not stops.behind
    assert persistent_state.PersistentStops(tmp_path / "stops.json").find_stop("base") == latched


def test_where_stops_and_epochs_cannot_be_read_all_is_stopped_and_nobody_drives(
    tmp_path: Path,
) -> None:
    # A folder in a file's place is an error of reading like any other.
    for name in ("stops.json", "epochs.json"):
        (tmp_path / name).mkdir()
    stops = persistent_state.PersistentStops(tmp_path / "stops.json")
    found = stops.find_stop("base")
    assert found is not None
    assert "cannot read its disk" in found.who
    with pytest.raises(OSError, match="cannot be read"):
        stops.write_stop("base", None)
    epochs = persistent_state.LeaseEpochs(tmp_path / "epochs.json")
    with pytest.raises(OSError, match="directory"):
        epochs.next_epoch()


def test_a_journal_that_cannot_be_read_is_not_written_over(tmp_path: Path) -> None:
    (tmp_path / "c.jsonl").mkdir()
    journal = CommandJournal(tmp_path / "c.jsonl")
    state = CommandState(id="a", device="d", command="c", phase=CommandPhase.ACCEPTED)
    with pytest.raises(OSError, match="what was done before cannot be read"):
        journal.write_state(state, sure=True)
    assert journal.behind
