"""How each route is tried: about which objects, with which words, and what it answers when done."""

from __future__ import annotations

import hashlib
import itertools
from typing import TYPE_CHECKING, NamedTuple
from zlib import crc32

import pyotp

from talaia.hub.auth.passkey_ceremony import RegisteredPasskey
from talaia.hub.policy import AccessNeed
from talaia.hub.store.accounts.identities import Identities
from talaia.hub.store.accounts.passkeys import Passkeys
from talaia.hub.store.sites.map_sources import MapSource, SourceKind
from talaia.hub.store.witnessed_hubs import WitnessedHubs
from talaia.model.observing.states import RequestState
from talaia.wire.frames import FileOffer, FilePiece, FilmOffer

from .boards import BOARD, changes_board, kept_board, reads_board, shares_board
from .missions import MISSION, kept_mission
from .notes import NOTED, VIEWED, kept_note, manages_noted, note_of, uses_noted
from .observing import (
    ALERT_RULE,
    ASKED,
    kept_proposal,
    make_alert_rule,
    make_group,
    make_proposal,
)
from .world import HOLDS, NOW, OBJECTS, PASSWORD, PICTURED, SESSIONLESS, SIGNED_IN, TOKEN, holds

if TYPE_CHECKING:
    from collections.abc import Awaitable, Callable, Mapping

    import httpx

    from .world import World

MAP_TILES = "https://tiles.example/{z}/{x}/{y}.png"
# What is asked there may end anyone's session.
ABOUT_PEOPLE = (
    "/api/people",
    "/api/displays",
    "/api/roles",
    "/api/me",
    "/api/login",
    "/api/logout",
    "/api/setup",
)


class Ask(NamedTuple):
    """One request."""

    params: Mapping[str, str] = {}
    query: Mapping[str, object] = {}
    json: object = None
    # What the route answers to those who may.
    done: tuple[int, ...] = (200,)


class Recipe(NamedTuple):
    """How to ask a route, about each of these objects."""

    make: Callable[[World, httpx.AsyncClient, str], Awaitable[Ask]]
    objects: tuple[str, ...] = ("",)
    # Takes the place of the policy's line where the line leaves the object to the route.
    meets: Callable[[str, str], bool] | None = None


def plain(**ask: object) -> Callable[[World, httpx.AsyncClient, str], Awaitable[Ask]]:
    """Ask the same of everyone."""

    async def make(_world: World, _client: httpx.AsyncClient, _about: str) -> Ask:
        return Ask(**ask)

    return make


def of_version(**ask: object) -> Recipe:
    """Ask about the first description of both sites."""

    async def make(_world: World, _client: httpx.AsyncClient, about: str) -> Ask:
        return Ask(params={"site": about, "number": "1"}, **ask)

    return Recipe(make, ("agv", "moon"))


def of_site(**ask: object) -> Recipe:
    """Ask about both sites."""

    async def make(_world: World, _client: httpx.AsyncClient, about: str) -> Ask:
        return Ask(params={"site": about}, **ask)

    return Recipe(make, ("agv", "moon"))


async def _ended_known(_world: World, _client: httpx.AsyncClient, about: str) -> Ask:
    return Ask({"site": about, "known": "none"}, done=(404,))


async def _shown_test(world: World, client: httpx.AsyncClient, about: str) -> Ask:
    return await _of_test(world, client, about, done=(200,))


async def _cancelled_test(world: World, client: httpx.AsyncClient, about: str) -> Ask:
    return await _of_test(world, client, about, done=(204,))


async def _of_test(
    world: World, _client: httpx.AsyncClient, about: str, done: tuple[int, ...]
) -> Ask:
    # One for each site: a test that was called off is there to be seen.
    if about not in world.back_tests:
        address = {"agv": "base/open", "moon": "rover/open"}[about]
        asked = {"address": address, "detector": "limits", "maximum": 0, "from_us": 1, "to_us": 2}
        made = await (await world.admin()).post(f"/api/sites/{about}/anomalies/tests", json=asked)
        assert made.status_code == 201, made.text
        world.back_tests[about] = made.json()["key"]
    return Ask({"site": about, "test": world.back_tests[about]}, done=done)


async def _history(_world: World, _client: httpx.AsyncClient, about: str) -> Ask:
    channel = {"agv": "base/open", "moon": "rover/open"}[about]
    return Ask({"site": about}, {"channel": channel, "from_us": NOW, "to_us": NOW + 1})


async def _last(world: World, client: httpx.AsyncClient, about: str) -> Ask:
    ask = await _history(world, client, about)
    return Ask(ask.params, {"channel": ask.query["channel"], "before_us": NOW})


async def _export(world: World, client: httpx.AsyncClient, about: str) -> Ask:
    ask = await _history(world, client, about)
    return Ask(ask.params, {**ask.query, "format": "csv"})


def of_mission(done: int = 204, **ask: object) -> Recipe:
    """Ask about a mission of both sites."""

    async def make(world: World, _client: httpx.AsyncClient, about: str) -> Ask:
        params = {"site": about, "mission": await kept_mission(world, about)}
        return Ask(params=params, done=(done,), **ask)

    return Recipe(make, ("agv", "moon"))


_NUMBERS = itertools.count()
SITES = ("agv", "moon")
OTHER_PASSWORD = "another password of these tests"  # noqa: S105
NEW_PERSON = {"name": "eve", "password": OTHER_PASSWORD, "role": "guest"}
NEW_ROLE = {
    "name": "watchers",
    "permissions": [{"right": "view", "site": "agv", "device": "*"}],
}
# What of one's own account is tried with: one's own, and another's.
OWN_AND_FOREIGN = ("own", "foreign")


def _own(actor: str, about: str) -> bool:
    return about == "own" and actor in SIGNED_IN and actor != "token"


async def _session(world: World, client: httpx.AsyncClient, about: str) -> Ask:
    if about == "own":
        listed = await client.get("/api/me/sessions")
        found = listed.json().get("sessions", [])
        return Ask({"session": found[0]["id"] if found else "0" * 64}, done=(204,))
    # Nobody's client is this person's.
    person = int(await world.person())
    await world.hub.hub.people.sessions.start_session(person, "127.0.0.1")
    return Ask({"session": (await world.hub.hub.people.sessions.sessions_of(person))[0].id})


async def _token(world: World, client: httpx.AsyncClient, about: str) -> Ask:
    if about == "own":
        made = await client.post("/api/me/tokens", json={**TOKEN, "permissions": []})
        return Ask({"token": made.json().get("id", "0")}, done=(204,))
    person = int(await world.person())
    number, _ = await world.hub.hub.people.tokens.add_token(person, "theirs", TOKEN["ends_us"], [])
    return Ask({"token": str(number)})


async def _display(world: World, _client: httpx.AsyncClient, _about: str) -> Ask:
    number, _ = await world.hub.hub.people.displays.add_display("Hall", ["agv"])
    return Ask({"display": str(number)}, done=(204,))


async def _open_display(world: World, _client: httpx.AsyncClient, _about: str) -> Ask:
    _, token = await world.hub.hub.people.displays.add_display("Hall", ["agv"])
    return Ask(json={"token": token}, done=(204,))


async def _other_hub(world: World, _client: httpx.AsyncClient, _about: str) -> Ask:
    core = world.hub.hub.core
    made = await WitnessedHubs(core.database, core.clock).add_hub("Other", 30)
    assert made is not None
    return Ask({"hub": str(made[0])}, done=(200, 204))


async def _map_source(world: World, client: httpx.AsyncClient, _about: str) -> Ask:
    source = MapSource(0, "Streets", SourceKind.TILES, MAP_TILES, "", 19)
    made = await world.hub.hub.maps.sources.add_source(source, "")
    if made is None:
        # Many ask: those that nobody may remove are in the way of the next.
        for old in await world.hub.hub.maps.sources.list_sources():
            await world.hub.hub.maps.sources.remove_source(old.id)
        return await _map_source(world, client, _about)
    return Ask({"source": str(made)}, done=(204,))


async def _add_map_source(world: World, client: httpx.AsyncClient, about: str) -> Ask:
    await _map_source(world, client, about)
    return Ask(json={"name": "Streets", "address": MAP_TILES})


async def _passkey(world: World, client: httpx.AsyncClient, about: str) -> Ask:
    core = world.hub.hub.core
    person = int(await world.person())
    if about == "own":
        named = (await client.get("/api/me")).json().get("name", "")
        # Of who cannot remove it none is made: they would sign in with it from then on.
        if not named or "Authorization" in client.headers:
            return Ask({"passkey": "0"})
        person = (await world.hub.people.find_by_name(named)).id
    key = RegisteredPasskey(f"key {next(_NUMBERS)}", "", 0)
    made, _ = await Passkeys(core.database, core.clock).add_passkey(person, "key", "hub", key)
    return Ask({"passkey": str(made)}, done=(204,))


async def _connected(world: World, client: httpx.AsyncClient, _about: str) -> Ask:
    """Let a provider sign in who asks."""
    named = (await client.get("/api/me")).json().get("name", "")
    if named and "Authorization" not in client.headers:
        await _connect(world, (await world.hub.people.find_by_name(named)).id)
    return Ask(done=(204,))


async def _connected_person(world: World, _client: httpx.AsyncClient, _about: str) -> Ask:
    person = await world.person()
    await _connect(world, int(person))
    return Ask({"person": person}, done=(204,))


async def _connect(world: World, person: int) -> None:
    core = world.hub.hub.core
    known = Identities(core.database, core.clock)
    if not await known.is_connected(person):
        await known.connect(person, "https://id.example", f"subject {next(_NUMBERS)}")


async def _asset(world: World, client: httpx.AsyncClient, about: str) -> Ask:
    """Ask for a mesh that is there. Who sees the site and views no device of it is told of none."""
    file = world.hub.settings.assets / about / "base" / "body.stl"
    file.parent.mkdir(parents=True, exist_ok=True)
    file.write_bytes(b"solid body\nendsolid body\n")
    named = (await client.get("/api/me")).json().get("name", "")
    views = "Authorization" in client.headers or (named in HOLDS and _views_a_device(named, about))
    return Ask(
        {"site": about}, {"uri": "package://base/body.stl"}, done=(200,) if views else (404,)
    )


def _views_a_device(actor: str, site: str) -> bool:
    return any(holds(actor, "view", about) for about in OBJECTS if about.startswith(f"{site}/"))


async def _no_passkey(_world: World, _client: httpx.AsyncClient, _about: str) -> Ask:
    # One that stays would be asked for at each sign-in that follows.
    return Ask({"passkey": "0"}, json={"name": "another"}, done=(404,))


async def _confirm(_world: World, client: httpx.AsyncClient, _about: str) -> Ask:
    begun = await client.post("/api/me/factor", json={"password": PASSWORD})
    secret = begun.json().get("secret")
    return Ask(json={"code": pyotp.TOTP(secret).now() if secret else "000000"})


async def _remove_factor(world: World, client: httpx.AsyncClient, about: str) -> Ask:
    confirm = await _confirm(world, client, about)
    done = await client.post("/api/me/factor/confirm", json=confirm.json)
    code = done.json().get("recovery", ["000000"])[0]
    return Ask(json={"password": PASSWORD, "code": code}, done=(204,))


def _of_person(**ask: object) -> Recipe:
    """Ask about somebody who has just been added."""

    async def make(world: World, _client: httpx.AsyncClient, _about: str) -> Ask:
        return Ask({"person": await world.person()}, **ask)

    return Recipe(make)


def _of_role(**ask: object) -> Recipe:
    """Ask about a role that has just been made."""

    async def make(world: World, _client: httpx.AsyncClient, _about: str) -> Ask:
        name = f"role {next(_NUMBERS)}"
        made = await (await world.admin()).post("/api/roles", json={**NEW_ROLE, "name": name})
        return Ask({"role": made.json()["id"]}, **ask)

    return Recipe(make)


async def _code(world: World, _client: httpx.AsyncClient, _about: str) -> Ask:
    made = await (await world.admin()).post("/api/gateways/codes", json={"site": "farm"})
    return Ask({"code": made.json()["id"]}, done=(204,))


async def _enrol(world: World, _client: httpx.AsyncClient, _about: str) -> Ask:
    made = await (await world.admin()).post("/api/gateways/codes", json={"site": "farm"})
    return Ask(json={"code": made.json()["code"], "name": "a new gateway"})


async def _gateway(world: World, site: str) -> str:
    known = (await (await world.admin()).get("/api/gateways")).json()["gateways"]
    return next(each["id"] for each in known if each["site"] == site and not each["revoked_us"])


async def _revoke(world: World, _client: httpx.AsyncClient, _about: str) -> Ask:
    await world.hub.hub.gateways.registry.new_key("farm")
    return Ask({"gateway": await _gateway(world, "farm")}, done=(204,))


async def _reconnect(world: World, _client: httpx.AsyncClient, _about: str) -> Ask:
    return Ask({"gateway": await _gateway(world, "agv")}, json={"device": "base"}, done=(202,))


async def _second(world: World, _client: httpx.AsyncClient, _about: str) -> Ask:
    # None waits.
    about = {"gateway": await _gateway(world, "agv")}
    return Ask(about, json={"stays": "linked"}, done=(409,))


async def _picture(world: World, _client: httpx.AsyncClient, about: str) -> Ask:
    return Ask({"site": about.partition("/")[0], "frame": await world.picture(about)})


# About the camera, which alone decides who sees what it took.
_OF_PICTURE = Recipe(_picture, PICTURED)


async def _sighting(world: World, _client: httpx.AsyncClient, about: str) -> Ask:
    return Ask({"site": about.partition("/")[0], "sighting": await world.sighting(about)})


async def _recording(world: World, _client: httpx.AsyncClient, about: str) -> Ask:
    """Have a recording of a site, as if its gateway had just handed it over."""
    recordings = world.hub_of(about).recordings.files
    name, body = f"r{next(_NUMBERS)}", b"mcap"
    offer = FileOffer(
        id=name, size=4, digest=hashlib.sha256(body).hexdigest(), begin_us=NOW, end_us=NOW
    )
    await recordings.answer_offer(about, offer)
    done = await recordings.append_piece(
        about, offer, FilePiece(id=name, at=0, check=crc32(body), data=body)
    )
    assert done.done
    return Ask({"site": about, "recording": name})


# Devices with a camera of which there is a film.
FILMED = ("agv/camera", "moon/rover")


async def _film(world: World, _client: httpx.AsyncClient, about: str) -> Ask:
    """Have a film of a device's camera, as if its gateway had just handed it over."""
    recordings = world.hub_of(about.partition("/")[0]).recordings.files
    site, _, device = about.partition("/")
    name, body = f"r{next(_NUMBERS)}", b"film"
    offer = FilmOffer(
        id=name, stream=f"{device}/eye", size=4, begin_us=NOW, end_us=NOW,
        digest=hashlib.sha256(body).hexdigest(),
    )  # fmt: skip
    await recordings.answer_offer(site, offer)
    piece = FilePiece(id=name, at=0, check=crc32(body), data=body)
    assert (await recordings.append_piece(site, offer, piece)).done
    return Ask({"site": site, "recording": name})


async def _film_picture(world: World, client: httpx.AsyncClient, about: str) -> Ask:
    asked = await _film(world, client, about)
    return asked._replace(query={"at_us": NOW}, done=(409,))


async def _no_recording(world: World, client: httpx.AsyncClient, about: str) -> Ask:
    return (await _recording(world, client, about))._replace(done=(204,))


ALARMED = ("agv/base", "agv/power", "moon/rover")
# Never raised: what a hub does by itself would look as if asking had done it.
ALARM = {"name": "Made", "kind": "limit", "above": 1e9}


async def _write_note(_world: World, _client: httpx.AsyncClient, about: str) -> Ask:
    return Ask({"site": about.partition("/")[0]}, json=note_of(about), done=(201,))


async def _change_note(world: World, _client: httpx.AsyncClient, about: str) -> Ask:
    return Ask(await kept_note(world, about), json={**note_of(about), "base": 1})


async def _remove_note(world: World, _client: httpx.AsyncClient, about: str) -> Ask:
    return Ask(await kept_note(world, about), done=(204,))


def _of_alarm(level: str, **ask: object) -> Recipe:
    """Ask about the alarm of a device, which alone decides who may do what with it."""

    async def make(_world: World, _client: httpx.AsyncClient, about: str) -> Ask:
        site, _, device = about.partition("/")
        return Ask({"site": site, "alarm": f"odd_{device}"}, **ask)

    return Recipe(make, ALARMED, lambda actor, about: holds(actor, level, about))


def _definition(site: str) -> dict[str, str]:
    return {**ALARM, "signal": {"agv": "base/open", "moon": "rover/open"}[site]}


async def _define(_world: World, _client: httpx.AsyncClient, about: str) -> Ask:
    name = f"made_{next(_NUMBERS)}"
    return Ask({"site": about, "alarm": name}, json=_definition(about), done=(204,))


async def _undefine(world: World, client: httpx.AsyncClient, about: str) -> Ask:
    ask = await _define(world, client, about)
    path = f"/api/sites/{about}/alarms/{ask.params['alarm']}"
    made = await (await world.admin()).put(path, json=ask.json)
    assert made.status_code == 204, made.text
    return Ask(ask.params, done=(204,))


async def _preview(_world: World, _client: httpx.AsyncClient, about: str) -> Ask:
    return Ask({"site": about}, json={"definition": _definition(about)})


def _way_of(number: int) -> dict[str, object]:
    # Nothing answers there, and the hub may not speak to it anyway.
    url = {"url": "http://127.0.0.1:9/"}
    return {"name": f"way {number}", "kind": "webhook", "secrets": url}


async def _way(world: World, _client: httpx.AsyncClient, _about: str) -> str:
    way = _way_of(next(_NUMBERS))
    made = await (await world.admin()).post("/api/ways", json=way)
    return made.json()["id"]


async def _add_way(_world: World, _client: httpx.AsyncClient, _about: str) -> Ask:
    return Ask(json=_way_of(next(_NUMBERS)), done=(201,))


def _of_way(**ask: object) -> Recipe:
    """Ask about a way that has just been set up."""

    async def make(world: World, client: httpx.AsyncClient, about: str) -> Ask:
        return Ask({"way": await _way(world, client, about)}, **ask)

    return Recipe(make)


def _of_board(
    meets: Callable[[str, str], bool], about: tuple[str, ...] = OWN_AND_FOREIGN, **ask: object
) -> Recipe:
    """Ask about a board that was just kept, in its first version."""

    async def make(world: World, client: httpx.AsyncClient, about: str) -> Ask:
        return Ask({"board": await kept_board(world, client, about), "number": "1"}, **ask)

    return Recipe(make, about, meets)


async def _add_rule(world: World, client: httpx.AsyncClient, about: str) -> Ask:
    return Ask(json={"site": "*", "way": await _way(world, client, about)}, done=(201,))


def _tested(actor: str, about: str) -> bool:
    # A guest may view nothing, so there is nothing to be told.
    return _own(actor, about) and actor != "guest"


def _of_rule(mine: Callable[[str, str], bool], **ask: object) -> Recipe:
    async def make(world: World, client: httpx.AsyncClient, about: str) -> Ask:
        added = await _add_rule(world, client, about)
        whose = client if about == "own" else await world.admin()
        made = await whose.post("/api/me/rules", json=added.json)
        return Ask({"rule": made.json().get("id", "0")}, **ask)

    return Recipe(make, OWN_AND_FOREIGN, lambda *who: mine(*who) or _is_admin(*who))


async def _change_rule(world: World, client: httpx.AsyncClient, about: str) -> Ask:
    ask = await _of_rule(_own).make(world, client, about)
    changed = await _add_rule(world, client, about)
    return Ask(ask.params, json=changed.json, done=(204,))


def _is_admin(actor: str, about: str) -> bool:
    # The foreign rule is the admin's.
    return actor == "admin" and about == "foreign"


async def _browser(world: World, client: httpx.AsyncClient, about: str) -> Ask:
    endpoint = f"https://push.example/{next(_NUMBERS)}"
    asked = {"endpoint": endpoint, "p256dh": "AA", "auth": "AA"}
    whose = client if about == "own" else await world.admin()
    await whose.post("/api/me/push", json=asked)
    listed = (await whose.get("/api/me/push")).json().get("browsers", [])
    return Ask({"browser": listed[-1]["id"] if listed else "0"}, done=(204,))


async def _client_driver(world: World, _client: httpx.AsyncClient, _about: str) -> Ask:
    person = await world.person()
    asked = {"person": person, "site": "agv", "device": "base", "allowed": False}
    return Ask(json=asked, done=(204,))


def _opened(protocol: str, **ask: object) -> Callable[..., Awaitable[Ask]]:
    """Open a client protocol for pages of the hub's own origin, and ask the same of everyone."""

    async def make(world: World, _client: httpx.AsyncClient, _about: str) -> Ask:
        opened = {"open": True, "origins": [world.hub.origin, world.another.origin]}
        answer = await (await world.admin()).put(f"/api/client-protocols/{protocol}", json=opened)
        assert answer.status_code == 204, answer.text
        return Ask(**ask)

    return make


def _of_proposal(**ask: object) -> Recipe:
    """Ask about a proposal that has just been made."""

    async def make(world: World, _client: httpx.AsyncClient, about: str) -> Ask:
        return Ask({"site": about, "proposal": await make_proposal(world, about)}, **ask)

    return Recipe(make, SITES)


def _of_proposal_seen() -> Recipe:
    """Ask for what those see who are members of a proposal, and who approve."""

    async def make(world: World, _client: httpx.AsyncClient, about: str) -> Ask:
        site = about.partition("/")[0]
        return Ask({"site": site, "proposal": await make_proposal(world, site)})

    # As below: a device that exactly those may view stands for the proposal.
    return Recipe(make, PICTURED)


def _of_group(
    objects: tuple[str, ...],
    state: RequestState = RequestState.DRAFT,
    *,
    submitted: bool = False,
    number: bool = False,
    **ask: object,
) -> Recipe:
    """Ask about what the operator has just asked for; others see it where they approve."""

    async def make(world: World, _client: httpx.AsyncClient, about: str) -> Ask:
        site = about.partition("/")[0]
        group, request = await make_group(world, site, state, submitted=submitted)
        named = {"number": request} if number else {"group": group}
        return Ask({"site": site, **named}, **ask)

    # A device that exactly those may view who see the proposal stands for it.
    return Recipe(make, objects)


async def _ask_for(world: World, _client: httpx.AsyncClient, about: str) -> Ask:
    body = {"proposal": await kept_proposal(world, about), "requests": [ASKED], "draft": True}
    return Ask({"site": about}, json=body, done=(201,))


async def _validate(world: World, client: httpx.AsyncClient, about: str) -> Ask:
    return (await _ask_for(world, client, about))._replace(done=(200,))


async def _import(world: World, _client: httpx.AsyncClient, about: str) -> Ask:
    proposal = await kept_proposal(world, about)
    body = {
        "kind": "csv",
        "text": "ra,dec\n1,2",
        "proposal": proposal,
        "window": ASKED["windows"][0],
    }
    return Ask({"site": about}, json=body)


async def _change_draft(world: World, client: httpx.AsyncClient, about: str) -> Ask:
    group, _ = await make_group(world, about)
    ask = await _ask_for(world, client, about)
    return Ask({"site": about, "group": group}, json=ask.json)


def _alert_rules(**ask: object) -> Recipe:
    """Ask about rules of a proposal: its members see them, and whoever approves leads it."""
    reads = ask.pop("reads", False)

    async def make(world: World, _client: httpx.AsyncClient, about: str) -> Ask:
        named = {"site": about, "proposal": await make_proposal(world, about)}
        return Ask({**named, "rule": await make_alert_rule(world, **named)}, **ask)

    return Recipe(make, SITES, _of_proposal_s_people if reads else _leads)


def _of_proposal_s_people(actor: str, about: str) -> bool:
    return actor in {"operator", "keeper", "admin"} and holds(actor, "use", about)


def _leads(actor: str, about: str) -> bool:
    return actor in {"keeper", "admin"} and holds(actor, "admin", about)


def _nobody(_actor: str, _about: str) -> bool:
    return False


RECIPES: Mapping[tuple[str, str], Recipe] = {
    ("GET", "/api/health"): Recipe(plain()),
    ("GET", "/api/ready"): Recipe(plain()),
    ("GET", "/api/hubs"): Recipe(plain()),
    ("GET", "/api/releases"): Recipe(plain()),
    # There is no release to hand out, and that is no matter of rights.
    ("POST", "/api/rollouts"): Recipe(
        plain(json={"version": "1.0.0", "sites": ["agv"]}, done=(409,))
    ),
    ("POST", "/api/rollouts/stop"): Recipe(plain(json={}, done=(409,))),
    ("POST", "/api/login"): Recipe(plain(json={"name": "guest", "password": PASSWORD})),
    # There are people: the link is used up for everyone, and that is no matter of rights.
    ("POST", "/api/setup"): Recipe(
        plain(json={"token": "t", "name": "eve", "password": PASSWORD}, done=(403, 429))
    ),
    ("POST", "/api/logout"): Recipe(plain(done=(204,))),
    ("GET", "/api/me"): Recipe(plain()),
    ("GET", "/api/sites"): Recipe(plain()),
    ("GET", "/api/sites/{site}"): of_site(),
    ("GET", "/api/sites/{site}/history"): Recipe(_history, ("agv", "moon")),
    ("GET", "/api/sites/{site}/last"): Recipe(_last, ("agv", "moon")),
    ("GET", "/api/sites/{site}/statistics"): Recipe(_history, ("agv", "moon")),
    ("GET", "/api/sites/{site}/outliers"): Recipe(_history, ("agv", "moon")),
    ("GET", "/api/sites/{site}/stored"): of_site(),
    ("GET", "/api/sites/{site}/export"): Recipe(_export, ("agv", "moon")),
    ("GET", "/api/sites/{site}/events"): of_site(),
    ("GET", "/api/sites/{site}/assets"): Recipe(_asset, ("agv", "moon")),
    ("GET", "/api/sites/{site}/topics"): of_site(),
    ("GET", "/api/sites/{site}/log"): of_site(),
    ("GET", "/api/sites/{site}/log/nodes"): of_site(),
    ("GET", "/api/sites/{site}/graph"): of_site(),
    ("GET", "/api/sites/{site}/recorded-topics"): of_site(query={"at_us": 1}),
    ("GET", "/api/sites/{site}/recorded-topics/messages"): of_site(
        query={"topic": "/odom", "from_us": 1, "to_us": 2}
    ),
    ("GET", "/api/sites/{site}/recorded-topics/bytes"): of_site(
        query={"topic": "/odom", "from_us": 1, "to_us": 2}
    ),
    ("GET", "/api/sites/{site}/sky"): of_site(query={"name": "M31"}),
    ("GET", "/api/sites/{site}/sky/field"): of_site(query={"ra": 10.7, "dec": 41.3, "radius": 1}),
    ("GET", "/api/sites/{site}/nights"): of_site(),
    ("GET", "/api/sites/{site}/frames"): of_site(),
    ("GET", "/api/sites/{site}/frames/{frame}"): _OF_PICTURE,
    ("GET", "/api/sites/{site}/frames/{frame}/file"): _OF_PICTURE,
    ("GET", "/api/sites/{site}/frames/{frame}/preview"): _OF_PICTURE,
    ("GET", "/api/sites/{site}/sightings"): of_site(),
    ("GET", "/api/sites/{site}/sightings/labels"): of_site(),
    ("GET", "/api/sites/{site}/sightings/days"): of_site(),
    ("POST", "/api/sites/{site}/sightings/seen"): of_site(json={"ids": ["1"]}),
    ("GET", "/api/sites/{site}/sightings/{sighting}/picture"): Recipe(_sighting, PICTURED),
    ("GET", "/api/sites/{site}/descriptions"): of_site(),
    ("GET", "/api/sites/{site}/descriptions/{number}"): of_version(),
    ("GET", "/api/sites/{site}/descriptions/{number}/difference"): of_version(query={"to": 1}),
    # What these gateways go by is not one file, so nobody changes it from here.
    ("POST", "/api/sites/{site}/descriptions"): of_site(
        json={"text": "talaia: 1", "base": "0" * 64}, done=(409,)
    ),
    ("POST", "/api/sites/{site}/descriptions/{number}/restore"): of_version(
        json={"base": "0" * 64}, done=(409,)
    ),
    ("POST", "/api/sites/{site}/descriptions/check"): of_site(json={"text": "talaia: 1"}),
    ("POST", "/api/sites/{site}/descriptions/edit"): of_site(
        json={"text": "talaia: 1", "site": {}}
    ),
    ("GET", "/api/description-schema"): Recipe(plain()),
    # With the right to metrics: see `test_metrics_route` and `test_remote_read_route`.
    ("GET", "/metrics"): Recipe(_opened("metrics"), meets=_nobody),
    ("POST", "/clients/prometheus/read"): Recipe(_opened("metrics"), meets=_nobody),
    # What is no packet is answered as such; see `clients.socketio.test_session`.
    ("GET", "/socket.io/"): Recipe(_opened("socketio", done=(400,))),
    ("POST", "/socket.io/"): Recipe(_opened("socketio", done=(400,))),
    ("GET", "/api/client-protocols"): Recipe(plain()),
    ("PUT", "/api/client-protocols/{protocol}"): Recipe(
        plain(params={"protocol": "foxglove"}, json={"open": False}, done=(204,))
    ),
    ("PUT", "/api/client-drivers"): Recipe(_client_driver),
    ("GET", "/api/sites/{site}/missions"): of_site(),
    ("POST", "/api/sites/{site}/missions"): of_site(json=MISSION),
    ("POST", "/api/sites/{site}/missions/reading"): of_site(json={"text": "mission: 1"}),
    ("PUT", "/api/sites/{site}/missions/{mission}"): of_mission(json=MISSION),
    ("DELETE", "/api/sites/{site}/missions/{mission}"): of_mission(),
    ("GET", "/api/sites/{site}/missions/{mission}/text"): of_mission(200),
    # Nothing is heard of its device.
    ("POST", "/api/sites/{site}/missions/{mission}/start"): of_mission(409, json={"first": 0}),
    ("GET", "/api/sites/{site}/mission-runs"): of_site(),
    # None goes on there.
    ("POST", "/api/sites/{site}/mission-runs/act"): of_site(json={"act": "pause"}, done=(409,)),
    ("GET", "/api/storage"): Recipe(plain()),
    ("POST", "/api/support-bundle"): Recipe(plain(json={})),
    ("GET", "/api/sites/{site}/anomalies"): of_site(),
    # No detector is at work there, which only those are told who may say it.
    ("POST", "/api/sites/{site}/anomalies/forgiven"): of_site(
        json={"address": "base/open", "detector": "change"}, done=(404,)
    ),
    ("POST", "/api/sites/{site}/anomalies/confirmed"): of_site(
        json={"address": "base/open", "detector": "change"}, done=(404,)
    ),
    ("GET", "/api/sites/{site}/causes"): of_site(query={"at_us": "1"}),
    # No such detector is at work, and no such entry is kept.
    ("POST", "/api/sites/{site}/causes/known"): of_site(
        json={"address": "base/open", "detector": "change"}, done=(404,)
    ),
    ("DELETE", "/api/sites/{site}/causes/known/{known}"): Recipe(_ended_known, SITES),
    ("GET", "/api/sites/{site}/anomalies/budget"): of_site(),
    ("PUT", "/api/sites/{site}/anomalies/budget"): of_site(json={"a_week": 1}),
    ("POST", "/api/sites/{site}/anomalies/learned"): of_site(
        json={"address": "/base", "from_us": 1, "to_us": 2}, done=(404,)
    ),
    ("POST", "/api/sites/{site}/anomalies/tests"): of_site(
        json={"address": "/base", "from_us": 1, "to_us": 2}, done=(404,)
    ),
    ("GET", "/api/sites/{site}/anomalies/tests/{test}"): Recipe(_shown_test, ("agv", "moon")),
    ("DELETE", "/api/sites/{site}/anomalies/tests/{test}"): Recipe(
        _cancelled_test, ("agv", "moon")
    ),
    ("GET", "/api/sites/{site}/proposals"): of_site(),
    # These sites do not observe by themselves.
    ("POST", "/api/sites/{site}/proposals"): of_site(
        json={"id": "P", "hours_allocated": 1}, done=(409,)
    ),
    ("PUT", "/api/sites/{site}/proposals/{proposal}"): _of_proposal(
        json={"hours_allocated": 1}, done=(204,)
    ),
    ("DELETE", "/api/sites/{site}/proposals/{proposal}"): _of_proposal(done=(204,)),
    ("PUT", "/api/sites/{site}/proposals/{proposal}/members"): _of_proposal(
        json={"name": "guest", "role": "member"}, done=(204,)
    ),
    ("GET", "/api/sites/{site}/requests"): of_site(),
    ("GET", "/api/sites/{site}/requests/{number}/frames"): _of_group(PICTURED, number=True),
    ("GET", "/api/sites/{site}/proposals/{proposal}/pictures"): _of_proposal_seen(),
    ("GET", "/api/sites/{site}/obscore"): of_site(),
    ("GET", "/api/sites/{site}/requests/{number}"): _of_group(PICTURED, number=True),
    ("GET", "/api/sites/{site}/request-groups/{group}"): _of_group(PICTURED),
    ("POST", "/api/sites/{site}/request-groups"): Recipe(_ask_for, SITES),
    ("PUT", "/api/sites/{site}/request-groups/{group}"): Recipe(_change_draft, SITES),
    ("POST", "/api/sites/{site}/request-groups/{group}/clone"): _of_group(SITES, done=(201,)),
    ("POST", "/api/sites/{site}/request-groups/validate"): Recipe(_validate, SITES),
    ("POST", "/api/sites/{site}/request-groups/import"): Recipe(_import, SITES),
    ("GET", "/api/sites/{site}/night/forecast"): of_site(done=(409,)),
    ("GET", "/api/sites/{site}/night/week"): of_site(done=(409,)),
    # Nobody would observe it, which only those are told who may hand it in.
    ("POST", "/api/sites/{site}/request-groups/{group}/submit"): _of_group(
        SITES, json={}, done=(422,)
    ),
    ("POST", "/api/sites/{site}/request-groups/{group}/withdraw"): _of_group(
        PICTURED, submitted=True, json={}
    ),
    ("POST", "/api/sites/{site}/request-groups/{group}/cancel"): _of_group(PICTURED, json={}),
    ("POST", "/api/sites/{site}/request-groups/{group}/approve"): _of_group(
        SITES, submitted=True, json={}
    ),
    ("POST", "/api/sites/{site}/request-groups/{group}/retry"): _of_group(
        SITES, RequestState.FAILURE_LIMIT_REACHED, json={}
    ),
    ("GET", "/api/sites/{site}/proposals/{proposal}/alert-rules"): _alert_rules(reads=True),
    ("POST", "/api/sites/{site}/proposals/{proposal}/alert-rules"): _alert_rules(
        json=ALERT_RULE, done=(201,)
    ),
    ("PUT", "/api/sites/{site}/proposals/{proposal}/alert-rules/{rule}"): _alert_rules(
        json=ALERT_RULE, done=(204,)
    ),
    ("DELETE", "/api/sites/{site}/proposals/{proposal}/alert-rules/{rule}"): _alert_rules(
        done=(204,)
    ),
    ("POST", "/api/sites/{site}/proposals/{proposal}/alert-preview"): _alert_rules(json=ALERT_RULE),
    # A token brings notices, and that of these tests may not ask for anything.
    ("POST", "/api/sites/{site}/alert-notices"): Recipe(
        of_site(json={"text": "{}"}).make, SITES, _nobody
    ),
    ("GET", "/api/sites/{site}/night"): of_site(),
    ("POST", "/api/sites/{site}/night/arm"): of_site(json={}, done=(409,)),
    ("POST", "/api/sites/{site}/night/disarm"): of_site(json={}, done=(409,)),
    ("POST", "/api/sites/{site}/night/short"): of_site(done=(409,)),
    ("GET", "/api/sites/{site}/recordings"): of_site(),
    ("POST", "/api/sites/{site}/recordings"): of_site(json={"on": True}, done=(202,)),
    ("GET", "/api/sites/{site}/recordings/{recording}/file"): Recipe(_recording, SITES),
    ("GET", "/api/sites/{site}/films"): of_site(),
    ("GET", "/api/sites/{site}/films/{recording}/file"): Recipe(
        _film, FILMED, lambda actor, about: holds(actor, "view", about)
    ),
    # Of the bytes of these tests no picture can be made, and that is said to who may see it.
    ("GET", "/api/sites/{site}/films/{recording}/picture"): Recipe(
        _film_picture, FILMED, lambda actor, about: holds(actor, "view", about)
    ),
    ("DELETE", "/api/sites/{site}/recordings/{recording}"): Recipe(_no_recording, SITES),
    ("GET", "/api/storage/outlook"): Recipe(plain()),
    ("GET", "/api/sites/{site}/notes"): of_site(),
    ("GET", "/api/sites/{site}/notes/export"): of_site(),
    ("POST", "/api/sites/{site}/notes"): Recipe(_write_note, NOTED, uses_noted),
    ("PUT", "/api/sites/{site}/notes/{note}"): Recipe(_change_note, VIEWED, manages_noted),
    ("DELETE", "/api/sites/{site}/notes/{note}"): Recipe(_remove_note, VIEWED, manages_noted),
    ("GET", "/api/boards"): Recipe(plain()),
    ("POST", "/api/boards"): Recipe(plain(json={"board": BOARD})),
    ("POST", "/api/boards/text"): Recipe(plain(json={"board": BOARD})),
    ("POST", "/api/boards/reading"): Recipe(plain(json={"text": "board: 1"})),
    ("GET", "/api/boards/{board}"): _of_board(reads_board),
    ("PUT", "/api/boards/{board}"): _of_board(changes_board, json={"board": BOARD, "base": 1}),
    ("DELETE", "/api/boards/{board}"): _of_board(changes_board, done=(204,)),
    ("PUT", "/api/boards/{board}/share"): _of_board(
        shares_board, json={"share": "view"}, done=(204,)
    ),
    ("PUT", "/api/boards/{board}/public"): _of_board(
        lambda actor, _about: actor == "admin", ("own",), json={}, done=(204,)
    ),
    ("GET", "/api/boards/{board}/versions"): _of_board(reads_board),
    ("GET", "/api/boards/{board}/versions/{number}"): _of_board(reads_board),
    ("POST", "/api/boards/{board}/versions/{number}/restore"): _of_board(
        changes_board, json={"base": 1}
    ),
    ("POST", "/api/me/password"): Recipe(
        plain(json={"old": PASSWORD, "new": OTHER_PASSWORD}, done=(204,))
    ),
    ("POST", "/api/me/confirm"): Recipe(plain(json={"password": PASSWORD}, done=(204,))),
    ("GET", "/api/me/sessions"): Recipe(plain()),
    ("DELETE", "/api/me/sessions"): Recipe(plain(done=(204,))),
    ("DELETE", "/api/me/sessions/{session}"): Recipe(_session, OWN_AND_FOREIGN, _own),
    ("POST", "/api/me/factor"): Recipe(plain(json={"password": PASSWORD})),
    ("POST", "/api/me/factor/confirm"): Recipe(_confirm),
    ("POST", "/api/me/factor/remove"): Recipe(_remove_factor),
    ("POST", "/api/me/factor/seen"): Recipe(plain(json={}, done=(204,))),
    # What a passkey answers is tried elsewhere: this hub is reached by its number, for which
    # browsers make none, and nobody has one.
    ("POST", "/api/login/passkey/options"): Recipe(plain(json={}, done=(409,))),
    ("POST", "/api/login/passkey"): Recipe(plain(json={"credential": {}}, done=(401, 429))),
    # This hub has no provider: whoever may ask is told so.
    ("GET", "/api/login/oidc"): Recipe(plain()),
    ("POST", "/api/login/oidc"): Recipe(plain(json={}, done=(404,))),
    ("POST", "/api/login/oidc/finish"): Recipe(plain(json={"state": "-"}, done=(404,))),
    ("POST", "/api/me/oidc/confirm"): Recipe(plain(json={}, done=(404,))),
    ("POST", "/api/me/oidc/connect"): Recipe(plain(json={}, done=(404,))),
    ("GET", "/api/me/passkeys"): Recipe(plain()),
    ("POST", "/api/me/passkeys"): Recipe(
        plain(json={"name": "key", "credential": {}}, done=(422,))
    ),
    ("POST", "/api/me/passkeys/options"): Recipe(plain(json={}, done=(409,))),
    ("POST", "/api/me/passkeys/challenge"): Recipe(plain(json={}, done=(409,))),
    ("PATCH", "/api/me/passkeys/{passkey}"): Recipe(_no_passkey),
    ("DELETE", "/api/me/passkeys/{passkey}"): Recipe(_passkey, OWN_AND_FOREIGN, _own),
    ("GET", "/api/me/oidc"): Recipe(plain()),
    ("DELETE", "/api/me/oidc"): Recipe(_connected),
    ("GET", "/api/me/tokens"): Recipe(plain()),
    ("POST", "/api/me/tokens"): Recipe(plain(json={**TOKEN, "permissions": []})),
    ("DELETE", "/api/me/tokens/{token}"): Recipe(_token, OWN_AND_FOREIGN, _own),
    ("GET", "/api/displays"): Recipe(plain()),
    ("POST", "/api/displays"): Recipe(plain(json={"name": "Hall", "sites": ["agv"]})),
    ("DELETE", "/api/displays/{display}"): Recipe(_display),
    ("POST", "/api/displays/open"): Recipe(_open_display),
    ("GET", "/api/people"): Recipe(plain()),
    ("POST", "/api/people"): Recipe(plain(json=NEW_PERSON)),
    ("PATCH", "/api/people/{person}"): _of_person(json={"disabled": True}),
    ("DELETE", "/api/people/{person}"): _of_person(done=(204,)),
    ("DELETE", "/api/people/{person}/sessions"): _of_person(done=(204,)),
    # The person has none, which only those are told who may take it away.
    ("DELETE", "/api/people/{person}/factor"): _of_person(done=(409,)),
    ("DELETE", "/api/people/{person}/oidc"): Recipe(_connected_person),
    ("GET", "/api/roles"): Recipe(plain()),
    ("GET", "/api/extensions"): Recipe(plain()),
    ("GET", "/api/tiles"): Recipe(plain()),
    # This hub has no folder of tiles: whoever may ask is told that there is no such file.
    ("GET", "/extensions/{tile}/{path:path}"): Recipe(
        plain(params={"tile": "rose", "path:path": "tile.js"}, done=(404,))
    ),
    ("POST", "/api/roles"): Recipe(plain(json=NEW_ROLE)),
    ("PUT", "/api/roles/{role}"): _of_role(json={"name": "other", "permissions": []}),
    ("DELETE", "/api/roles/{role}"): _of_role(done=(204,)),
    ("PUT", "/api/roles/{role}/factor"): _of_role(json={"required": True}),
    ("GET", "/api/openapi.json"): Recipe(plain()),
    ("GET", "/api/devices"): Recipe(plain()),
    ("GET", "/api/commands"): Recipe(plain()),
    ("GET", "/api/sites/{site}/alarms"): of_site(),
    ("GET", "/api/sites/{site}/alarms/{alarm}/history"): _of_alarm("view"),
    ("POST", "/api/sites/{site}/alarms/{alarm}/act"): _of_alarm(
        "use", json={"act": "comment", "text": "seen"}, done=(204,)
    ),
    ("POST", "/api/sites/{site}/alarm-preview"): Recipe(_preview, SITES),
    ("PUT", "/api/sites/{site}/alarms/{alarm}"): Recipe(_define, SITES),
    ("DELETE", "/api/sites/{site}/alarms/{alarm}"): Recipe(_undefine, SITES),
    ("GET", "/api/me/units"): Recipe(plain()),
    ("PUT", "/api/me/units"): Recipe(plain(json={"shown": {"m/s": "kn"}}, done=(204,))),
    ("GET", "/api/me/ways"): Recipe(plain()),
    ("GET", "/api/me/rules"): Recipe(plain()),
    ("POST", "/api/me/rules"): Recipe(_add_rule),
    ("PUT", "/api/me/rules/{rule}"): Recipe(
        _change_rule, OWN_AND_FOREIGN, lambda *who: _own(*who) or _is_admin(*who)
    ),
    ("DELETE", "/api/me/rules/{rule}"): _of_rule(_own, done=(204,)),
    ("POST", "/api/me/rules/{rule}/test"): _of_rule(_tested),
    ("GET", "/api/me/push"): Recipe(plain()),
    ("POST", "/api/me/push"): Recipe(
        plain(
            json={"endpoint": "https://push.example/1", "p256dh": "AA", "auth": "AA"}, done=(204,)
        )
    ),
    ("DELETE", "/api/me/push/{browser}"): Recipe(
        _browser, OWN_AND_FOREIGN, lambda *who: _own(*who) or _is_admin(*who)
    ),
    ("GET", "/api/ways"): Recipe(plain()),
    ("POST", "/api/ways"): Recipe(_add_way),
    ("PUT", "/api/ways/{way}"): _of_way(json=_way_of(10**6), done=(204,)),
    ("DELETE", "/api/ways/{way}"): _of_way(done=(204,)),
    ("POST", "/api/ways/{way}/test"): _of_way(),
    ("GET", "/api/gateways"): Recipe(plain()),
    ("GET", "/api/maps"): Recipe(plain()),
    ("GET", "/api/maps/files/{name}"): Recipe(plain(params={"name": "a.pmtiles"})),
    # No key of Google is known here.
    ("GET", "/api/maps/sources/{source}/session"): Recipe(
        plain(params={"source": "0"}, done=(404,))
    ),
    ("POST", "/api/maps/sources"): Recipe(_add_map_source),
    ("DELETE", "/api/maps/sources/{source}"): Recipe(_map_source),
    ("POST", "/api/gateways/codes"): Recipe(plain(json={"site": "farm"})),
    ("DELETE", "/api/gateways/codes/{code}"): Recipe(_code),
    ("POST", "/api/gateways/{gateway}/revoke"): Recipe(_revoke),
    ("POST", "/api/gateways/{gateway}/reconnect"): Recipe(_reconnect),
    ("POST", "/api/gateways/{gateway}/second"): Recipe(_second),
    ("POST", "/api/enrol"): Recipe(_enrol),
    ("GET", "/api/audit"): Recipe(plain()),
    ("GET", "/api/audit/export"): Recipe(plain()),
    ("GET", "/api/audit/verify"): Recipe(plain()),
    ("GET", "/api/audit/hubs"): Recipe(plain()),
    ("POST", "/api/audit/hubs"): Recipe(plain(json={"name": "Other"})),
    ("DELETE", "/api/audit/hubs/{hub}"): Recipe(_other_hub),
    ("GET", "/api/audit/hubs/{hub}/heads"): Recipe(_other_hub),
    # What a real token is good for is tried elsewhere; whoever has none is refused by it alone.
    ("POST", "/api/heads"): Recipe(
        plain(json={"token": "-", "key": "A" * 43 + "=", "lines": []}, done=(401,))
    ),
    # The pages themselves; 503 where they are not built.
    ("GET", "/{path:path}"): Recipe(plain(params={"path:path": "home"}, done=(200, 503))),
}


def meets(need: AccessNeed, actor: str, about: str) -> bool:
    """Tell, from the table written by hand, whether somebody meets a need about an object."""
    if need is AccessNeed.OPEN:
        return True
    if actor in SESSIONLESS or need in {AccessNeed.NEVER, AccessNeed.GATEWAY}:
        return False
    if need is AccessNeed.SESSION:
        return True
    if need is AccessNeed.CLIENT:
        return actor == "token"
    if need is AccessNeed.OWN:
        return actor != "token"
    # Operators come with the rights to ask and to arm; of the others admins alone have them.
    beside = {AccessNeed.REQUEST: "use", AccessNeed.ARM: "use", AccessNeed.APPROVE: "admin"}
    return holds(actor, beside.get(need, need.name.lower()), about)
