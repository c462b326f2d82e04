"""Histories on one database server and on two, in one run and by turns; and ten thousand signals.

    PYTHONPATH=src:bench python bench/history_servers.py [--seconds 8] [--turns 3]

Starts two servers of each kind that is installed here (PostgreSQL, MariaDB), each with a folder of
its own and as it comes. Sites of fifty signals send a thousand samples at a time, and the next ones
when those are durable: as fast as the hub and its servers bear. All of them are on one server, and
then half of them on either; both by turns in one hub's history. All of it shares this machine's
cores and its disk, so it tells what a second server costs, and what it gives as far as these allow.

Then two hundred sites with fifty signals each are stored on both, and a hub is started on them: how
soon it answers, its memory, and what it takes to ask for the last values of all.
"""

from __future__ import annotations

import argparse
import asyncio
import contextlib
import os
import resource
import sys
import tempfile
import time
from pathlib import Path
from typing import TYPE_CHECKING, NamedTuple

import database_servers
import numpy as np
import psutil
from crowd import describe
from history import batch
from stack import free_port

from talaia.cli.child_processes import end_all, start_talaia
from talaia.clock import SystemClock
from talaia.hub.history.limits import HistoryLimits
from talaia.hub.history.servers.history_servers import HistoryServers
from talaia.hub.history.servers.server_file import HistoryServersFile
from talaia.hub.history.store import HistoryStore
from talaia.hub.store.database import Database
from talaia.hub.store.history_servers.history_homes import HistoryHomes
from talaia.hub.store.sites.site_registry import SiteRegistry
from talaia.model.yaml_text.load import load_site

if TYPE_CHECKING:
    from collections.abc import Iterator

SIGNALS = 50
BATCH = 1_000
SITES = 8
MANY_SITES = 200
EACH = 30
TOGETHER = 20


class Span(NamedTuple):
    """What was stored in a span of time; seconds of the processor are for a million samples."""

    rate: float
    p99_ms: float
    hub_cpu_s: float
    servers_cpu_s: float


class OpenHistory(NamedTuple):
    """A hub's history, open, and its accounts' database."""

    history: HistoryServers
    database: Database

    async def close(self) -> None:
        """Close both."""
        await self.history.close()
        await self.database.close()


async def open_history(folder: Path, urls: list[str], sites: dict[str, str]) -> OpenHistory:
    """Open the history of a hub whose data are in ``folder``, with servers ``s0``, ``s1``."""
    url, clock, limits = f"sqlite:///{folder}/talaia.db", SystemClock(), HistoryLimits()
    database = Database(url)
    await database.migrate()
    named = HistoryServersFile(
        servers={f"s{at}": url for at, url in enumerate(urls)}, default="s0", sites=sites
    )
    own = HistoryStore(url, clock, limits)
    history = HistoryServers(own, named, HistoryHomes(database), clock=clock, limits=limits)
    await history.open()
    return OpenHistory(history, database)


async def store_for(
    history: HistoryServers, sites: list[str], seconds: float, begin: int
) -> tuple[int, list[float]]:
    """Store as fast as it goes; give how many samples each site has then, and each wait (s)."""
    waits: list[float] = []
    ends = time.perf_counter() + seconds
    addresses = tuple(f"hut/n{at}" for at in range(SIGNALS))

    async def feed(site: str) -> int:
        first = begin
        while time.perf_counter() < ends:
            columns = batch(first, SIGNALS, BATCH)
            before = time.perf_counter()
            await history.append_samples(site, "b", first, addresses=addresses, columns=columns)
            waits.append(time.perf_counter() - before)
            first += BATCH
        return first

    return max(await asyncio.gather(*(feed(site) for site in sites))), waits


async def measure_scaling(
    folder: Path, servers: list[database_servers.DatabaseServer], seconds: float, turns: int
) -> dict[str, list[Span]]:
    """Store by turns on one server and on two; and in the hub's own file."""
    ways = {
        "own": [f"own{at}" for at in range(SITES)],
        "one": [f"one{at}" for at in range(SITES)],
        "two": [f"two{at}" for at in range(SITES)],
    }
    homes = dict.fromkeys(ways["own"], "own")
    homes |= {site: f"s{at % 2}" for at, site in enumerate(ways["two"])}
    opened = await open_history(folder, [server.url for server in servers], homes)
    begin = dict.fromkeys(ways, 0)
    found: dict[str, list[Span]] = {way: [] for way in ways}
    for turn in range(turns + 1):
        for way, sites in ways.items():
            cpu, theirs = time.process_time(), sum(server.cpu_s() for server in servers)
            # The first turn opens connections and makes tables' first pages.
            length = seconds if turn else 2.0
            begin[way], waits = await store_for(opened.history, sites, length, begin[way])
            count = len(waits) * BATCH / 1e6
            if turn:
                found[way].append(
                    Span(
                        count * 1e3 / length,
                        float(np.percentile(waits, 99)) * 1e3,
                        (time.process_time() - cpu) / count,
                        (sum(server.cpu_s() for server in servers) - theirs) / count,
                    )
                )
    await opened.close()
    return found


def print_scaling(kind: str, found: dict[str, list[Span]]) -> None:
    """Print medians."""
    print(f"\n{kind}: {SITES} sites of {SIGNALS} signals, {BATCH} a batch, load {load()}")
    print(f"{'':24}{'k samples/s':>12}{'p99, ms':>10}{'hub, CPU s/M':>14}{'servers':>9}")
    names = {"own": "the hub's own file", "one": "on one server", "two": "half on either"}
    for way, spans in found.items():
        rate, p99, hub, servers = (float(np.median(one)) for one in zip(*spans, strict=True))
        print(f"{names[way]:24}{rate:12.0f}{p99:10.1f}{hub:14.2f}{servers:9.2f}")
    one, two = (np.array([span.rate for span in found[way]]) for way in ("one", "two"))
    print(f"two beside one: {float(np.median(two / one)):.2f} times as many")


def load() -> str:
    """Tell how busy the machine is."""
    return f"{os.getloadavg()[0]:.1f} on {os.cpu_count()} cores"


def hub_settings(folder: Path, urls: list[str]) -> Path:
    """Write the file that names servers."""
    file = folder / "servers.yaml"
    lines = [f"  s{at}: {url}\n" for at, url in enumerate(urls)]
    halves = [f"  crowd{at}: s{at % len(urls)}\n" for at in range(MANY_SITES)] if urls else []
    file.write_text("servers:\n" + "".join(lines) + "default: s0\nsites:\n" + "".join(halves))
    file.chmod(0o600)
    return file


@contextlib.contextmanager
def timed(what: str) -> Iterator[None]:
    """Print how long something took, and what of it this process computed."""
    began, cpu = time.perf_counter(), time.process_time()
    yield
    took, mine = time.perf_counter() - began, time.process_time() - cpu
    print(f"{what}: {took:.2f} s, {mine:.2f} s of CPU")


async def fill_many(folder: Path, urls: list[str]) -> None:
    """Store a few samples of ten thousand signals, and let the hub know their sites."""
    homes = {f"crowd{at}": f"s{at % 2}" for at in range(MANY_SITES)} if urls else {}
    if urls:
        opened = await open_history(folder, urls, homes)
        history: HistoryServers | HistoryStore = opened.history
        database = opened.database
    else:
        database = Database(f"sqlite:///{folder}/talaia.db")
        await database.migrate()
        history = HistoryStore(f"sqlite:///{folder}/talaia.db", SystemClock())
        await history.open()
    registry = SiteRegistry(database, SystemClock())
    addresses = tuple(f"hut/n{at}" for at in range(SIGNALS))
    texts = {f"crowd{at}": describe(f"crowd{at}", SIGNALS) for at in range(MANY_SITES)}
    for site, text in texts.items():
        await registry.said_hello(site, text, "c", "")
    described = [load_site(text) for text in texts.values()]
    count = f"{MANY_SITES * SIGNALS} signals"
    began = time.perf_counter()
    with timed(f"{MANY_SITES} sites with {count} are described"):
        # As gateways that join together.
        for first in range(0, MANY_SITES, TOGETHER):
            some = described[first : first + TOGETHER]
            await asyncio.gather(*map(history.describe_site, some))
    with timed(f"the first values of {count} are stored"):
        await asyncio.gather(*(
            history.append_samples(
                site, "b", 0, addresses=addresses, columns=batch(0, SIGNALS, SIGNALS, 1)
            )
            for site in texts
        ))  # fmt: skip
    await history.wait_for_views()
    print(f"all views are there {time.perf_counter() - began:.2f} s after the first description")
    with timed(f"{EACH - 1} more of each"):
        for site in texts:
            columns = batch(SIGNALS, SIGNALS, SIGNALS * (EACH - 1), 1)
            await history.append_samples(site, "b", SIGNALS, addresses=addresses, columns=columns)
    with timed(f"last values of {count}, {MANY_SITES} questions"):
        for site in texts:
            assert len(await history.last_readings(site, addresses)) == SIGNALS
    await history.close()
    await database.close()


async def measure_hub(folder: Path, urls: list[str]) -> None:
    """Start a hub on what is stored, and print how it is."""
    port = free_port()
    words = ["hub", "--plain", "--port", str(port), "--data", str(folder)]
    if urls:
        words += ["--history-servers", str(hub_settings(folder, urls))]
    began = time.perf_counter()
    hub = await start_talaia("hub", words, folder / "hub.log")
    await hub.wait_line("ready", 300)
    took = time.perf_counter() - began
    process = psutil.Process(hub.process.pid)
    times, memory = process.cpu_times(), process.memory_info().rss / 2**20
    await end_all([hub])
    where = f"on {len(urls)} servers" if urls else "in its own file"
    print(
        f"a hub with {MANY_SITES} sites of {SIGNALS} signals {where}: ready after {took:.1f} s "
        f"({times.user + times.system:.1f} s of CPU), {memory:.0f} MiB"
    )


async def measure_one_site(url: str) -> None:
    """Ask for the last values of ten thousand signals of one site, at once and one by one."""
    store = HistoryStore(url, SystemClock())
    await store.create_tables()
    await store.open()
    count = MANY_SITES * SIGNALS
    addresses = tuple(f"base/s{at}" for at in range(count))
    for first in range(0, count * EACH, 10_000):
        columns = batch(first, count, 10_000, 1)
        await store.append_samples("agv", "b", first, addresses=addresses, columns=columns)
    took = []
    for _ in range(5):
        cpu = time.process_time()
        assert len(await store.last_readings("agv", addresses)) == count
        took.append(time.process_time() - cpu)
    cpu = time.process_time()
    for address in addresses[:500]:
        await store.last_readings("agv", [address])
    alone = (time.process_time() - cpu) * count / 500
    before = time.process_time()
    await store.close()
    again = HistoryStore(url, SystemClock())
    before = time.process_time()
    await again.open()
    opening = time.process_time() - before
    await again.close()
    memory = resource.getrusage(resource.RUSAGE_SELF).ru_maxrss / 1024
    print(
        f"last values of {count} signals of one site, SQLite: {np.median(took):.3f} s of CPU at "
        f"once, {alone:.1f} s one by one (of 500); opened in {opening:.2f} s of CPU; the process "
        f"had at most {memory:.0f} MiB"
    )


def main() -> int:
    """Measure and print."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--seconds", type=float, default=8.0, help="length of each span")
    parser.add_argument("--turns", type=int, default=3, help="0: ten thousand signals alone")
    chosen = parser.parse_args()
    with tempfile.TemporaryDirectory(prefix="talaia-servers-") as name:
        folder = Path(name)
        # The databases' own users look into it.
        folder.chmod(0o755)
        asyncio.run(measure_one_site(f"sqlite:///{folder}/one.db"))
        own = folder / "own"
        own.mkdir()
        asyncio.run(fill_many(own, []))
        asyncio.run(measure_hub(own, []))
        for kind in database_servers.KINDS:
            with database_servers.started_servers(kind, folder, 4) as servers:
                place = folder / kind
                place.mkdir()
                if chosen.turns:
                    found = asyncio.run(
                        measure_scaling(place, servers[:2], chosen.seconds, chosen.turns)
                    )
                    print_scaling(kind, found)
                print(f"\n{kind}, two servers, load {load()}")
                many = folder / f"{kind}-many"
                many.mkdir()
                urls = [server.url for server in servers[2:]]
                asyncio.run(fill_many(many, urls))
                asyncio.run(measure_hub(many, urls))
    return 0


if __name__ == "__main__":
    sys.exit(main())
