"""A hub that really serves, a gateway and pages that really connect: all in one event loop."""

# ruff: noqa: D107
from __future__ import annotations

import asyncio
import gc
import re
import shutil
import socket
from contextlib import AsyncExitStack, asynccontextmanager
from dataclasses import replace
from pathlib import Path
from urllib.parse import quote

import fastapi.dependencies.models
import httpx
import numpy as np
import pytest
import pytest_asyncio
import websockets
from patience import PATIENCE_S
from shared_trust import usual_trust

from talaia.clock import SystemClock
from talaia.hub.app import build_hub
from talaia.hub.auth.passwords import Passwords
from talaia.hub.history.queries.series import Series
from talaia.hub.run import server_of
from talaia.hub.settings import Settings
from talaia.hub.store.accounts.people import People
from talaia.hub.store.sites.site_registry import add_key
from talaia.model.yaml_text.load import load_site
from talaia.wire.browser import (
    FROM_BROWSER,
    MEDIA_FROM_BROWSER,
    MEDIA_TO_BROWSER,
    TO_BROWSER,
    TOPIC_FROM_BROWSER,
    TOPIC_TO_BROWSER,
)
from talaia.wire.columns import Columns, pack_columns
from talaia.wire.frames import (
    LINK_FROM_GATEWAY,
    LINK_FROM_HUB,
    MEDIA_FROM_GATEWAY,
    MEDIA_FROM_HUB,
    Beat,
    BeatReply,
    Hello,
    SampleBatch,
    Welcome,
)
from talaia.wire.gateway_proof import (
    KeyProof,
    ResumeToken,
    cover_key,
    proof_words,
    read_challenge,
    resume_answer,
)

from .chromium import (  # noqa: F401 - fixtures of every test of the hub
    PASSWORD,
    _browser,
    _function_scoped_runner,
    chromium,
    space,
)
from .databases import (  # noqa: F401 - fixtures of every test of the hub
    database,
    database_url,
    origin_of,
)
from .everyone.world import World
from .kept_routes import _routes_are_read_once  # noqa: F401 - a fixture of every test of the hub
from .kept_statements import (  # noqa: F401 - a fixture of every test of the hub
    _statements_are_written_once,
)
from .mailbox import mailbox  # noqa: F401 - a fixture of tests of messages

EXAMPLE = (Path(__file__).parents[2] / "examples" / "agv" / "site.yaml").read_text()
# Less what watches it, and what is shown of raw topics: each test says for itself what is.
DESCRIPTION = re.sub(
    r"\n +anomalies:(\n +- .*)+|\ntopics:(\n +- .*)+",
    "",
    EXAMPLE.partition("\nalarms:\n")[0],
)


class MemoryHistory:
    """The promise of `talaia.hub.ports.History`, kept in memory."""

    cached_bytes = 0
    trouble = ""

    def __init__(self) -> None:
        self.samples = {}
        self.appended = asyncio.Event()
        self.gaps = []
        self.gate = asyncio.Event()
        self.gate.set()

    async def open(self) -> None: ...

    async def close(self) -> None: ...

    async def describe_site(self, site) -> None: ...

    async def rename_channels(self, site, moves) -> None:
        for (where, _), stored in self.samples.items():
            for number, row in stored.items():
                if where == site and row and row[0] in moves:
                    stored[number] = (moves[row[0]], *row[1:])

    async def append_samples(self, site, boot, first, *, addresses, columns) -> None:
        await self.gate.wait()
        for at in range(len(columns)):
            address = addresses[columns.channel[at]]
            row = (int(columns.time_us[at]), float(columns.value[at]), columns.texts.get(at, ""))
            self.samples.setdefault((site, boot), {})[first + at] = (address, *row)
        self.appended.set()

    async def record_gap(self, site, boot, first, last, *, from_us, to_us, reason) -> None:
        self.gaps.append((site, boot, first, last, reason))
        for number in range(first, last + 1):
            self.samples.setdefault((site, boot), {})[number] = None

    async def stored_below(self, site, boot) -> int:
        stored, below = self.samples.get((site, boot), {}), 0
        while below in stored:
            below += 1
        return below

    def has_channel(self, site, address) -> bool:
        return any(
            where == site and row and row[0] == address
            for (where, _), stored in self.samples.items()
            for row in stored.values()
        )

    def kind_of(self, site, address) -> None: ...

    async def read_series(
        self, site, addresses, from_us, to_us, *, width, steps=()
    ) -> list[Series]:
        return [self._series(site, address, from_us, to_us) for address in addresses]

    async def last_readings(
        self, site, addresses, to_us=2**62
    ) -> dict[str, tuple[int, float, str]]:
        found = {}
        for (where, _), stored in self.samples.items():
            for row in stored.values():
                if where == site and row is not None and row[0] in addresses and row[1] <= to_us:
                    found[row[0]] = row[1:]
        return found

    def _series(self, site, address, from_us, to_us) -> Series:
        rows = [
            row
            for (where, _), stored in self.samples.items()
            for row in stored.values()
            if where == site and row and row[0] == address and from_us <= row[1] < to_us
        ]
        return Series(
            address,
            np.array([row[1] for row in rows], np.int64),
            np.array([row[2] for row in rows], np.float64),
            {at: row[3] for at, row in enumerate(rows) if row[3]},
            exact=True,
            gaps=[],
        )


class Peer:
    """The other end of a socket: says messages, and waits for the one it wants to hear."""

    def __init__(self, connection, speaks, hears, *, text: bool = False) -> None:
        self.connection = connection
        self.heard = []
        self.close_code = None
        self._speaks, self._hears, self._text = speaks, hears, text
        self._news = asyncio.Condition()
        self._reading = asyncio.create_task(self._read())

    async def say(self, message) -> None:
        encode = self._speaks.encode_text if self._text else self._speaks.encode
        await self.connection.send(encode(message))

    async def hear(self, kind, where=lambda message: True):
        """Wait for a message, of those heard already or still to come; it is taken out."""
        async with asyncio.timeout(PATIENCE_S), self._news:
            while True:
                for message in self.heard:
                    if isinstance(message, kind) and where(message):
                        self.heard.remove(message)
                        return message
                if self.close_code is not None:
                    raise AssertionError(f"closed ({self.close_code}) before {kind}")
                await self._news.wait()

    async def closed(self) -> int:
        """Wait until the other side has closed; give the close code."""
        async with asyncio.timeout(PATIENCE_S), self._news:
            await self._news.wait_for(lambda: self.close_code is not None)
        return self.close_code

    async def close(self) -> None:
        await self.connection.close()
        await self._reading

    async def _read(self) -> None:
        try:
            async for frame in self.connection:
                await self.take(self._hears.decode(frame))
        except websockets.ConnectionClosed:
            pass
        async with self._news:
            self.close_code = self.connection.close_code
            self._news.notify_all()

    async def take(self, message) -> None:
        async with self._news:
            self.heard.append(message)
            self._news.notify_all()


class Gateway(Peer):
    """A scripted gateway: answers beats by itself, says the rest when told to."""

    boot = "boot-1"
    sequence = 0
    # What it was told to be stored; -1: it does not say.
    acked = -1
    description = DESCRIPTION

    async def take(self, message) -> None:
        if isinstance(message, Beat):
            reply = BeatReply(n=message.n, mono_us=message.mono_us, peer_us=message.mono_us + 5_000)
            await self.say(reply)
        await super().take(message)

    async def hello(self, description=DESCRIPTION, *, boot="boot-1", site="agv") -> Welcome:
        self.boot = boot
        self.channels = {
            channel.address: at for at, channel in enumerate(load_site(DESCRIPTION).channels())
        }
        await self.say(self.hello_message(description, boot=boot, site=site))
        return await self.hear(Welcome)

    def hello_message(self, description=DESCRIPTION, *, boot="boot-1", site="agv") -> Hello:
        said = {"site": site, "boot": boot, "description": description, "catalogue": "c1"}
        return Hello(**said, acked=self.acked)

    async def samples(self, *rows, live=True, first=None) -> None:
        """Send rows of address, time (µs), value or text."""
        first = self.sequence if first is None else first
        texts = {at: row[2] for at, row in enumerate(rows) if isinstance(row[2], str)}
        packed = pack_columns(
            Columns(
                np.array([self.channels[row[0]] for row in rows], np.uint16),
                np.array([row[1] for row in rows], np.int64),
                np.array([np.nan if isinstance(row[2], str) else row[2] for row in rows]),
                texts,
            )
        )
        self.sequence = max(self.sequence, first + len(rows))
        await self.say(
            SampleBatch(
                boot=self.boot,
                first=first,
                catalogue="c1",
                live=live,
                **packed._asdict(),
            )
        )


class RunningHub:
    """A hub on a free port of loopback, with one person for each role."""

    # Of one that comes back to where it was; 0 takes any.
    bind_port = 0
    # The gateway of a fixture that has linked one.
    linked: Gateway | None = None

    def __init__(self, settings: Settings, history: MemoryHistory, *, seat=None) -> None:
        self.settings = settings
        self.history = history
        self.hub = build_hub(settings, SystemClock(), history, seat=seat)
        self.people = People(self.hub.core.database, SystemClock())
        self.keys = {}
        self._stack = AsyncExitStack()
        self._cookies = {}

    async def __aenter__(self) -> RunningHub:
        self._listener = socket.create_server(("127.0.0.1", self.bind_port))
        # asyncio forgets this for such a socket, and then each answer takes 40 ms; uvloop does not.
        self._listener.setsockopt(socket.IPPROTO_TCP, socket.TCP_NODELAY, 1)
        self.port = self._listener.getsockname()[1]
        self.origin = f"http://127.0.0.1:{self.port}"
        ready = asyncio.Event()
        self._server = server_of(self.hub, ready.set)
        self._serving = asyncio.create_task(self._server.serve(sockets=[self._listener]))
        waiting = asyncio.create_task(ready.wait())
        await asyncio.wait({self._serving, waiting}, return_when=asyncio.FIRST_COMPLETED)
        waiting.cancel()
        assert ready.is_set()
        return self

    async def __aexit__(self, *_exc: object) -> None:
        await self._stack.aclose()
        self._server.should_exit = True
        await self._serving
        self._listener.close()
        _forget_routes()

    async def populate(self) -> None:
        hashed = await Passwords(4).hash_password(PASSWORD)
        # In one transaction: each waits for the disk.
        async with self.hub.core.database.write() as connection:
            for role in ("guest", "operator", "admin"):
                await self.people._insert_person(connection, role, hashed, role)
            now_us = SystemClock().wall_ns() // 1000
            _, self.keys["agv"], _ = await add_key(connection, "agv", "", now_us)

    async def client(self, name: str = "") -> httpx.AsyncClient:
        """Open an HTTP client, signed in as ``name`` unless it is empty."""
        client = httpx.AsyncClient(
            base_url=self.origin,
            headers={"Origin": self.origin},
            timeout=PATIENCE_S,
            verify=usual_trust(),
        )
        await self._stack.enter_async_context(client)
        if name:
            answer = await client.post("/api/login", json={"name": name, "password": PASSWORD})
            assert answer.status_code == 200, answer.text
            self._cookies[name] = answer.cookies["talaia"]
        return client

    async def cookie(self, name: str) -> str:
        if name not in self._cookies:
            await self.client(name)
        return f"talaia={self._cookies[name]}"

    async def page(self, name: str = "operator", *, text: bool = False) -> Peer:
        """Open a page's socket."""
        connection = await self.dial(
            "/ws" + ("?form=json" if text else ""),
            {"Cookie": await self.cookie(name), "Origin": self.origin},
        )
        return self.peer(connection, text=text)

    def peer(self, connection, *, text: bool = False) -> Peer:
        """Speak as a page over a socket that is open."""
        return self._keep(Peer(connection, FROM_BROWSER, TO_BROWSER, text=text))

    async def viewer(self, name: str, stream: str) -> Peer:
        """Open a page's socket for pictures."""
        connection = await self.dial(
            f"/ws/media?site=agv&stream={stream}",
            {"Cookie": await self.cookie(name), "Origin": self.origin},
        )
        return self._keep(Peer(connection, MEDIA_FROM_BROWSER, MEDIA_TO_BROWSER))

    async def follower(self, name: str, topic: str, more: str = "") -> Peer:
        """Open a page's socket for a raw topic."""
        connection = await self.dial(
            f"/ws/topic?site=agv&topic={quote(topic)}{more}",
            {"Cookie": await self.cookie(name), "Origin": self.origin},
        )
        text = "form=json" in more
        return self._keep(Peer(connection, TOPIC_FROM_BROWSER, TOPIC_TO_BROWSER, text=text))

    async def gateway(self, *, key: str = "", at=None) -> Gateway:
        """Open a gateway's link, here or ``at`` another hub; it has not said hello yet."""
        headers = {"Authorization": f"Bearer {key or self.keys['agv']}"}
        connection = await self.dial("/gateway/link", headers, at=at)
        return self._keep(Gateway(connection, LINK_FROM_GATEWAY, LINK_FROM_HUB))

    async def proof(self, path: str, resume: str = "", *, key: str = "") -> dict[str, str]:
        """Ask for the hub's number, and answer it as a gateway that was handed down ``resume``."""
        key = key or self.keys["agv"]
        with pytest.raises(websockets.InvalidStatus) as asked:
            await self.dial(path, {"Authorization": proof_words(KeyProof("agv"))})
        nonce = read_challenge(asked.value.response.headers["WWW-Authenticate"])
        cover = cover_key(key, nonce=nonce, site="agv", path=path)
        said = KeyProof("agv", nonce, cover)
        if resume:
            lineage, serial, secret = resume.split(".")
            answer = resume_answer(bytes.fromhex(secret), nonce=nonce, site="agv", path=path)
            said = said._replace(place=ResumeToken(int(lineage), int(serial)), resume=answer)
        return {"Authorization": proof_words(said)}

    async def proven_gateway(self, resume: str = "", *, key: str = "") -> Gateway:
        """Open the link of a gateway that proves its key; it has not said hello yet."""
        path = "/gateway/link"
        connection = await self.dial(path, await self.proof(path, resume, key=key))
        return self._keep(Gateway(connection, LINK_FROM_GATEWAY, LINK_FROM_HUB))

    async def camera(self) -> Peer:
        """Open a gateway's media connection."""
        headers = {"Authorization": f"Bearer {self.keys['agv']}"}
        connection = await self.dial("/gateway/media", headers)
        return self._keep(Peer(connection, MEDIA_FROM_GATEWAY, MEDIA_FROM_HUB))

    async def dial(self, path: str, headers: dict[str, str], *, at=None):
        """Open a socket here, or ``at`` another hub before this one."""
        return await websockets.connect(
            f"ws://127.0.0.1:{(at or self).port}{path}",
            additional_headers=headers,
            compression=None,
            max_size=None,
            proxy=None,
            open_timeout=PATIENCE_S,
            # The hub's own word counts: a test that computes, or reads late, is no dead connection.
            ping_interval=None,
        )

    def _keep(self, peer):
        self._stack.push_async_callback(peer.close)
        return peer


def _forget_routes() -> None:
    """Empty what FastAPI remembers of routes: it would hold thousands of them, and their hubs."""
    for each in vars(fastapi.dependencies.models).values():
        if hasattr(each, "cache_clear"):
            each.cache_clear()


@pytest.fixture(scope="session", autouse=True)
def _garbage_is_looked_for_seldom():
    """Spare half of what it takes to start a hub: to go through all modules again and again."""
    often = gc.get_threshold()
    gc.collect()
    gc.freeze()
    gc.set_threshold(50_000, 10, 10)
    yield
    # What is set aside stays so: pytest collects five times at its end, a second of computing.
    gc.set_threshold(*often)


@pytest.fixture
def settings(tmp_path) -> Settings:
    return settings_in(tmp_path)


def settings_in(folder: Path) -> Settings:
    """Give the settings of a hub that keeps its data in a folder, with a database that is ready."""
    shutil.copy(origin_of("sqlite"), folder)
    return Settings(
        data=folder,
        plain=True,
        port=0,
        password_cost=4,
        commit_s=0.0,
        beat_s=0.2,
        # Each time asks the database about each socket: more often is a good part of a busy core.
        check_s=0.4,
        linger_s=0.05,
        # The tests' own people are not asked anew, however slow the machine is.
        confirm_s=86_400.0,
    )


@pytest.fixture
def history() -> MemoryHistory:
    return MemoryHistory()


@pytest.fixture
async def empty_hub(settings, history):
    """A hub that starts for the first time."""
    async with RunningHub(settings, history) as running:
        yield running


@pytest.fixture
async def hub(empty_hub):
    """A hub with a guest, an operator and an admin, and a gateway's key."""
    await empty_hub.populate()
    return empty_hub


@pytest.fixture(scope="module")
def shared_settings(tmp_path_factory) -> Settings:
    return settings_in(tmp_path_factory.mktemp("hub"))


@pytest_asyncio.fixture(scope="module", loop_scope="module")
async def shared_hub(shared_settings):
    """The same for all tests of a file that leave it as it is; they run in the file's loop."""
    async with RunningHub(shared_settings, MemoryHistory()) as running:
        await running.populate()
        yield running


@pytest.fixture
async def gateway(hub):
    """The connected gateway of the example vehicle."""
    gateway = await hub.gateway()
    await gateway.hello()
    return gateway


@pytest_asyncio.fixture(scope="module", loop_scope="module")
async def shared_gateway(shared_hub):
    """The connected gateway of the example vehicle, for all tests of a file that only look."""
    gateway = await shared_hub.gateway()
    await gateway.hello()
    return gateway


@pytest.fixture
def hub_parts(settings, history):
    """A hub that is put together and not started."""
    return build_hub(settings, SystemClock(), history)


@pytest.fixture
def hub_that_stores(settings):
    """Start a hub on one data folder, with the history that it ships with."""
    return lambda: RunningHub(settings, None)


@pytest.fixture
async def world(settings):
    """Two sites online, one person of each kind, nothing that is made up."""
    async with begun(settings) as world:
        yield world


@pytest_asyncio.fixture(scope="module", loop_scope="module")
async def shared_world(shared_settings):
    """The same, for many tests of a file; they run in the file's event loop."""
    async with begun(shared_settings) as world:
        yield world


@asynccontextmanager
async def begun(settings):
    # Its sites have a folder for meshes, empty until a test puts one there.
    assets = settings.assets or settings.data / "assets"
    maps = settings.data / "maps"
    maps.mkdir(parents=True, exist_ok=True)
    (maps / "a.pmtiles").write_bytes(b"PMTiles")
    async with RunningHub(replace(settings, assets=assets, maps=maps), None) as hub:
        world = World(hub)
        try:
            await world.begin()
            yield world
        finally:
            await world.close()
