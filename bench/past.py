"""An hour that is scrubbed: 50 signals, a film and a scan, on a board in a real Chromium.

All of it is put into the hub's folder before the hub starts. Each signal's value is the time since
the hour's begin (s), so that whoever sees it knows of which moment it is.
"""

from __future__ import annotations

import asyncio
import datetime as dt
import json
import math
import random
import time
from typing import TYPE_CHECKING, Any, NamedTuple

import boards
import films
import numpy as np
import pages
from rosbags.typesys import Stores, get_typestore

from talaia.clock import SystemClock
from talaia.gateway.recording.mcap_file import McapFileWriter
from talaia.gateway.recording.message_ring import RawMessage
from talaia.gateway.video.camera import PictureStream
from talaia.hub.history.store import HistoryStore
from talaia.hub.store.sites.recordings import Recorded, RecordingState
from talaia.model.connection import RosSource
from talaia.model.site import Stream
from talaia.wire.columns import Columns
from talaia.wire.frames import PictureFrame

if TYPE_CHECKING:
    from pathlib import Path

    from playwright.async_api import Page
    from stack import Stack

    from talaia.hub.settings import Settings

STORE = get_typestore(Stores.LATEST)
SCAN, TRANSFORMS = "sensor_msgs/msg/LaserScan", "tf2_msgs/msg/TFMessage"
SIGNALS, RATE_HZ, HOUR_S, SECOND_US = 50, 10, 3600, 1_000_000
# Of the film and of the scan; a film is begun anew after so long.
PICTURES_HZ, SCANS_HZ, FILM_S = 10, 10, 600
BEAMS = 640
AT_ONCE = 20_000
# Tiles of signals, with how many each has; beside them stand the camera and the scene.
TILES = (("value", 1, 18), ("chart", 3, 6), ("gauge", 1, 4), ("table", 5, 2))
SPEED = 10
# What is shown of a moment, and how long it took (ms). Values say of which time they are; charts
# and the scene tell what they drew; the film's place is its own. Told once the frame is on its way.
NOTE_PAST = """
(() => {
  const note = { at: NaN, began: 0, took: null, charts: new Map(), scan: NaN, beginUs: 0, all: 0 };
  window.__past = note;
  window.__talaiaPainted = (address, newestUs) => note.charts.set(address, newestUs);
  window.__talaiaSceneDrawn = (news) => {
    for (const [topic, us] of news) if (topic === '/bench/scan') note.scan = us;
  };
  const deep = function* (root, name) {
    for (const element of root.querySelectorAll('*')) {
      if (element.localName === name) yield element;
      if (element.shadowRoot) yield* deep(element.shadowRoot, name);
    }
  };
  let known = null;
  const parts = () => {
    if (known?.bar.isConnected) return known;
    const bar = [...deep(document, 't-time-bar')][0];
    if (bar === undefined) return null;
    const board = [...deep(document, 't-board-view')][0].shadowRoot;
    known = { bar, values: [...deep(board, 't-value')], film: [...deep(board, 't-film-view')][0] };
    return known;
  };
  // Of charts two pixels of a window, of scans those that are left out.
  const near = (us, aboutUs) => us <= note.at + 1e3 && us > note.at - aboutUs;
  const shown = ({ values, film }) => ({
    values: values.length > 0 && values.every(({ value, state }) =>
      state !== 'unknown' && near(note.beginUs + value * 1e6, 0.15e6)),
    charts: note.charts.size >= note.all
      && [...note.charts.values()].every((us) => near(us, 0.6e6)),
    film: film !== undefined && near(film.shownUs, 0.15e6),
    scan: near(note.scan, 0.45e6),
  });
  const watch = () => {
    requestAnimationFrame(watch);
    if (note.took === null || note.took.all) return;
    const found = parts();
    if (found === null) return;
    const now = performance.now() - note.began;
    const is = shown(found);
    for (const [name, there] of Object.entries(is)) if (there) note.took[name] ??= now;
    if (Object.values(is).every((there) => there)) {
      const { took, began } = note;
      requestAnimationFrame(() => { took.all ??= performance.now() - began; });
    }
  };
  requestAnimationFrame(watch);
  note.seek = (us) => {
    Object.assign(note, { at: us, began: performance.now(), took: {} });
    note.charts.clear();
    parts().bar.dispatchEvent(new CustomEvent('t-seek', { detail: us }));
  };
  note.play = (speed) => {
    const { bar } = parts();
    bar.dispatchEvent(new CustomEvent('t-speed', { detail: speed }));
    bar.dispatchEvent(new CustomEvent('t-play'));
    note.ticks = [];
    const tick = () => {
      if (note.ticks === null) return;
      note.ticks.push([performance.now(), bar.us, note.scan]);
      requestAnimationFrame(tick);
    };
    tick();
  };
})();
"""


class Played(NamedTuple):
    """What was seen while it played.

    Attributes:
        speed: how fast the moment went on.
        frames: pauses between frames (ms).
        stands: how long the moment that is shown stood still (ms).
        scans: how long the scan that is shown stayed the same (ms).

    """

    speed: float
    frames: np.ndarray
    stands: np.ndarray
    scans: np.ndarray


def begin_us() -> int:
    """Give the begin of the last hour that is over, at a full minute (µs, UTC)."""
    now_us = SystemClock().wall_ns() // 1000
    return (now_us // (60 * SECOND_US) - 62) * 60 * SECOND_US


async def fill_hour(settings: Settings, start_us: int) -> None:
    """Put all of it into a hub that does not run."""
    await _fill_signals(settings, start_us)
    folder = settings.data / "recordings" / "bench"
    folder.mkdir(parents=True)
    await asyncio.to_thread(_fill_films, folder, start_us)
    await asyncio.to_thread(_fill_scans, folder, start_us)


async def _fill_signals(settings: Settings, start_us: int) -> None:
    addresses = tuple(f"base/s{number}" for number in range(SIGNALS))
    store = HistoryStore(settings.url, SystemClock())
    await store.open()
    count = HOUR_S * RATE_HZ * SIGNALS
    for first in range(0, count, AT_ONCE):
        index = np.arange(first, min(first + AT_ONCE, count))
        at, channel = index // SIGNALS, index % SIGNALS
        columns = Columns(
            channel.astype(np.uint16), start_us + at * (SECOND_US // RATE_HZ), at / RATE_HZ, {}
        )
        await store.append_samples("bench", "past", first, addresses=addresses, columns=columns)
    await store.close()


def _fill_films(folder: Path, start_us: int) -> None:
    pictures = _encoded(30 * PICTURES_HZ)
    for begin in range(0, HOUR_S, FILM_S):
        part, whole = folder / "film.part", folder / f"film{begin}.mp4"
        first_us, step_us = start_us + begin * SECOND_US, SECOND_US // PICTURES_HZ
        times_us = range(first_us, first_us + FILM_S * PICTURES_HZ * step_us, step_us)
        file = films.write_pictures(part, pictures, times_us, stream="base/front")
        file.finish_file(part, whole)
        part.unlink()
        _describe(whole, (first_us, file.end_us), messages=file.pictures, stream="base/front")


def _encoded(count: int) -> list[PictureFrame]:
    """Encode some pictures as a gateway films them."""
    sink = films.Sink(film=True)
    source = RosSource(topic="/bench/image", type="sensor_msgs/msg/Image")
    stream = PictureStream(
        "base/front", Stream(name="Front", source=source), lambda raw: raw, lambda *_: None
    )
    for at, picture in enumerate(films.pictures(60) * -(-count // 60)):
        at_us = at * (SECOND_US // PICTURES_HZ)
        stream.process_picture(picture, at_us, at_us, sink)
    return sink.filmed[:count]


def _fill_scans(folder: Path, start_us: int) -> None:
    path = folder / "scans.mcap"
    writer = McapFileWriter(path, lambda name: STORE.generate_msgdef(name)[0])
    angles = np.linspace(-math.pi, math.pi, BEAMS, endpoint=False)
    for at in range(HOUR_S * SCANS_HZ):
        time_us = start_us + at * (SECOND_US // SCANS_HZ)
        header = _header(time_us, "base_link")
        ranges = (4 + 0.5 * np.sin(6 * angles + at / SCANS_HZ)).astype(np.float32)
        scan = STORE.types[SCAN](
            header, float(angles[0]), float(angles[-1]), float(angles[1] - angles[0]), 0.0, 0.0,
            0.1, 30.0, ranges, np.zeros(0, np.float32),
        )  # fmt: skip
        for topic, kind, message in (
            ("/bench/scan", SCAN, scan), ("/bench/tf", TRANSFORMS, _transform(time_us, at)),
        ):  # fmt: skip
            data = bytes(STORE.serialize_cdr(message, kind))
            writer.add_message(RawMessage(topic, kind, time_us * 1000, time_us * 1000, data))
    writer.finish_file()
    span = start_us, start_us + HOUR_S * SECOND_US
    _describe(path, span, messages=writer.messages, topics=tuple(writer.topics))


def _header(time_us: int, frame: str) -> Any:  # noqa: ANN401 - rosbags' classes are made
    types = STORE.types
    sec, rest = divmod(time_us, SECOND_US)
    stamp = types["builtin_interfaces/msg/Time"](sec, rest * 1000)
    return types["std_msgs/msg/Header"](stamp, frame)


def _transform(time_us: int, at: int) -> Any:  # noqa: ANN401 - see above
    types = STORE.types
    place = types["geometry_msgs/msg/Transform"](
        types["geometry_msgs/msg/Vector3"](math.sin(at / 100), math.cos(at / 100), 0.0),
        types["geometry_msgs/msg/Quaternion"](0.0, 0.0, 0.0, 1.0),
    )
    stamped = types["geometry_msgs/msg/TransformStamped"]
    return types[TRANSFORMS]([stamped(_header(time_us, "odom"), "base_link", place)])


def _describe(
    path: Path,
    span: tuple[int, int],
    *,
    messages: int,
    topics: tuple[str, ...] = (),
    stream: str = "",
) -> None:
    """Put beside a file what its gateway would have said of it."""
    size = path.stat().st_size
    told = Recorded(
        site="bench", id=path.stem, state=RecordingState.COMPLETE, why="bench", who="", note="",
        begin_us=span[0], end_us=span[1], size=size, have=size, messages=messages, digest="",
        topics=topics, stream=stream,
    )  # fmt: skip
    path.with_suffix(".json").write_text(json.dumps({**told._asdict(), "state": told.state.value}))


def board_of_past() -> dict[str, Any]:
    """Arrange 50 signals, the camera and the scene, all on one screen."""
    tiles: list[dict[str, Any]] = []
    signal = 0
    for kind, signals, count in TILES:
        for _ in range(count):
            names = [f"base/s{signal + number}" for number in range(signals)]
            signal += signals
            settings = {"signal": names[0]} if signals == 1 else {"signals": names}
            tiles.append({"type": kind, "settings": settings})
    assert signal == SIGNALS
    tiles.append({"type": "camera", "settings": {"stream": "base/front"}})
    tiles.append({"type": "scene", "settings": {}})
    sizes = {"value": (2, 2), "chart": (4, 3), "gauge": (3, 3), "table": (6, 5),
             "camera": (6, 6), "scene": (6, 6)}  # fmt: skip
    x = y = 0
    before = ""
    for number, tile in enumerate(tiles):
        wide, high = sizes[tile["type"]]
        if before and (x + wide > 12 or (before != tile["type"] and sizes[before][1] != high)):
            x, y = 0, y + sizes[before][1]
        place = {"x": x, "y": y, "w": wide, "h": high}
        tile |= {"id": f"t{number}", "title": "", "desktop": place, "phone": None}
        x, before = x + wide, tile["type"]
    return {"name": "Past", "note": "", "site": "bench", "kind": "", "device": "", "tiles": tiles}


async def open_past(page: Page, here: Stack, start_us: int) -> None:
    """Open the board in the middle of the hour, and wait until all of it is there."""
    key = await boards.keep_board(here, board_of_past())
    middle = dt.datetime.fromtimestamp(start_us / 1e6 + HOUR_S / 2, dt.UTC)
    await pages.sign_in(page, here, "/boards")
    await page.goto(f"{here.origin}/boards/{key}?at={middle:%Y-%m-%dT%H:%M:%SZ}")
    await page.locator("t-chart canvas").first.wait_for()
    await page.locator("t-scene canvas").wait_for()
    await page.locator("t-film-view video").wait_for()
    charts = sum(signals * count for kind, signals, count in TILES if kind == "chart")
    await page.evaluate(f"Object.assign(window.__past, {{beginUs: {start_us}, all: {charts}}})")
    await asyncio.sleep(2)


async def scrub(page: Page, start_us: int, times: int, *, drag: bool) -> list[dict[str, float]]:
    """Jump to moments of the hour; ms until each part shows it, and until all do.

    Args:
        page: has the board open.
        start_us: of the hour.
        times: so many moments.
        drag: a hand goes there over ten others, 30 ms each.

    """
    chance = random.Random(2 if drag else 1)  # noqa: S311 - of a benchmark
    found = []
    for _ in range(times):
        at_us = start_us + chance.randrange(400, HOUR_S - 100) * SECOND_US + 50_000
        if drag:
            for step in range(10, 0, -1):
                await page.evaluate(f"window.__past.seek({at_us - step * 20 * SECOND_US})")
                await asyncio.sleep(0.03)
        await page.evaluate(f"window.__past.seek({at_us})")
        await pages.until_true(page, "window.__past.took.all > 0")
        found.append(await page.evaluate("window.__past.took"))
        await asyncio.sleep(0.5)
    return found


async def play(page: Page, start_us: int, seconds: float) -> Played:
    """Play at ten times, after it has begun."""
    await page.evaluate(f"window.__past.seek({start_us + 600 * SECOND_US + 50_000})")
    await pages.until_true(page, "window.__past.took.all > 0")
    await page.evaluate(f"window.__past.play({SPEED})")
    await asyncio.sleep(2)
    await page.evaluate("window.__past.ticks = []")
    began = time.monotonic()
    await asyncio.sleep(seconds)
    ticks = np.array(await page.evaluate("window.__past.ticks"), float)
    took = time.monotonic() - began
    assert len(ticks) > 2, took
    ms, us, scan = ticks.T
    return Played(
        float((us[-1] - us[0]) / 1000 / (ms[-1] - ms[0])), np.diff(ms), _stood(ms, us),
        _stood(ms, scan),
    )  # fmt: skip


def _stood(ms: np.ndarray, shown: np.ndarray) -> np.ndarray:
    """Give how long each thing that was shown stayed (ms)."""
    changed = ms[1:][np.diff(shown) != 0]
    return np.diff(np.concatenate([ms[:1], changed, ms[-1:]]))
