"""Two hubs as one beside one hub: latency, processor time, memory, a hub that is killed.

    PYTHONPATH=src python bench/cluster.py          all of it, about twelve minutes
    PYTHONPATH=src python bench/cluster.py way cpu  some: way, cpu, gateways, pages, kill, shards
    PYTHONPATH=src python bench/cluster.py gateways 50 100    with other numbers (or: pages 200)

Needs nats-server, and PostgreSQL at TALAIA_TEST_POSTGRESQL. Two hubs are a lead and one that hands
through; "far" is what comes in at the latter. Each figure stands beside its limit.
"""

from __future__ import annotations

import asyncio
import contextlib
import math
import os
import secrets
import signal
import sys
import time
from collections.abc import Callable, Coroutine
from typing import Any

import numpy as np
import websockets
from cluster_hubs import CHANNEL, EPOCH, SITE, Deployment, Gateway, Hub, deployment
from figures import Figure, show_figures
from link import crowd_at
from stack import site_text
from viewers import Pages, channels_of, role

from talaia.model.yaml_text.load import load_site
from talaia.wire import browser, frames

TIMES = 300
# Gateways whose cost is measured, each of so many signals at 1 Hz.
COUNTS, SIGNALS = (50, 100, 200, 400), 50
PAGES, HERTZ = 500, 10
WATCHED = 20
# What a hub is asked to bear at the most, of a core.
_BEARS = 0.7


async def sample_to_page(gateway: Gateway, page: websockets.ClientConnection) -> np.ndarray:
    """Measure from a gateway's socket to a page's (ms)."""
    found = []
    for at in range(TIMES):
        began = time.perf_counter()
        await gateway.sample(float(at))
        while True:
            told = browser.TO_BROWSER.decode(await page.recv())
            if isinstance(told, browser.Values):
                break
        found.append((time.perf_counter() - began) * 1000)
        await asyncio.sleep(0.01)
    return np.array(found)


async def stop_to_gateway(gateway: Gateway, page: websockets.ClientConnection) -> np.ndarray:
    """Measure STOP from a page's socket to a gateway's (ms)."""
    found = []
    for _ in range(TIMES):
        word = secrets.token_hex(4)
        began = time.perf_counter()
        await _say(page, browser.PageStop(site=SITE, device="base", id=word))
        found.append((await gateway.until_came(word) - began) * 1000)
        await asyncio.sleep(0.01)
    return np.array(found)


async def drive_to_gateway(gateway: Gateway, page: websockets.ClientConnection) -> np.ndarray:
    """Measure a driving frame from a page's socket to a gateway's (ms)."""
    found, gateway.came = [], {}
    await _say(page, _lease(frames.LeaseOp.TAKE))
    while True:
        told = browser.TO_BROWSER.decode(await page.recv())
        if isinstance(told, browser.LeaseUpdate) and told.yours:
            break
    for at in range(TIMES):
        speed = 0.01 + at * 0.001
        began = time.perf_counter()
        await _say(
            page,
            browser.PageDrive(
                site=SITE, device="base", epoch=EPOCH, seq=at + 1, tick=1, linear=speed, angular=0.0
            ),
        )
        found.append((await gateway.until_came(f"{speed:.4f}") - began) * 1000)
        if at % 20 == 19:
            await _say(page, _lease(frames.LeaseOp.RENEW))
        await asyncio.sleep(0.01)
    await _say(page, _lease(frames.LeaseOp.FREE))
    await asyncio.sleep(0.3)
    return np.array(found)


def _lease(op: frames.LeaseOp) -> browser.PageLease:
    return browser.PageLease(site=SITE, device="base", op=op)


async def _say(page: websockets.ClientConnection, message: object) -> None:
    await page.send(browser.FROM_BROWSER.encode(message))  # type: ignore[arg-type]


async def way() -> list[Figure]:
    """Samples up, driving and STOP down, at the lead and through the other hub, by turns."""
    figures = []
    async with deployment(2) as here:
        lead, other = here.hubs
        gateway = await here.gateway(lead)
        for what, measure, middle in (
            ("sample → page", sample_to_page, 2), ("driving frame", drive_to_gateway, math.inf),
            ("STOP", stop_to_gateway, math.inf),
        ):  # fmt: skip
            took: dict[Hub, list[np.ndarray]] = {lead: [], other: []}
            for _ in range(2):
                for hub in here.hubs:
                    page = await here.page(hub)
                    took[hub].append(await measure(gateway, page))
                    await page.close()
            near, far = (np.concatenate(took[hub]) for hub in here.hubs)
            tail = 10 if measure is sample_to_page else 2
            for share, most in ((50, middle), (99, tail)):
                one, two = (float(np.percentile(ages, share)) for ages in (near, far))
                figures += [
                    Figure(f"{what}, p{share} at the lead", one, math.inf, "ms"),
                    Figure(f"{what}, p{share} far: more than that", two - one, most, "ms"),
                ]
    return figures


@contextlib.asynccontextmanager
async def _looking(hub: Hub):  # noqa: ANN202 - `Pages`
    async with role("look", hub.port, "-", "bytes") as process:
        yield Pages(process)


async def cpu() -> list[Figure]:
    """Twenty sites at a lead beside twenty at a hub that is alone, at the same time."""
    async with contextlib.AsyncExitStack() as stack:
        alone = await stack.enter_async_context(deployment(1))
        two = await stack.enter_async_context(deployment(2))
        await asyncio.sleep(5)
        # What a hub takes that has no sites is not theirs: it is told apart.
        idle, idle_two = await asyncio.gather(alone.cpu_over(30), two.cpu_over(30))
        for here in (alone, two):
            many = await stack.enter_async_context(
                crowd_at(here.settings, [here.lead.port], "-", WATCHED, SIGNALS)
            )
            await many.all_back(120)
            await many.all_kept(60)
        await asyncio.sleep(3)
        apart, among = await asyncio.gather(alone.cpu_over(30), two.cpu_over(30))
        figures = [
            Figure("hub that is alone, without sites", 100 * idle[0], math.inf, "% of a core"),
            Figure("lead of two, without sites: more than that", 100 * (idle_two[0] - idle[0]),
                   math.inf, "% of a core"),
            Figure("hub that is alone, 20 sites, nobody looks", 100 * apart[0], math.inf,
                   "% of a core"),
            Figure("lead of two, the same, beside it", among[0] / apart[0], math.inf, "times"),
            Figure("what the sites take of the lead, beside what they take of the one alone",
                   (among[0] - idle_two[0]) / (apart[0] - idle[0]), 1.03, "times"),
            Figure("the other of the two", 100 * among[1], math.inf, "% of a core"),
        ]  # fmt: skip
        for here, hub in ((alone, alone.lead), (two, two.hubs[1])):
            pages = await stack.enter_async_context(_looking(hub))
            for number in range(WATCHED):
                await pages.open_page(here.sessions[0], f"crowd{number}", channels_of(SIGNALS), 100)
        await asyncio.sleep(3)
        apart, among = await asyncio.gather(alone.cpu_over(30), two.cpu_over(30))
        return [
            *figures,
            Figure("hub that is alone, a page looks at each site", 100 * apart[0], math.inf,
                   "% of a core"),
            Figure("lead of two, pages at the other, beside it", among[0] / apart[0], 1.15,
                   "times"),
            Figure("the other of the two", 100 * among[1], math.inf, "% of a core"),
        ]  # fmt: skip


async def gateways(counts: tuple[int, ...] = COUNTS) -> list[Figure]:
    """What gateways of 50 signals at 1 Hz cost one hub, and two of which each has half."""
    figures: list[Figure] = []
    for hubs in (1, 2):
        costs = []
        for count in counts:
            async with deployment(hubs) as here:
                await asyncio.sleep(2)
                memory = np.array([hub.program.memory_info().rss for hub in here.hubs])
                idle = float((await here.cpu_over(6)).sum())
                before = sum(here.cpu_s())
                ports = [hub.port for hub in here.hubs]
                async with crowd_at(here.settings, ports, "-", count, SIGNALS) as many:
                    joined_s = await many.all_back(600) + await many.all_kept(120)
                    join_s = sum(here.cpu_s()) - before
                    sent = await many.samples_sent()
                    await asyncio.sleep(4)
                    used = await here.cpu_over(20)
                    grown = np.array([hub.program.memory_info().rss for hub in here.hubs]) - memory
                running = (float(used.sum()) - idle) / count
                # Those that are there already send while the others still join.
                of_samples = running / SIGNALS * sent
                costs.append((running, (join_s - idle * joined_s - of_samples) / count))
                named = f"{count} gateways, {hubs} hub{'s' if hubs > 1 else ''}"
                # Shown at once: all of them take many minutes.
                measured = [
                    Figure(f"{named}: joined after", joined_s, math.inf, "s"),
                    Figure("CPU for each to join, without its samples", 1e3 * costs[-1][1],
                           math.inf, "ms"),
                    Figure("CPU for each while they send", 1e3 * running, math.inf, "ms/s"),
                    Figure("the lead, of a core", 100 * used[0], math.inf, "%"),
                    Figure("memory of all hubs for each", grown.sum() / count / 1024, math.inf,
                           "KiB"),
                ]  # fmt: skip
                show_figures(measured)
                lead = float(used[0]) / count
        for what, at in (("while they send", 0), ("to join", 1)):
            some = [cost[at] for cost in costs]
            figures.append(
                # That each costs less when they are many is no fault.
                Figure(f"{what}, {hubs} hub{'s' if hubs > 1 else ''}: the dearest of {counts} "
                       "beside the first", max(some) / some[0], 1.1, "times")
            )  # fmt: skip
        figures.append(
            Figure("deployments for 10 000 robots, leads at 0.7 of a core",
                   math.ceil(10_000 * lead / _BEARS), math.inf, "")
        )  # fmt: skip
    return figures


async def _serve_pages(here: Deployment, shares: list[int]) -> np.ndarray:
    """Give what each hub takes (of a core) while so many pages look at each at `HERTZ`."""
    gateway = await here.gateway(here.lead)

    async def send() -> None:
        at, due = 0, time.monotonic()
        while True:
            await gateway.sample(float(at))
            at, due = at + 1, due + 1 / HERTZ
            await asyncio.sleep(max(0.0, due - time.monotonic()))

    sending = asyncio.create_task(send())
    try:
        async with contextlib.AsyncExitStack() as stack:
            for hub, share in zip(here.hubs, shares, strict=True):
                pages = await stack.enter_async_context(_looking(hub))
                for number in range(share):
                    session = here.sessions[number * len(here.sessions) // share]
                    await pages.open_page(session, SITE, [CHANNEL], 0)
            await asyncio.sleep(3)
            return await here.cpu_over(15)
    finally:
        sending.cancel()


async def pages_(count: int = PAGES) -> list[Figure]:
    """Pages that look at one signal at 10 Hz: at one hub, and half of them at each of two."""
    async with deployment(1) as here:
        (one,) = await _serve_pages(here, [count])
    async with deployment(2) as here:
        lead, other = await _serve_pages(here, [count // 2, count // 2])
    return [
        Figure(f"{count} pages at {HERTZ} Hz at a hub that is alone", 100 * one, math.inf,
               "% of a core"),
        Figure("half of them at each of two: the lead", 100 * lead, math.inf, "% of a core"),
        Figure("the other", 100 * other, math.inf, "% of a core"),
        Figure("both together beside the one", (lead + other) / one, 1.2, "times"),
    ]  # fmt: skip


async def shards_(count: int = 200) -> list[Figure]:
    """What the busiest of three hubs takes of gateways: where one leads, and two shards do."""
    used = []
    for shards in (0, 2):
        async with deployment(3, shards=shards) as here:
            await asyncio.sleep(2)
            idle = await here.cpu_over(10)
            ports = [hub.port for hub in here.hubs]
            async with crowd_at(here.settings, ports, "-", count, SIGNALS) as many:
                await many.all_back(600)
                await many.all_kept(120)
                await asyncio.sleep(4)
                used.append((idle, await here.cpu_over(20)))
    (idle_one, one), (idle_two, two) = used
    return [
        Figure("three hubs without sites, one lead", 100 * idle_one.sum(), math.inf, "% of a core"),
        Figure("the same with a main shard and two more", 100 * idle_two.sum(), math.inf,
               "% of a core"),
        Figure(f"{count} gateways, one lead: the busiest hub", 100 * one.max(), math.inf,
               "% of a core"),
        Figure("two shards: the busiest hub", 100 * two.max(), math.inf, "% of a core"),
        Figure("the same beside the one lead", two.max() / one.max(), 0.7, "times"),
        Figure("all hubs together beside those of one lead", two.sum() / one.sum(), 1.2, "times"),
    ]  # fmt: skip


async def kill() -> list[Figure]:
    """The lead of two is killed, with 200 gateways at both."""
    async with deployment(2) as here:
        lead, other = here.hubs
        ports = [hub.port for hub in here.hubs]
        async with crowd_at(here.settings, ports, "-", 200, SIGNALS) as many:
            await many.all_back(300)
            await many.all_kept(60)
            await asyncio.sleep(5)
            began = time.perf_counter()
            await many.expect_loss()
            lead.process.send_signal(signal.SIGKILL)
            while not any("leads" in line for line in other.lines):
                await asyncio.sleep(0.02)
            leads_s = time.perf_counter() - began
            back = np.array(await many.all_again(120))
            await many.all_back(60)
            await many.all_kept(60)
    return [
        Figure("the lead is killed: the other leads after", leads_s, math.inf, "s"),
        Figure("of 200 gateways, back, p50", float(np.percentile(back, 50)), 3, "s"),
        Figure("the same, p99", float(np.percentile(back, 99)), 5, "s"),
    ]


PARTS: dict[str, Callable[..., Coroutine[Any, Any, list[Figure]]]] = {
    "way": way,
    "cpu": cpu,
    "gateways": gateways,
    "pages": pages_,
    "kill": kill,
    "shards": shards_,
}


def main() -> int:
    """Measure the parts asked for, and print them."""
    load_site(site_text(1))
    over = 0
    words = sys.argv[1:]
    counts = tuple(int(word) for word in words if word.isdecimal())
    for name in [word for word in words if not word.isdecimal()] or PARTS:
        load = " ".join(f"{one:.1f}" for one in os.getloadavg())
        print(f"── {name}: {(PARTS[name].__doc__ or '').strip()} (load {load})", flush=True)
        chosen = (
            {"gateways": (counts,), "pages": counts[:1], "shards": counts[:1]}.get(name, ())
            if counts
            else ()
        )
        part: Coroutine[Any, Any, list[Figure]] = PARTS[name](*chosen)
        over += show_figures(asyncio.run(part))
    return 1 if over else 0


if __name__ == "__main__":
    raise SystemExit(main())
