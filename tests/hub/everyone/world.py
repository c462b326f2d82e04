"""The world in which every right is tried: two sites, and one person of each kind.

What each of them holds is written down here by hand, since the code under test computes it.
"""

from __future__ import annotations

import hashlib
import itertools
import sqlite3
import time
from contextlib import AsyncExitStack
from typing import TYPE_CHECKING

import httpx
from patience import PATIENCE_S
from sqlalchemy import insert, select

from talaia.hub.store.sites.sightings import Sighted, SightingsAsked
from talaia.hub.store.tables import metadata, permissions, role_permissions, roles
from talaia.model.yaml_text.load import load_site
from talaia.wire.frames import ArchiveOffer

from ..another_hub import AnotherHub

if TYPE_CHECKING:
    from collections.abc import Mapping

PASSWORD = "a password for tests"  # noqa: S105
NOW = 1_700_000_000_000_000

_DEVICE = """
  {device}:
    name: {name}
    visibility: {visibility}
    signals:
      open:
        name: Open
        visibility: {visibility}
        anomalies: [{{detector: limits, maximum: 0}}]
        source: {{topic: /a, type: std_msgs/msg/Float64, field: data}}
      shut:
        name: Shut
        anomalies: [{{detector: limits, maximum: 0}}]
        source: {{topic: /b, type: std_msgs/msg/Float64, field: data}}
      words:
        name: Words
        type: text
        source: {{topic: /c, type: std_msgs/msg/String, field: data}}
    streams:
      eye:
        name: Eye
        detect: {{}}
        blur: {{}}
        source: {{topic: /i, type: sensor_msgs/msg/Image}}
    commands:
      turn: {{name: Turn, target: /turn, type: std_srvs/srv/Trigger}}
    drive: {{topic: /v, max_speed: 1, max_turn: 1}}
"""


def _site(site: str, **devices: str) -> str:
    written = "".join(
        _DEVICE.format(device=device, name=device.title(), visibility=visibility)
        for device, visibility in devices.items()
    )
    first = next(iter(devices))
    alarms = "".join(
        f"  odd_{device}: {{name: Odd, kind: state, signal: {device}/words, max_age: 9999,"
        f" is: [hidden-{site}-{device}], advice: hidden-{site}-{device}}}\n"
        for device in devices
    )
    lock = f"{{name: Lock, when: [{{signal: {first}/shut, above: 5}}], refuse: [{first}/turn]"
    return (
        f"talaia: 1\nsite: {site}\nname: {site.title()}\nros2: {{}}\ndevices:{written}"
        f"interlocks:\n  lock: {lock}, longest_override: 60}}\n"
        "recording: {}\n"
        f"alarms:\n{alarms}"
    )


DESCRIPTIONS = {
    "agv": _site("agv", base="public", power="view", camera="view"),
    "moon": _site("moon", rover="view"),
}

# Everyone, in the order of the columns below: what they hold at most on each object. Each level
# includes those before it; an empty one holds nothing there, not even that it exists.
LEVELS = ("", "see", "view", "use", "admin")
OBJECTS = ("agv", "agv/base", "agv/power", "agv/camera", "moon", "moon/rover", "")
SESSIONLESS = ("nobody", "revoked")
HOLDS: Mapping[str, tuple[str, ...]] = {
    #             agv      base     power    camera   moon     rover    the hub
    "nobody": ("", "", "", "", "", "", ""),
    "revoked": ("", "", "", "", "", "", ""),
    "guest": ("see", "see", "", "", "", "", ""),
    "operator": ("use", "use", "use", "use", "use", "use", "use"),
    "driver": ("see", "use", "", "", "", "", ""),
    "neighbour": ("see", "see", "admin", "", "", "", ""),
    "keeper": ("admin", "admin", "admin", "admin", "", "", ""),
    "admin": ("admin", "admin", "admin", "admin", "admin", "admin", "admin"),
    # A script of the operator's, with a token that may look at one device.
    "token": ("see", "view", "", "", "", "", ""),
}
ACTORS = tuple(HOLDS)
SIGNED_IN = tuple(actor for actor in ACTORS if actor not in SESSIONLESS)
# The roles that are not seeded, each with its one permission: right, site, device.
ROLES = {
    "driver": ("use", "agv", "base"),
    # Admin of one device, whom docs/security.md promises little.
    "neighbour": ("admin", "agv", "power"),
    "keeper": ("admin", "agv", "*"),
}


def holds(actor: str, level: str, about: str) -> bool:
    """Tell whether somebody holds at least a level on an object."""
    return LEVELS.index(HOLDS[actor][OBJECTS.index(about)]) >= LEVELS.index(level)


# The cameras of which there is a picture in the archive.
PICTURED = ("agv/camera", "moon/rover")
TOKEN = {
    "name": "a script",
    "ends_us": round((time.time() + 3600) * 1e6),
    "permissions": [{"right": "view", "site": "agv", "device": "base"}],
}


class World:
    """A running hub with both sites online, and a way for each person to ask it."""

    def __init__(self, hub) -> None:
        """Take a hub that runs and is empty yet."""
        self.hub = hub
        self.gateways = {}
        self.token = ""
        # The proposal of each site to which requests are made; see `observing.kept_proposal`.
        self.proposals: dict[str, str] = {}
        # The test of a detector on the past, of each site; see `routes`.
        self.back_tests: dict[str, str] = {}
        self._made = 0
        self._kept_clients: dict[str, httpx.AsyncClient] = {}
        # Read past the hub: the matrix does it twice for each request.
        self._reader = sqlite3.connect(f"file:{hub.settings.data}/talaia.db?mode=ro", uri=True)
        self._read: tuple[int, dict[str, list]] = (-1, {})
        # One for all clients: making each its own takes longer than asking.
        self._transport = httpx.AsyncHTTPTransport()
        self._stack = AsyncExitStack()

    async def close(self) -> None:
        self._reader.close()
        await self._transport.aclose()
        await self._stack.aclose()

    @property
    def doors(self) -> itertools.cycle:
        """The hubs that somebody comes to by turns: the one that leads, and another before it."""
        return self._doors

    @property
    def home(self):
        """The hub that clients come to unless it is said otherwise."""
        return self.hub

    def hub_of(self, site: str):
        """Give the hub that has a site."""
        return self.hub.hub

    async def open_doors(self) -> None:
        """Open what somebody comes to."""
        self.another = await self._stack.enter_async_context(AnotherHub(self.hub.hub))
        self._doors = itertools.cycle([self.hub, self.another])

    async def begin(self) -> None:
        await self.open_doors()
        await self.hub.populate()
        database = self.hub.hub.core.database
        async with database.write() as connection:
            for name, (right, site, device) in ROLES.items():
                role = await connection.execute(insert(roles).values(name=name, seeded=False))
                permission = await connection.execute(
                    insert(permissions).values(right_name=right, site=site, device=device)
                )
                await connection.execute(
                    insert(role_permissions).values(
                        role_id=role.inserted_primary_key[0],
                        permission_id=permission.inserted_primary_key[0],
                    )
                )
        kept = (await self.hub.people.find_by_name("admin")).password_hash
        for name in ROLES:
            await self.hub.people.add_person(name, kept, name)
        for site in DESCRIPTIONS:
            await self.connect(site)
        # Made behind a gateway's hello: what is written then is the doing of no request.
        for site in DESCRIPTIONS:
            await self.hub_of(site).history.store.wait_for_views()
        ends_us = self.hub.hub.core.clock.wall_ns() // 1000 + 3600 * 10**6
        asked = {**TOKEN, "ends_us": ends_us}
        made = await (await self.client("operator")).post("/api/me/tokens", json=asked)
        assert made.status_code == 200, made.text
        self.token = made.json()["token"]

    async def connect(self, site: str, description: str = ""):
        """Connect a site's gateway, with the key it has or a new one."""
        described = description or DESCRIPTIONS[site]
        if site in self.gateways:
            # While it is there no other takes its place.
            await self.gateways[site].close()
        if site not in self.hub.keys:
            self.hub.keys[site] = await self.hub.hub.gateways.registry.new_key(site)
        gateway = await self.link(site)
        await gateway.hello(described, site=site, boot=f"boot-{len(described)}")
        gateway.channels = {
            channel.address: at for at, channel in enumerate(load_site(described).channels())
        }
        self.gateways[site] = gateway
        return gateway

    async def link(self, site: str):
        """Open the link of a site's gateway."""
        return await self.hub.gateway(key=self.hub.keys[site])

    async def client(self, actor: str) -> httpx.AsyncClient:
        """Open a client of its own for somebody, with a session of its own."""
        client = httpx.AsyncClient(
            base_url=self.home.origin,
            headers={"Origin": self.home.origin},
            transport=self._transport,
            trust_env=False,
            timeout=PATIENCE_S,
        )
        if actor == "nobody":
            return client
        if actor == "token":
            # A script is no page and has no origin.
            del client.headers["Origin"]
            client.headers["Authorization"] = f"Bearer {self.token}"
            return client
        # Signing in is tried elsewhere, and takes longer than all that is asked here.
        client.cookies.update(await self.cookies("operator" if actor == "revoked" else actor))
        if actor == "revoked":
            token = client.cookies["talaia"]
            assert (await client.post("/api/logout")).status_code == 204
            client.cookies.set("talaia", token)
        return client

    async def kept_client(self, actor: str) -> httpx.AsyncClient:
        """Give the client that somebody has had since `forget_clients`: a session takes time."""
        if actor not in self._kept_clients:
            self._kept_clients[actor] = await self.client(actor)
        return self._kept_clients[actor]

    def forget_clients(self) -> None:
        """Let everyone begin a new session: the old one may have ended."""
        self._kept_clients.clear()

    async def admin(self) -> httpx.AsyncClient:
        """Give the admin's client, to prepare things with; see `forget_clients`."""
        return await self.kept_client("admin")

    async def cookies(self, actor: str) -> dict[str, str]:
        """Begin a session without asking for the password: sign-ins are slow, and throttled."""
        if actor == "nobody":
            return {}
        person = await self.hub.people.find_by_name(actor)
        token, _ = await self.hub.hub.people.sessions.start_session(person.id, "127.0.0.1")
        return {"talaia": token}

    async def headers(self, actor: str) -> dict[str, str]:
        """Give what somebody opens a socket with."""
        if actor == "token":
            return {"Authorization": f"Bearer {self.token}", "Origin": self.hub.origin}
        return {"Cookie": await self.hub.cookie(actor), "Origin": self.hub.origin}

    async def page(self, actor: str, *, at=None):
        """Open a page's socket, ``at`` the hub that leads or at the other one."""
        headers = await self.headers(actor)
        if at is not None:
            headers["Origin"] = at.origin
        return self.hub.peer(await self.hub.dial("/ws", headers, at=at))

    async def person(self) -> str:
        """Add somebody new; give the number."""
        self._made += 1
        kept = (await self.hub.people.find_by_name("admin")).password_hash
        return str(await self.hub.people.add_person(f"person {self._made}", kept, "guest"))

    async def picture(self, about: str) -> str:
        """Put a picture of a camera into the archive, unless it is there; give its number."""
        site, _, device = about.partition("/")
        card = "{:<8}= {:>20}".format
        cards = [card("SIMPLE", "T"), card("BITPIX", 8), card("NAXIS", 2), card("NAXIS1", 4)]
        cards += [card("NAXIS2", 4), "END"]
        data = "".join(each.ljust(80) for each in cards).ljust(2880).encode() + bytes(2880)
        path = self.hub.settings.data / "picture.part"
        path.write_bytes(data)
        digest = hashlib.sha256(data).hexdigest()
        offer = ArchiveOffer(
            id="0" * 32, kind="fits", device=device, size=len(data), digest=digest,
            time_us=NOW,
        )  # fmt: skip
        frames = self.hub_of(site).archive.frames
        return str((await frames.archive_file(site, "UTC", offer, path)).id)

    async def sighting(self, about: str) -> str:
        """Have a camera see somebody, unless it has; give the sighting's number."""
        site, _, device = about.partition("/")
        store = self.hub.hub.sightings.store
        picture = b"\xff\xd8not looked at\xff\xd9"
        one = Sighted(site, f"{device}/eye", "person", NOW, NOW + 1, 1, 0.9, NOW, "b", "", picture)
        await store.save_sightings([one], lambda _: None)
        found, _ = await store.find_sightings(site, SightingsAsked(cameras=[one.camera]), 1)
        return str(found[0].id)

    async def viewer(self, actor: str, about: str, stream: str):
        """Look at a stream of a device, as a page does."""
        site, _, device = about.partition("/")
        assert site == "agv"
        return await self.hub.viewer(actor, f"{device}/{stream}")

    async def state(self) -> dict[str, list]:
        """Read all that is kept, but what merely says when something was used."""
        # When and from where gateways came is written a second later; now, then.
        await self.hub.hub.gateways.registry.attendance.write_pending()
        (version,) = self._reader.execute("PRAGMA data_version").fetchone()
        if version != self._read[0]:
            # Read after the version: what is written in between is read again next time.
            self._read = (
                version,
                {
                    # In the order of their keys; compared as they are.
                    name: self._reader.execute(question).fetchall()
                    for name, question in _QUESTIONS.items()
                },
            )
        return self._read[1]


# What a gateway was when it came is written a little after it came.
_UNSTEADY = {"used_us", "last_seen_us", "seen_us", "version", "address"}
# A picture is measured a little after it came, too.
_UNSTEADY |= {"measured", "background", "stars", "measure_note", "bytes"}
# That something was asked is written down.
_QUESTIONS = {
    table.name: str(
        select(*(each for each in table.c if each.name not in _UNSTEADY)).order_by(
            *table.primary_key.columns
        )
    )
    for table in metadata.sorted_tables
    if not table.name.startswith("audit")
}
