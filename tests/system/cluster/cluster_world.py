"""One site with three hubs: behind HAProxy, on PostgreSQL, NATS in threes and a bucket.

What `faults.World` says of the site holds here. Long, because what is started stands in one place.
"""

from __future__ import annotations

import asyncio
import contextlib
import json
import os
import signal
import time
from pathlib import Path
from typing import Any

import httpx
import psutil
import sqlalchemy as sa
from aiosmtpd.controller import Controller
from async_program import start_program
from certificates import Certificates
from hub.databases import database_with_tables, empty_database
from hub.object_stores import BUCKET, KEY_ID, SECRET, FaultyLine, require_store
from patience import PATIENCE_S, until_answered
from ports import free_port
from shared_trust import usual_trust

from talaia.clock import SystemClock
from talaia.hub import accounts
from talaia.hub.auth.key_file import read_or_make_key
from talaia.hub.settings import Settings
from talaia.hub.store.database import Database
from talaia.hub.store.history_servers.history_homes import HistoryHomes
from talaia.hub.store.history_servers.shard_handover import word_of
from talaia.hub.store.sites.site_registry import add_key

from ..faults import ledgers
from ..faults.world import World
from ..mail_server import Mailbox
from ..people import sign_in
from ..stack import PASSWORD, PEOPLE, SITE, SOURCE, Process, finish
from .servers import BALANCER, Balancer, Line, NatsNodes, Store, find_program

TESTS = Path(__file__).parents[2]
CRASHING = TESTS / "system" / "faults" / "crashing.py"
NAMES = ("east", "west", "south")
# The shard of all sites that no other one has, and another one.
MAIN, SHARD = "main", "north"
PEOPLE_HERE = {**PEOPLE, "admin": "admin"}
# The lock may be taken as soon as the one before has been silent for 3 s.
TAKE_OVER_S = 30.0


class Member:
    """One of the hubs: its process, and its ways to NATS and to the database."""

    def __init__(self, world: ClusterWorld, name: str) -> None:
        """Prepare it; nothing is started yet."""
        self._world, self.name = world, name
        self.port = free_port()
        self.folder = world.folder / name
        self.folder.mkdir(mode=0o700)
        read_or_make_key(self.folder / "seal.key", world.seal)
        self.bus = Line(world.folder, [node.port for node in world.nats.nodes])
        self.database = Line(world.folder, [world.server_port])
        self.offset_s = 0.0
        self.process: Process | None = None

    @property
    def address(self) -> str:
        return f"http://localhost:{self.port}"

    @property
    def runs(self) -> bool:
        return self.process is not None and self.process.popen.poll() is None

    def times_led(self, shard: str) -> int:
        """How often this run of it began to lead a shard."""
        more = "" if shard == MAIN else f" (shard {shard})"
        said = "" if self.process is None else self.process.said()
        return said.count(f"talaia hub leads: {self.name}{more}\n")

    def start(self) -> Process:
        nats = ",".join(f"nats://127.0.0.1:{port}" for port in self.bus.ports)
        words = ["-m", "talaia", "hub", "--data", str(self.folder), "--plain"]
        words += ["--host", "127.0.0.1", "--port", str(self.port)]
        words += ["--cluster", nats, "--cluster-name", self.name, *self._world.file_words]
        words += ["--proxy-protocol", BALANCER, "--notify-network", "127.0.0.0/8"]
        environment = {"TALAIA_DATABASE_URL": self._world.url_by(self.database)}
        if self.offset_s:
            words = [str(CRASHING), *words[2:]]
            environment["TALAIA_CLOCK_OFFSET_S"] = str(self.offset_s)
        self.process = Process(words, self._world.folder / f"{self.name}.log", environment)
        return self.process

    async def is_ready(self) -> bool:
        try:
            async with httpx.AsyncClient(timeout=5.0, verify=usual_trust()) as client:
                return (await client.get(f"{self.address}/api/ready")).status_code == 200
        except httpx.HTTPError:
            return False

    def signal(self, number: int) -> int:
        """Send a signal; gives the moment just before (monotonic, ns)."""
        assert self.process is not None
        at = time.monotonic_ns()
        self.process.popen.send_signal(number)
        return at

    def kill(self) -> int:
        """Kill -9; gives the moment just before (monotonic, ns)."""
        assert self.process is not None
        return self.process.kill()

    async def leave(self) -> int:
        """Ask it to end, and wait until it has; give its exit code."""
        assert self.process is not None
        self.process.popen.terminate()
        code = await asyncio.to_thread(self.process.popen.wait, PATIENCE_S)
        self.process.end()
        return code

    def close(self) -> None:
        if self.process is not None:
            self.process.end()
        self.bus.close()
        self.database.close()


class ClusterWorld(World):
    """A `World` whose hub is three."""

    one_of_many = SITE

    def __init__(
        self,
        folder: Path,
        gateways: int,
        pages: int,
        browser_pages: int = 0,
        *,
        divided: bool = False,
    ) -> None:
        """Start all of it, with a crowd of so many, and so many pages in a Chromium besides.

        ``divided``: the robot's site and half of the crowd are of a shard of their own.

        Raises:
            PermissionError: one of the servers is not on this machine.

        """
        for program in ("haproxy", "nats-server"):
            find_program(program)
        require_store()
        self.folder = folder
        self.crowd_size = gateways, pages
        self._browser_pages = browser_pages
        # The shard of the robot's site.
        self.shard = SHARD if divided else MAIN
        self.crowd: Process | None = None
        # Without it nobody looks in a Chromium.
        self.browser: Process | None = None
        self._stack = contextlib.ExitStack()
        self._door_places = 0
        self._admin = ""
        self.mailbox = Mailbox()
        try:
            self._start_servers()
            super().__init__(folder)
        except BaseException:
            self._stack.close()
            raise

    def _start_servers(self) -> None:
        folder, keep = self.folder, self._stack.callback
        url = self._stack.enter_context(database_with_tables("postgresql", folder))
        self._url = url
        self.server_port = sa.make_url(url).port or 5432
        self.seal = os.urandom(32)
        self.nats = NatsNodes()
        keep(self.nats.close)
        self.store = Store()
        keep(self.store.close)
        certificates = Certificates(folder)
        self.store_line = self._stack.enter_context(FaultyLine(self.store.port, certificates))
        key = folder / "bucket-key"
        key.write_text(f"{KEY_ID}\n{SECRET}\n")
        self.file_words = [
            "--files", f"s3://{BUCKET}/talaia", "--files-endpoint", self.store_line.url,
            "--files-key-file", str(key), "--files-ca", str(certificates.ca),
        ]  # fmt: skip
        if self.shard != MAIN:
            self.file_words += ["--history-servers", str(self._divide_sites())]
        mail = Controller(self.mailbox, hostname="127.0.0.1", port=free_port())
        mail.start()
        keep(mail.stop)
        self.mail_port = mail.port
        self.members = {name: Member(self, name) for name in NAMES}
        for member in self.members.values():
            keep(member.close)

    def _divide_sites(self) -> Path:
        url = self._stack.enter_context(empty_database("postgresql"))
        file = self.folder / "servers.yaml"
        # JSON is YAML.
        named = {
            "servers": {SHARD: url}, "shards": [SHARD], "default": ["own", SHARD],
            "sites": {SITE: SHARD},
        }  # fmt: skip
        file.write_text(json.dumps(named))
        file.chmod(0o600)
        return file

    def url_by(self, line: Line) -> str:
        """Give the database's URL by a hub's own line."""
        return sa.make_url(self._url).set(port=line.ports[0]).render_as_string(hide_password=False)

    async def _accounts(self) -> None:
        settings = Settings(
            data=self.folder, host="127.0.0.1", port=self.port, plain=True, password_cost=4,
            database_url=self._url,
        )  # fmt: skip
        for name, role in PEOPLE_HERE.items():
            await accounts.create_user(settings, name, PASSWORD, role)
        database = Database(settings.url)
        now_us = SystemClock().wall_ns() // 1000
        async with database.write() as connection:
            _, key, _ = await add_key(connection, SITE, "", now_us)
            (self.folder / "key").write_text(key)
            lines = []
            for number in range(self.crowd_size[0]):
                site = f"crowd{number}"
                lines.append(f"{site} {(await add_key(connection, site, '', now_us))[1]}\n")
        (self.folder / "crowd-keys").write_text("".join(lines))
        await database.close()

    def start_hub(self) -> Process:
        """Start all three, and HAProxy before them."""
        first, *others = self.members.values()
        self.hub = first.start()
        if self.shard == MAIN:
            finish(self.hub.says("talaia hub leads"))
        for member in others:
            member.start()
        ports = {name: member.port for name, member in self.members.items()}
        balancer = Balancer(self.folder, self.port, ports)
        self._stack.callback(balancer.close)
        return self.hub

    async def fresh(self) -> None:
        """Start what a row before has ended, and wait until all are ready and linked."""
        for member in self.members.values():
            if not member.runs:
                member.start()
        for member in self.members.values():
            await until_answered(member.is_ready)
        if self.gateway.popen.poll() is not None or self.links > 1:
            self.gateway.end()
            self.start_gateway()
        await self.robot.says("ready")
        await self.gateway.says("linked to")
        if self.crowd is None:
            await self._gather_crowd()
        assert self.crowd is not None
        spread = self.crowd.said().count("spread\n")
        self.crowd.tell("spread")
        await self.crowd.says("spread\n", times=spread + 1)

    def next_door(self, *, is_open: bool) -> float:
        """Give a place of the door that messages, with their four digits, tell apart."""
        self._door_places += 1
        return round(10 * is_open + self._door_places / 100, 2)

    async def _gather_crowd(self) -> None:
        """Let the crowd come, and somebody be told of alarms by mail."""
        cookie = await self.cookie()
        (self.folder / "crowd-cookie").write_text(cookie)
        way = {
            "name": "Mail", "kind": "mail", "host": "127.0.0.1", "port": self.mail_port,
            "security": "none", "sender": "talaia@example.org",
        }  # fmt: skip
        made = await self.post("/api/ways", way, await self.admin())
        rule = {"site": SITE, "way": made["id"], "target": "on-call@example.org", "group_s": 0}
        await self.post("/api/me/rules", rule, cookie)
        words = ["-m", "system.cluster.crowd", str(self.port), str(self.folder / "crowd-keys")]
        words += [str(self.folder / "crowd-cookie"), str(self.crowd_size[1])]
        paths = os.pathsep.join((str(SOURCE), str(TESTS)))
        self.crowd = Process(words, self.folder / "crowd.log", {"PYTHONPATH": paths})
        if self._browser_pages:
            # Each of another gateway, so that they come in at whichever hub.
            sites = [f"crowd{number}" for number in range(self._browser_pages)]
            words = ["-m", "system.cluster.browser_pages", str(self.port)]
            words += [str(self.folder / "crowd-cookie"), *sites]
            self.browser = Process(words, self.folder / "browser.log", {"PYTHONPATH": paths})
            await self.browser.says("open\n")

    def tell_onlookers(self, word: str) -> None:
        """Tell the crowd, and who looks in a Chromium."""
        for process in (self.crowd, self.browser):
            if process is not None:
                process.tell(word)

    async def post(self, path: str, asked: dict[str, Any], cookie: str) -> dict[str, Any]:
        """Ask for something as somebody, through HAProxy."""
        headers = {"Cookie": cookie, "Origin": self.address}
        async with self.client() as client:
            answer = await client.post(path, json=asked, headers=headers)
        assert answer.is_success, answer.text
        return dict(answer.json())

    def client(self) -> httpx.AsyncClient:
        return httpx.AsyncClient(
            base_url=self.address, timeout=ledgers.BACK_S, verify=usual_trust()
        )

    async def ask(self, path: str, cookie: str, **query: object) -> dict[str, Any]:
        """Ask as somebody does who asks again when a hub breaks off, or none leads."""
        found: list[dict[str, Any]] = []

        async def has_answered() -> bool:
            with contextlib.suppress(httpx.TransportError):
                async with self.client() as client:
                    answer = await client.get(path, params=query, headers={"Cookie": cookie})
                if answer.status_code != httpx.codes.SERVICE_UNAVAILABLE:
                    assert answer.is_success, answer.text
                    found.append(answer.json())
            return bool(found)

        await until_answered(has_answered)
        return found[0]

    async def admin(self) -> str:
        """Sign the admin in, once."""
        self._admin = self._admin or await sign_in(self, "admin")
        return self._admin

    async def hubs(self) -> list[dict[str, Any]]:
        """Ask how the hubs stand."""
        return list((await self.ask("/api/hubs", await self.admin()))["hubs"])

    async def lead(self, shard: str = "") -> Member:
        """Give the hub that leads a shard; none named: that of the robot's site."""
        found: list[Member] = []

        async def is_led() -> bool:
            for hub in await self.hubs():
                leads = hub["role"] == "leads"
                if leads and (self.shard == MAIN or (shard or self.shard) in hub["shards"]):
                    found.append(self.members[hub["name"]])
            return bool(found)

        await until_answered(is_led)
        return found[0]

    async def move_site(self, server: str) -> None:
        """Move the robot's site to another server, as an operator does who waits for it."""
        member = self.members[NAMES[0]]
        command = await start_program(
            *("-m", "talaia", "history", "move", SITE, "--to", server),
            *("--data", str(member.folder), "--history-servers", str(self.folder / "servers.yaml")),
            TALAIA_DATABASE_URL=self._url,
        )
        await asyncio.wait_for(command.communicate(), PATIENCE_S)
        assert command.returncode == 0

    async def site_held(self) -> None:
        """Wait for the moment in which nothing of the robot's site is written."""
        database = Database(self._url)
        homes = HistoryHomes(database)
        async with asyncio.timeout(PATIENCE_S):
            while word_of(home.hold if (home := await homes.find_home(SITE)) else "") != "held":
                pass
        await database.close()

    async def others(self) -> list[Member]:
        """Give the hubs that wait, the one first to which most gateways came."""
        told = sorted(await self.hubs(), key=lambda hub: -hub["gateways"])
        return [self.members[hub["name"]] for hub in told if hub["role"] == "waits"]

    async def ready_at(self, member: Member) -> None:
        """Wait until HAProxy would send somebody to a hub."""
        await until_answered(member.is_ready)

    def times_led(self, shard: str) -> dict[str, int]:
        """How often each hub began to lead a shard, since it was started last."""
        return {name: member.times_led(shard) for name, member in self.members.items()}

    async def another_leads(self, before: Member, counts: dict[str, int], shard: str) -> None:
        """Wait until another hub than the one of before has begun to lead since `times_led`."""
        began = time.monotonic()
        while not any(
            member is not before and member.times_led(shard) > counts[name]
            for name, member in self.members.items()
        ):
            assert time.monotonic() - began < TAKE_OVER_S, "no other hub leads"
            await asyncio.sleep(0.02)

    def memory(self) -> dict[str, float]:
        """Give the resident memory of all hubs together, and of the gateway (MiB)."""
        hubs = [member.process for member in self.members.values() if member.process]
        found = {"hubs": hubs, "gateway": [self.gateway]}
        return {
            name: sum(psutil.Process(part.popen.pid).memory_info().rss for part in parts) / 2**20
            for name, parts in found.items()
            if all(part.popen.poll() is None for part in parts)
        }

    def close(self) -> None:
        for process in (self.browser, self.crowd):
            if process is not None:
                process.end()
        super().close()
        self._stack.close()


def freeze(member: Member) -> int:
    """Let a hub stand still; gives the moment just before (monotonic, ns)."""
    return member.signal(signal.SIGSTOP)


def wake(member: Member) -> None:
    """Let it go on."""
    member.signal(signal.SIGCONT)
