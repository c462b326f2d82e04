"""Measure what the product promises, and print each figure beside its limit.

    make bench                   all of it, about four minutes
    make bench ARGS="load page"  only some parts: load, people, idle, page, drive, drive-demo, size,
                                 demo, history, history-page, history-export, history-servers,
                                 signin, press, many, spool, storm,
                                 join, bear, load-description, camera, camera-slow,
                                 camera-crowd, camera-large, camera-eight,
                                 objects, objects-drive, taps, taps-cloud, taps-drive,
                                 board, scene, scene-cloud, fleet, past, viewers

The limits are those of the first slice. A figure over its limit is marked, and the exit code is
then 1; a shared or busy machine makes single runs noisy, so look twice before you believe one.
"""

from __future__ import annotations

import argparse
import asyncio
import contextlib
import json
import math
import subprocess
import sys
import tempfile
from pathlib import Path
from typing import TYPE_CHECKING

import bearing
import boards
import cameras
import clients
import day
import link
import numpy as np
import objects
import pages
import past
import scenes
import signin
import stack
import taps
import viewers
from figures import Figure, percentiles, show_figures

TOPICS, RATE = 20, 100.0
PEOPLE = 50
if TYPE_CHECKING:
    from talaia.hub.settings import Settings

ROOT = Path(__file__).resolve().parent.parent


async def load() -> list[Figure]:
    """20 Float64 topics at 100 Hz: what gateway and hub cost, and how old a sample arrives."""
    figures = []
    unhurried = stack.running(TOPICS, hurried=False)
    async with unhurried as here, stack.publisher(here, TOPICS, RATE):
        session = await clients.cookie(here)
        await asyncio.sleep(3)
        slowly, _ = await looked_at(here, session, TOPICS)
    async with stack.running(TOPICS) as here, stack.publisher(here, TOPICS, RATE):
        session = await clients.cookie(here)
        await asyncio.sleep(3)
        gateway = stack.cpu_percent(here.gateway, 15)
        alone = stack.cpu_percent(here.hub, 15)
        for name, used, limit in (
            ("gateway, 20 × 100 Hz", await gateway, 9.0),
            ("hub, 20 × 100 Hz, no browser", await alone, 25.0),
        ):
            figures.append(Figure(f"CPU of the {name}", used, limit, "% of a core"))
        found = await watched(here, session, TOPICS)
        quickly = [figure.measured for figure in found[-2:]]
        figures += found
        for part, soon, late in zip(("gateway", "hub"), quickly, slowly, strict=True):
            said = f"CPU of the {part} while it looks, of that with batches of 20 ms"
            figures.append(Figure(said, soon / late, 1.3, "×"))
        many = [
            asyncio.create_task(clients.listen(here, session, TOPICS, 50, 20)) for _ in range(10)
        ]
        await asyncio.sleep(3)
        used = await stack.cpu_percent(here.hub, 14)
        figures.append(Figure("CPU of the hub, ten browsers", used, 25.0, "% of a core"))
        await asyncio.gather(*many)
    return figures


async def looked_at(here: stack.Stack, session: str, topics: int) -> tuple[np.ndarray, np.ndarray]:
    """What gateway and hub take with somebody who sees each sample; how old those are."""
    looking = asyncio.create_task(clients.listen(here, session, topics, 0, 17))
    await asyncio.sleep(2)
    used = np.array(await asyncio.gather(*(stack.cpu_percent(part, 14) for part in here.parts)))
    return used, await looking


async def watched(here: stack.Stack, session: str, topics: int) -> list[Figure]:
    """How old samples come to one who sees each of them, and what that costs."""
    used, ages = await looked_at(here, session, topics)
    return [
        *percentiles("ROS → WebSocket client of the hub", ages, 4, 10),
        Figure("CPU of the gateway while it looks", used[0], math.inf, "% of a core"),
        Figure("CPU of the hub while it looks", used[1], 25.0, "% of a core"),
    ]


async def idle() -> list[Figure]:
    """What an unwatched camera costs the gateway beyond what it stores, and a silent robot."""
    plain, unwatched = [], []
    async with stack.running(TOPICS, camera=True) as here:
        await asyncio.sleep(3)
        silent = await stack.cpu_percent(here.gateway, 12)
        for _ in range(3):  # in turn, since the machine's speed drifts
            for more, into in (((), plain), (("--camera",), unwatched)):
                async with stack.publisher(here, TOPICS, RATE, *more):
                    await asyncio.sleep(3)
                    into.append(await stack.cpu_percent(here.gateway, 8))
    beyond = float(np.median(np.array(unwatched) - np.array(plain)))
    return [
        Figure("gateway, a camera nobody watches, beyond 20 × 100 Hz", beyond, 3.0,
               "% of a core"),
        Figure("gateway, silent robot", silent, 1.0, "% of a core"),
    ]  # fmt: skip


async def page() -> list[Figure]:
    """A sample's way from ROS to the painted chart in Chromium, at 2 000 samples/s."""
    async with stack.running(TOPICS) as here, stack.publisher(here, TOPICS, RATE):
        ages = await pages.painted(here, seconds=20)
    return percentiles("ROS → painted in Chromium", ages, 80, 150)


async def drive() -> list[Figure]:
    """A key press in Chromium until the vehicle has the command."""
    async with stack.running(1) as here:
        target = here.folder / "driven.txt"
        async with stack.publisher(here, 1, 20.0, "--listen", str(target)):
            ages = await pages.pressed(here, target, presses=120)
    return percentiles("key press → cmd_vel received", ages, 10, 10)


async def drive_demo() -> list[Figure]:
    """The same in the whole demo, camera drawn in software and shown: all cores are busy."""
    with tempfile.TemporaryDirectory() as folder:
        ages = await pages.pressed_in_demo(Path(folder), presses=200)
    return percentiles("key press → taken by the demo's vehicle", ages, 10, 30)


async def size() -> list[Figure]:
    """What the first pages weigh, and how soon they are painted."""
    async with stack.running(1) as here:
        kilobytes, paint = await pages.first_paint(here)
    return [
        Figure("JavaScript of sign-in and home, gzip", kilobytes, 200, "kB"),
        Figure("first paint of the dashboard", paint, 1000, "ms"),
    ]


async def demo() -> list[Figure]:
    """How soon the demo is ready on a warm machine."""
    seconds = [await asyncio.to_thread(pages.demo_seconds) for _ in range(3)]
    return [Figure("demo ready, median of 3", float(np.median(seconds)), 10, "s")]


async def press() -> list[Figure]:
    """A frame from a page's socket to a ROS callback: idle, and beside samples and cameras."""
    async with stack.running(1) as here:
        target = here.folder / "driven.txt"
        async with stack.publisher(here, 1, 20.0, "--listen", str(target)):
            ages = await link.driven(here, await clients.cookie(here), target, 250)
    figures = percentiles("page's socket → cmd_vel callback, idle", ages, 8, 8)
    async with stack.running(100, cameras=2) as here:
        target = here.folder / "driven.txt"
        more = ("--listen", str(target), "--cameras", "2")
        async with stack.publisher(here, 100, RATE, *more):
            session = await clients.cookie(here)
            async with link.watching(here, session, "camera0", "camera1"):
                await asyncio.sleep(3)
                ages = await link.driven(here, session, target, 250)
    return figures + percentiles("the same, 10 000 samples/s, two cameras", ages, 20, 20)


async def many() -> list[Figure]:
    """A sample's way to a page's socket at 10 000 samples/s."""
    async with stack.running(100) as here, stack.publisher(here, 100, RATE):
        session = await clients.cookie(here)
        await asyncio.sleep(3)
        found = await watched(here, session, 100)
    return [each._replace(what=f"10 000 samples/s: {each.what}") for each in found]


async def spool() -> list[Figure]:
    """What the gateway keeps on disk: how fast, in what memory, in how much room."""
    said = {}
    for word in ("rate", "day"):
        words = [sys.executable, str(ROOT / "bench" / "spool.py"), word]
        done = await asyncio.to_thread(
            subprocess.run, words, check=True, capture_output=True, text=True
        )
        said |= json.loads(done.stdout)
    return [
        Figure("100 000 samples with fsync each batch take", 1e5 / said["samples_per_s"], 1, "s"),
        Figure("the same, of one core", 1e5 / said["samples_per_cpu_s"], 1, "s"),
        Figure("memory of a gateway's process at that load", said["rss_mib"], 150, "MiB"),
        Figure("a day of 1 000 samples/s on disk, white noise", said["gib_a_day"], 1, "GiB"),
    ]


async def storm() -> list[Figure]:
    """500 gateways that lose the link at once, beside one that is being driven."""
    async with stack.running(1) as here:
        target = here.folder / "driven.txt"
        async with stack.publisher(here, 1, 20.0, "--listen", str(target)):
            took, grown, ages = await link.storm(here, target, 500)
    return [
        Figure("500 gateways back after", took, 60, "s"),
        Figure("the hub grew by", grown, 64, "MiB"),
        *percentiles("driving meanwhile", ages, 20, 20),
        Figure("driving frames that did not arrive", 100 - ages.size / 2, 5, "%"),
    ]


async def join() -> list[Figure]:
    """New gateways with 50 signals at 1 Hz: how soon they are there, and what each costs."""
    figures, costs = [], {}
    for count in (10, 50, 100, 200, 500):
        async with stack.running(1) as here:
            costs[count] = found = await link.join(here, count, 50, 20.0)
        last = count == 500
        figures += [
            Figure(f"{count} new gateways: all linked after", found.joined_s,
                   30 if last else math.inf, "s"),
            Figure("a batch of each acknowledged after another", found.kept_s, math.inf, "s"),
            Figure("CPU of the hub for each to join", found.join_ms, math.inf, "ms"),
            Figure("the same with samples of those that are there", found.with_samples_ms,
                   math.inf, "ms"),
            Figure("CPU for each to come again, known", found.again_ms, 10, "ms"),
            Figure("all back after a blow", found.back_s, 20 if last else math.inf, "s"),
            Figure("hub while they send", 100 * found.running, 70 if last else math.inf,
                   "% of a core"),
            Figure("CPU of the hub for each sample", found.row_us, math.inf, "µs"),
            Figure("memory of the hub for each", found.memory_kib, math.inf, "KiB"),
        ]  # fmt: skip
    # What comes once, whoever joins, is told apart from what comes with each by a straight line.
    counts = np.array(list(costs))
    in_all_ms = np.array([costs[each].join_ms * each for each in costs])
    each_ms, once_ms = np.polyfit(counts, in_all_ms, 1, w=1 / counts)
    away = [abs(costs[each].join_ms / (each_ms + once_ms / each) - 1) for each in costs]
    return [
        *figures,
        Figure("CPU to join: for each, by a line through all", float(each_ms), math.inf, "ms"),
        Figure("the same: once", float(once_ms), math.inf, "ms"),
        Figure("farthest from that line, from 50 on",
               100 * max(far for far, count in zip(away, costs, strict=True) if count >= 50), 10,
               "%"),
    ]  # fmt: skip


async def bear() -> list[Figure]:
    """Gateways that are there, silent or with 50 signals at 1 Hz: what each costs a second."""
    figures = []
    for count, signals in ((500, 0), (500, 50), (1000, 50), (2000, 50)):
        async with stack.running(1) as here:
            found = await bearing.bear(here, count, signals, 30.0)
        figures += [
            Figure(f"{count} gateways of {signals} signals: hub", 100 * found.running,
                   100.0, "% of a core"),
            Figure("CPU of the hub for each in a second", found.each_us, math.inf, "µs"),
            Figure("memory of the hub for each", found.memory_kib, math.inf, "KiB"),
            Figure("samples that were not sent, for want of acknowledgements",
                   100 * (1 - found.sent), 5, "%"),
            *percentiles("an answer of the hub meanwhile", found.asked_ms, math.inf, math.inf),
        ]  # fmt: skip
    return figures


async def viewers_() -> list[Figure]:
    """50 to 500 pages that look at ten signals at 10 Hz, beside bare servers of such frames."""
    figures = []
    for tls in (False, True):
        found = await viewers.measure([50, 200, 500], tls=tls)
        for at, ours in enumerate(found["hub"]):
            name = f"{ours.pages} pages{', TLS' if tls else ''}"
            figures += [
                Figure(f"{name}: CPU of the hub for a frame and page", ours.frame_us,
                       math.inf if tls else 20, "µs"),
                *(
                    Figure(f"{name}: {what}", found[how][at].frame_us, math.inf, "µs")
                    for how, what in (("broadcast", "the same of broadcast of websockets"),
                                      ("written", "the same of ready bytes to each socket"))
                ),
                Figure(f"{name}: age of the newest sample, p50", ours.p50, math.inf, "ms"),
                Figure(f"{name}: the same, p99", ours.p99, 60, "ms"),
                Figure(f"{name}: p99 of broadcast's own frames", found["broadcast"][at].p99,
                       math.inf, "ms"),
            ]  # fmt: skip
    return figures


async def history() -> list[Figure]:
    """The history store beside one row a sample; prints its own table."""
    script = str(ROOT / "bench" / "history.py")
    done = await asyncio.to_thread(subprocess.run, [sys.executable, script], check=False)
    return [Figure("limits of the history that are missed", done.returncode, 0, "limits")]


async def history_large() -> list[Figure]:
    """Reads in a store of a thousand million samples; takes some minutes and 3 GB of disk."""
    words = [str(ROOT / "bench" / "history.py"), "--large", "12", "--samples", "0"]
    done = await asyncio.to_thread(
        subprocess.run, [sys.executable, *words, "--servers", "0"], check=False
    )
    return [Figure("limits of large stores that are missed", done.returncode, 0, "limits")]


async def history_export() -> list[Figure]:
    """Files of the history beside DuckDB's of the same samples; prints its own table."""
    script = str(ROOT / "bench" / "history_export.py")
    done = await asyncio.to_thread(subprocess.run, [sys.executable, script], check=False)
    return [Figure("limits of files that are missed", done.returncode, 0, "limits")]


async def history_servers() -> list[Figure]:
    """Histories on one database server and on two, and a hub with 10 000 signals; its own table."""
    script = str(ROOT / "bench" / "history_servers.py")
    await asyncio.to_thread(subprocess.run, [sys.executable, script], check=True)
    return []


async def history_page() -> list[Figure]:
    """Ten charts of a day (10 Hz each, 8.64 M samples) in Chromium, from the click on."""
    charts, rate = 10, 10

    async def fill(settings: Settings) -> None:
        await day.fill_yesterday(settings, charts, rate)

    start = day.yesterday_us()
    async with stack.running(charts, before=fill) as here:
        took = await pages.day_drawn(here, charts, start, times=8)
    return [
        Figure("click → ten charts of a day drawn, median of 8", float(np.median(took)), 300, "ms"),
        Figure("click → ten charts of a day drawn, slowest", float(took.max()), 300, "ms"),
    ]


async def people() -> list[Figure]:
    """Fifty people signed in and looking at everything, beside one of them alone."""
    async with stack.running(TOPICS) as here, stack.publisher(here, TOPICS, RATE):
        names = await stack.add_people(here, PEOPLE)
        sessions = [await clients.cookie(here, name) for name in names]
        alone = await clients.listen(here, sessions[0], TOPICS, 50, 10)
        together = [
            asyncio.create_task(clients.listen(here, each, TOPICS, 50, 16)) for each in sessions
        ]
        await asyncio.sleep(4)
        used = await stack.cpu_percent(here.hub, 10)
        ages = np.concatenate(await asyncio.gather(*together))
    one, all_of_them = float(np.percentile(alone, 99)), float(np.percentile(ages, 99))
    return [
        *percentiles(f"{PEOPLE} people, ROS → WebSocket client every 50 ms", ages, 65, 250),
        Figure(f"the p99 of {PEOPLE} people beside that of one", all_of_them / one, 3, "times"),
        Figure(f"CPU of the hub, {PEOPLE} people", used, 80.0, "% of a core"),
    ]


async def load_description() -> list[Figure]:
    """A site description of 10 000 signals, read and checked in a process of its own."""
    words = [sys.executable, str(ROOT / "bench" / "description.py"), "10000"]
    took = []
    for _ in range(5):
        done = await asyncio.to_thread(
            subprocess.run, words, check=True, capture_output=True, text=True
        )
        took.append(json.loads(done.stdout))
    wall, cpu = (float(np.median([each[key] for each in took])) for key in ("wall_s", "cpu_s"))
    return [
        Figure("10 000 signals read and checked, median of 5", wall, 2, "s"),
        Figure("the same, of one core", cpu, 1.2, "s"),
    ]


async def camera() -> list[Figure]:
    """A camera of 640×480 at 30 Hz, from the gateway's hands to the canvas in Chromium."""
    figures = []
    async with stack.running(1, camera=True) as here, stack.publisher(here, 1, 20.0, "--film", "4"):
        session = await clients.cookie(here)
        for film in (True, False):
            ages = await pages.filmed(here, 15, film=film)
            name = "H.264" if film else "JPEG"
            figures += [
                Figure(f"{name}: gateway → canvas, p50 of {ages.size}",
                       float(np.percentile(ages, 50)), 6, "ms"),
                Figure(f"{name}: gateway → canvas, p95", float(np.percentile(ages, 95)), 12, "ms"),
            ]  # fmt: skip
        unseen, used = [], []
        for _ in range(3):  # in turn, since the machine's speed drifts
            await asyncio.sleep(4)  # a camera goes on for a moment after the last page
            unseen.append(await stack.cpu_percent(here.gateway, 8))
            async with cameras.looking(here, session) as got:
                await asyncio.sleep(4)
                got.clear()
                used.append(await stack.cpu_percent(here.gateway, 12))
        beyond = float(np.median(np.array(used) - np.array(unseen)))
        mbits = sum(each.size for each in got) * 8 / 12 / 1e6
        small = 100 * sum(each.small for each in got) / len(got)
        figures += [
            Figure("of the pictures are small ones", small, 1, "%"),
            Figure("the film takes", mbits, 2.0, "Mbit/s"),
            Figure(f"of 30 pictures a second do not come ({len(got)} came)",
                   max(0.0, 30 - len(got) / 12), 1.5, "Hz"),
            Figure("CPU of the gateway for it, beyond nobody looking", beyond, 12.0,
                   "% of a core"),
            Figure("CPU of the gateway, all of it", float(np.median(used)), math.inf,
                   "% of a core"),
        ]  # fmt: skip
    return figures


async def camera_slow() -> list[Figure]:
    """Noise at night: a viewer at 1 Mbit/s beside a good line; the same at a foxglove server."""
    async with (
        stack.running(1, camera=True) as here,
        stack.publisher(here, 1, 20.0, "--film", "30"),
    ):
        session = await clients.cookie(here)
        async with cameras.looking(here, session) as good:
            await asyncio.sleep(5)
            alone = np.array([each.age_ms for each in good][-60:])
            async with cameras.throttled(here.port, 1e6) as port:
                before = cameras.memory_mib(here.hub.process.pid)
                async with cameras.looking(here, session, port) as slow:
                    await asyncio.sleep(5)
                    slow.clear()
                    good.clear()
                    await asyncio.sleep(25)
                    grown = cameras.memory_mib(here.hub.process.pid) - before
            ages = np.array([each.age_ms for each in slow])
            beside = np.array([each.age_ms for each in good])
    theirs, their_growth = await cameras.foxglove(1e6, 30)
    return [
        Figure(f"at 1 Mbit/s: age when it has arrived, p50 of {ages.size}",
               float(np.percentile(ages, 50)), 300, "ms"),
        Figure("at 1 Mbit/s: p99", float(np.percentile(ages, 99)), 300, "ms"),
        Figure("at 1 Mbit/s: oldest", float(ages.max()), 300, "ms"),
        Figure("at 1 Mbit/s: pictures a second missing to 10", max(0, 10 - ages.size / 25), 0, ""),
        Figure("the large film takes",
               sum(each.size for each in good) * 8 / 25e6, 2.0, "Mbit/s"),
        Figure("the hub grew by", grown, 16, "MiB"),
        Figure("the other viewer's p95 rose by",
               float(np.percentile(beside, 95) - np.percentile(alone, 95)), 10, "ms"),
        Figure("foxglove-sdk server (JPEG), the same line: p50 of age", theirs, np.inf, "ms"),
        Figure("foxglove-sdk server grew by", their_growth, np.inf, "MiB"),
    ]  # fmt: skip


async def camera_crowd() -> list[Figure]:
    """Twenty viewers of one camera beside one."""
    used = []
    async with stack.running(1, camera=True) as here, stack.publisher(here, 1, 20.0, "--film", "4"):
        session = await clients.cookie(here)
        for viewers in (1, 20):
            async with contextlib.AsyncExitStack() as crowd:
                seen = [
                    await crowd.enter_async_context(cameras.looking(here, session))
                    for _ in range(viewers)
                ]
                await asyncio.sleep(4)
                for each in seen:
                    each.clear()
                used.append(await stack.cpu_percent(here.gateway, 10))
                least = min(len(each) for each in seen)
    return [
        Figure("CPU of the gateway, twenty viewers beside one", used[1] / used[0], 1.15, "times"),
        Figure("pictures that the worst of twenty missed", max(0, 300 - least) / 3, 10, "%"),
    ]


async def camera_large() -> list[Figure]:
    """1080p and 4K at 30 Hz, raw and as the camera's own JPEG: what comes, and driving beside."""
    figures = load_figures("no camera", await cameras.load_of(0))
    for size, name in (("1920x1080", "1080p"), ("3840x2160", "4K")):
        for compressed in (False, True):
            found = await cameras.load_of(1, size, compressed=compressed)
            figures += load_figures(f"{name}, {'JPEG' if compressed else 'raw'}", found)
    return figures


async def camera_eight() -> list[Figure]:
    """Eight cameras of 640×480 at 30 Hz: looked at by nobody, then all of them at once."""
    return [
        *load_figures("eight, nobody looks", await cameras.load_of(8, watched=False)),
        *load_figures("eight, all looked at", await cameras.load_of(8)),
    ]


def load_figures(what: str, found: cameras.Load) -> list[Figure]:
    """Give what cameras cost and what came of them; driving and samples have limits."""
    figures = [
        Figure(f"{what}: CPU of the gateway", found.gateway, math.inf, "% of a core"),
        Figure(f"{what}: CPU of the hub", found.hub, math.inf, "% of a core"),
        *percentiles(f"{what}: page's socket → cmd_vel", found.drives_ms, 8, 20),
        Figure(f"{what}: driving frames that did not arrive", 100 - found.drives_ms.size / 3, 5,
               "%"),
        *percentiles(f"{what}: ROS → page's socket", found.samples_ms, 20, 60),
    ]  # fmt: skip
    if not found.rates:
        return figures
    return [
        *figures,
        Figure(f"{what}: pictures of {found.size[0]}×{found.size[1]}, all cameras",
               -sum(found.rates), math.inf, "Hz (-)"),
        Figure(f"{what}: the best served camera beside the worst",
               max(found.rates) / max(0.1, min(found.rates)), 1.25, "times"),
        *percentiles(f"{what}: a picture's age at the viewer", found.ages_ms, 150, 500),
        Figure(f"{what}: what came", found.mbits, math.inf, "Mbit/s"),
    ]  # fmt: skip


async def see() -> list[Figure]:
    """NanoDet on a camera of 640×480 at 30 Hz, from its ROS topic to boxes at the hub's door."""
    found = await objects.seen()
    return [
        Figure("from one picture's boxes to the next's, mean", 1000 / found.rate, 100, "ms"),
        Figure("a picture's age when its boxes are there, p50", float(np.median(found.ages_ms)),
               200, "ms"),
        Figure("the same, p95", float(np.percentile(found.ages_ms, 95)), 400, "ms"),
        Figure("what one picture costs its process", found.detector / found.rate * 10, 100,
               "ms of CPU"),
        Figure("CPU of the gateway beside it", found.gateway, 20, "% of a core"),
        Figure("pictures on which the cup was missed", 100 - found.wanted, 20, "%"),
    ]  # fmt: skip


async def see_and_drive() -> list[Figure]:
    """Driving by the film of a camera, without detection and with it at either place, in turn."""
    ages = await objects.driven()
    p99 = {way: float(np.percentile(each, 99)) for way, each in ages.items()}
    figures = percentiles("driving by the picture, nothing looks", ages.pop("nothing"), 8, 20)
    for way, each in ages.items():
        figures += percentiles(f"the same, looking: {way}", each, 8, 20)
        # At 10 Hz it is to be nothing that anybody notices; what 30 Hz take is only told.
        limit = 2 if way in ("gateway", "hub") else math.inf
        figures.append(Figure("p99 later by", p99[way] - p99["nothing"], limit, "ms"))
    return figures


async def signin_() -> list[Figure]:
    """Whether a refused sign-in tells by its time that there is a person of that name."""
    known, other = await signin.refusals(60)
    middle = float(np.median(known))
    beyond = abs(middle - float(np.median(other))) / middle * 100
    # Two halves of the same: what the machine alone makes of it.
    noise = abs(float(np.median(known[::2])) - float(np.median(known[1::2]))) / middle * 100
    return [
        Figure("known and unknown name, medians apart", beyond, 10.0, "%"),
        Figure("the same name twice, medians apart (noise)", noise, 10.0, "%"),
    ]


async def taps_() -> list[Figure]:
    """20 × 100 Hz raw to a Foxglove client, in turn with a foxglove-sdk server; about a minute."""
    names = [f"/bench/s{number}" for number in range(TOPICS)]
    async with stack.running(0, tapped=True) as here, stack.publisher(here, TOPICS, RATE):
        asked_for = await asyncio.to_thread(taps.subscriptions, here, names)
        found = await taps.side_by_side(here, TOPICS, rounds=2, seconds=8)
    (ours, ages), (theirs, their_ages) = found["talaia"], found["foxglove-sdk"]
    return [
        Figure("subscriptions on the robot without takers", asked_for, 0, ""),
        Figure("CPU of gateway and hub for 20 × 100 Hz raw", ours, math.inf, "% of a core"),
        Figure("CPU of foxglove-sdk with rclpy", theirs, math.inf, "% of a core"),
        Figure("the former beside the latter", ours / theirs, 1, "times"),
        *percentiles("ROS → Foxglove client", ages, 5, 10),
        *percentiles("the same of foxglove-sdk", their_ages, math.inf, math.inf),
        Figure("messages that did not come", 100 - ages.size / (16 * TOPICS * RATE) * 100, 2, "%"),
    ]


async def taps_cloud() -> list[Figure]:
    """A 1 MB cloud at 10 Hz to three Foxglove clients, then one of them at 1 Mbit/s."""
    async with stack.running(0, tapped=True) as here, stack.publisher(here, 0, 1, "--clouds", "10"):
        address, trust, cloud = await taps.open_door(here), stack.context(here), {"/bench/cloud"}
        async with contextlib.AsyncExitStack() as open_now:
            two = [
                await open_now.enter_async_context(taps.taking(address, cloud, trust=trust))
                for _ in range(2)
            ]
            async with taps.taking(address, cloud, trust=trust) as third:
                await asyncio.sleep(3)
                everyone = [*two, third]
                for heard in everyone:
                    heard.clear()
                before = taps.line_bytes(here)
                used = await stack.cpu_percent(here.hub, 10)
                copies = (taps.line_bytes(here) - before) / max(one.bytes for one in everyone)
                alone = np.array([age for one in everyone for age in one.ages_ms])
            async with cameras.throttled(here.port, 1e6) as port:
                memory = taps.memory_mib(here.hub.process.pid)
                async with taps.taking(address, cloud, trust=trust, port=port):
                    await asyncio.sleep(3)
                    for heard in two:
                        heard.clear()
                    await asyncio.sleep(12)
                    grown = taps.memory_mib(here.hub.process.pid) - memory
                    # Before the slow one says good-bye, which takes it a while.
                    beside = np.array([age for heard in two for age in heard.ages_ms])
    later = float(np.percentile(beside, 95) - np.percentile(alone, 95))
    return [
        Figure("copies on the gateway's line", copies, 1.05, "times"),
        Figure("CPU of the hub, three takers of 10 MB/s", used, 15, "% of a core"),
        *percentiles("a cloud's age at the client", alone, math.inf, math.inf),
        Figure("clouds that the others miss beside one at 1 Mbit/s",
               100 - beside.size / 240 * 100, 5, "%"),
        Figure("p95 of the others later by", later, 10, "ms"),
        Figure("the hub grew by", grown, 8, "MiB"),
    ]  # fmt: skip


async def taps_drive() -> list[Figure]:
    """Driving while 20 MB/s of taps run, in turn with none."""
    ages: dict[bool, list[np.ndarray]] = {False: [], True: []}
    async with stack.running(1, tapped=True) as here:
        target = here.folder / "driven.txt"
        # Clouds of another process: what writes them is not to hold up who listens.
        async with (
            stack.publisher(here, 1, 20.0, "--listen", str(target)),
            stack.publisher(here, 0, 1, "--clouds", "20"),
        ):
            session, address = await clients.cookie(here), await taps.open_door(here)
            for _ in range(2):
                ages[False].append(await link.driven(here, session, target, 150))
                async with taps.taking(address, {"/bench/cloud"}, trust=stack.context(here)):
                    await asyncio.sleep(2)
                    ages[True].append(await link.driven(here, session, target, 150))
    without, with_taps = (np.concatenate(ages[tapped]) for tapped in (False, True))
    later = float(np.percentile(with_taps, 99) - np.percentile(without, 99))
    return [
        *percentiles("page's socket → cmd_vel, no taps", without, 8, 20),
        *percentiles("the same, 20 MB/s of taps", with_taps, 8, 20),
        Figure("p99 later by", later, 2, "ms"),
    ]


async def board() -> list[Figure]:
    """A board of 40 live tiles, all on the screen, each signal at 20 Hz."""
    async with (
        stack.running(boards.SIGNALS) as here,
        stack.publisher(here, boards.SIGNALS, 20.0, "--waves"),
    ):
        key = await boards.keep_board(here, boards.board_of_tiles())
        used = await boards.page_percent(here, key, 6)
        charts, rest = await boards.socket_to_paint(here, key, 12)
        clicked, data = await boards.board_opened(here, key, 5)
    return [
        Figure("40 tiles at 20 Hz: the page's process, least of three", min(used), 35,
               "% of a core"),
        *percentiles("socket → charts painted", charts, 60, 60),
        *percentiles("socket → the rest painted", rest, 60, 60),
        Figure("the board opened: first data → painted, median of 5", float(np.median(data)), 300,
               "ms"),
        Figure("click → painted, median of 5", float(np.median(clicked)), math.inf, "ms"),
    ]  # fmt: skip


async def fleet() -> list[Figure]:
    """A thousand sites: how soon they are there, and the longest pause while one scrolls."""
    figures = []
    async with stack.running(1) as here, link.crowd(here, 1000) as many:
        await many.all_back(300)
        for path, ready in (("/home", "t-fleet-card"), ("/fleet", "t-fleet-chooser label")):
            found = await boards.fleet_opened(here, path, ready, 8)
            figures += [
                Figure(f"1 000 sites, {path}: first paint", found.first_paint, 1000, "ms"),
                Figure(f"1 000 sites, {path}: listed", found.listed, math.inf, "ms"),
                Figure(f"scrolling: longest pause between {found.pauses.size} frames",
                       float(found.pauses.max()), 1000, "ms"),
            ]  # fmt: skip
    return figures


async def past_() -> list[Figure]:
    """An hour of 50 signals, a film and a scan on a board: to another moment, and ten times."""
    start = past.begin_us()

    async def fill(settings: Settings) -> None:
        await past.fill_hour(settings, start)

    async with (
        stack.running(past.SIGNALS, camera=True, tapped=True, before=fill) as here,
        pages.browser_page(past.NOTE_PAST, height=boards.HEIGHT, flags=pages.SPACE_FLAGS) as page,
    ):
        await past.open_past(page, here, start)
        jumps = await past.scrub(page, start, 12, drag=False)
        drags = await past.scrub(page, start, 6, drag=True)
        played = await past.play(page, start, 12)
    figures = []
    for what, limit in (("values", 200), ("charts", 200), ("film", 200), ("scan", 200),
                        ("all", 200)):  # fmt: skip
        took = np.array([one[what] for one in jumps])
        figures.append(Figure(f"to another moment: {what}, median of {took.size}",
                              float(np.median(took)), limit, "ms"))  # fmt: skip
    slowest = max(one["all"] for one in jumps)
    after = float(np.median([one["all"] for one in drags]))
    return [
        *figures,
        Figure("to another moment: all, slowest", slowest, math.inf, "ms"),
        Figure(f"after a hand's last move: all, median of {len(drags)}", after, 200, "ms"),
        Figure("play at 10 times: real time beside the played, × 10", 10 / played.speed, 1 / 0.95,
               "times"),
        Figure("playing: longest pause between frames", float(played.frames.max()), 250, "ms"),
        Figure("playing: pause between frames, p99", float(np.percentile(played.frames, 99)), 100,
               "ms"),
        Figure("playing: the moment stood for, longest", float(played.stands.max()), 250, "ms"),
        Figure("playing: the scan stood for, longest", float(played.scans.max()), 500, "ms"),
    ]  # fmt: skip


async def scene() -> list[Figure]:
    """A robot of 30 links and a scan in space, beside a bare page."""
    words = ("--links", str(scenes.LINKS), "--scan", "10")
    async with stack.running(0, tapped=True) as here, scenes.robot(here, *words):
        ours, bare = await scenes.side_by_side(here, cloud=False, rounds=3, seconds=8)
    return scene_figures("scan and links", ours, bare, limit_ms=60)


async def scene_cloud() -> list[Figure]:
    """The same with 100 000 points, and what is heard of the robot for another page."""
    words = ("--links", str(scenes.LINKS), "--scan", "10")
    async with (
        stack.running(0, tapped=True) as here,
        scenes.robot(here, *words),
        scenes.robot(here, "--cloud", "10"),
    ):
        ours, bare = await scenes.side_by_side(here, cloud=True, rounds=3, seconds=8)
        looking, elsewhere = await scenes.heard_elsewhere(here)
    theirs = float(np.median(np.concatenate([one.scan_ms for one in bare])))
    return [
        *scene_figures("with the cloud", ours, bare, limit_ms=theirs + 30),
        Figure("subscriptions on the robot while it is looked at", looking, 3, ""),
        Figure("the same from another page", elsewhere, 0, ""),
    ]


def scene_figures(
    what: str, ours: list[scenes.Seen], bare: list[scenes.Seen], *, limit_ms: float
) -> list[Figure]:
    """Give the figures of our page and of the bare one, drawn by turns."""
    pairs = list(zip(ours, bare, strict=True))
    ratio = float(np.median([a.frames / b.frames for a, b in pairs]))
    ages, their_ages = (np.concatenate([one.scan_ms for one in them]) for them in (ours, bare))
    return [
        Figure(f"{what}: bare page's frames beside ours, of the median round", 1 / ratio,
               1 / 0.9, "times"),
        Figure(f"{what}: frames", -float(np.median([one.frames for one in ours])), math.inf,
               "Hz (-)"),
        Figure(f"{what}: frames of the bare page",
               -float(np.median([one.frames for one in bare])), math.inf, "Hz (-)"),
        Figure(f"{what}: scan published → painted, p50 of {ages.size}", float(np.median(ages)),
               limit_ms, "ms"),
        Figure(f"{what}: the same of the bare page, p50 of {their_ages.size}",
               float(np.median(their_ages)), math.inf, "ms"),
        Figure(f"{what}: processor time of a frame beside the bare page's",
               float(np.median([a.frame_ms / b.frame_ms for a, b in pairs])), 1 / 0.9, "times"),
        Figure(f"{what}: the page's process",
               float(np.median([one.page for one in ours])), math.inf, "% of a core"),
        Figure(f"{what}: that of the bare page",
               float(np.median([one.page for one in bare])), math.inf, "% of a core"),
        Figure(f"{what}: clouds painted, ours and bare",
               float(np.median([one.clouds for one in ours])),
               math.inf, f"Hz ({np.median([one.clouds for one in bare]):.1f})"),
    ]  # fmt: skip


PARTS = {
    "scene": scene, "scene-cloud": scene_cloud, "board": board, "fleet": fleet, "past": past_,
    "load": load, "people": people, "idle": idle, "page": page, "drive": drive,
    "drive-demo": drive_demo, "size": size, "demo": demo, "history": history,
    "history-large": history_large, "history-page": history_page, "signin": signin_,
    "history-export": history_export, "history-servers": history_servers,
    "load-description": load_description, "camera": camera, "camera-slow": camera_slow,
    "camera-crowd": camera_crowd, "camera-large": camera_large,
    "camera-eight": camera_eight, "objects": see, "objects-drive": see_and_drive, "press": press,
    "many": many, "spool": spool, "storm": storm, "join": join, "bear": bear,
    "viewers": viewers_, "taps": taps_,
    "taps-cloud": taps_cloud, "taps-drive": taps_drive,
}  # fmt: skip


def main() -> int:
    """Run the parts asked for."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("part", nargs="*", help=f"of: {', '.join(PARTS)} (all)")
    chosen = parser.parse_args().part or list(PARTS)
    over = 0
    for name in chosen:
        print(f"── {name}: {(PARTS[name].__doc__ or '').strip()}", flush=True)
        over += show_figures(asyncio.run(PARTS[name]()))
    return 1 if over else 0


if __name__ == "__main__":
    raise SystemExit(main())
