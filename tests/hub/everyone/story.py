"""Everything that can happen, once: the run in which each socket is listened to.

Whatever is about a device carries its name in a word of its own (`hidden`), and each channel has
numbers that no other has, so that any of it is found wherever it should not be.
"""

from __future__ import annotations

import asyncio
import contextlib
import struct
from typing import TYPE_CHECKING, NamedTuple

from sqlalchemy import update

from talaia.hub.store.tables import sessions
from talaia.model.observing.plan import Plan, VetoCause, WhyNot
from talaia.model.observing.states import ObservationState
from talaia.wire import browser, frames
from talaia.wire.frames import CommandPhase, LeaseOp

from .messages import DEVICES
from .observing import make_group
from .world import DESCRIPTIONS, NOW, SESSIONLESS, holds

if TYPE_CHECKING:
    from .world import World

LISTENERS = ("guest", "operator", "driver", "neighbour", "keeper", "admin", "token")
PUBLIC = {"agv/base/open"}
SIGNALS = ("open", "shut", "words")
# Those with a detector.
WATCHED = ("open", "shut")
STREAM = "eye"
# So often a driving frame is said until one reaches the gateway.
PRESSES = 15


def hidden(about: str) -> str:
    """Give the word that stands for a device and for nothing else."""
    return f"hidden-{about.replace('/', '-')}"


def number(about: str, signal: str) -> float:
    """Give the number that stands for one channel and for no other."""
    return 1000.5 + 10 * DEVICES.index(about) + SIGNALS.index(signal)


def sees_channel(actor: str, about: str, signal: str) -> bool:
    """Tell, from the table written by hand, whether somebody may see a channel."""
    public = f"{about}/{signal}" in PUBLIC
    return holds(actor, "see" if public else "view", about)


def secrets_from(actor: str) -> set[bytes]:
    """List what must never reach somebody, as it would stand in a frame or an answer."""
    found = set()
    for about in DEVICES:
        if actor in SESSIONLESS or not holds(actor, "view", about):
            found.add(hidden(about).encode())
        for signal in ("open", "shut"):
            if actor in SESSIONLESS or not sees_channel(actor, about, signal):
                value = number(about, signal)
                found |= {struct.pack("<d", value), struct.pack(">d", value), str(value).encode()}
    return found


class Tape:
    """A connection that keeps every frame as it came."""

    def __init__(self, connection) -> None:
        """Listen in on ``connection``."""
        self.frames: list[bytes] = []
        self._connection = connection

    def __getattr__(self, name: str) -> object:
        return getattr(self._connection, name)

    async def __aiter__(self):
        async for frame in self._connection:
            self.frames.append(frame)
            yield frame


class Listener(NamedTuple):
    """Somebody's page, and all that came over its socket."""

    actor: str
    page: object
    frames: list[bytes]

    @property
    def messages(self) -> list[browser.ToBrowser]:
        return [browser.TO_BROWSER.decode(frame) for frame in self.frames]


async def listen(world: World, actor: str) -> Listener:
    """Open a page that keeps all it is sent, and ask for every channel there is."""
    tapes = []

    async def dial(*where: object, **more: object):
        tapes.append(Tape(await type(world.hub).dial(world.hub, *where, **more)))
        return tapes[-1]

    world.hub.dial = dial
    # By turns at the hub that leads, and at another one before it.
    page = await world.page(actor, at=next(world.doors))
    del world.hub.dial
    for at, site in enumerate(DESCRIPTIONS):
        channels = [
            f"{about.partition('/')[2]}/{signal}"
            for about in DEVICES
            for signal in SIGNALS
            if about.startswith(site)
        ]
        await page.say(browser.Subscribe(sub=at, site=site, channels=channels, every_ms=0))
    return Listener(actor, page, tapes[0].frames)


async def settle(listeners: list[Listener]) -> None:
    """Wait until everyone has been sent what was meant for them so far."""
    for each in listeners:
        await each.page.say(browser.Subscribe(sub=60_000, site="agv", channels=[]))
        await each.page.hear(browser.Subscribed, lambda answer: answer.sub == 60_000)


async def everything(world: World, listeners: list[Listener]) -> None:
    """Let all of it happen, on every device of every site."""
    acting = next(each.page for each in listeners if each.actor == "operator")
    for about in DEVICES:
        await _values(world, about)
        await _lease(world, acting, about)
        await _drive(world, acting, about)
        await _stop(world, acting, about)
        _stop_elsewhere(world, about)
        await _command(world, acting, about)
        await _event(world, about)
        await _interlock(world, acting, about)
        await _reach(world, acting, about)
        await _alarm(world, acting, about)
        await _sighting(world, acting, about)
        await _anomaly(world, acting, about)
        await _night(world, acting, about)
        await settle(listeners)
    await acting.say(browser.PagePing(n=1, at_ms=0.0))
    await acting.hear(browser.PagePong)
    await acting.say(browser.PageCommand(site="agv", device="base", command="none", id="none"))
    await acting.hear(browser.RequestError)
    await settle(listeners)
    for site in DESCRIPTIONS:
        # Gone, back, and with another description.
        await world.gateways[site].close()
        await acting.hear(
            browser.SiteUpdate, lambda news, at=site: news.site == at and not news.online
        )
        changed = DESCRIPTIONS[site].replace("Words", "Other words")
        await world.connect(site, changed)
        await acting.hear(browser.SiteUpdate, lambda news, at=site: news.site == at and news.online)
    for about in DEVICES:
        await _values(world, about)
    await _nearly_over(world, listeners)
    await settle(listeners)


async def _nearly_over(world: World, listeners: list[Listener]) -> None:
    """Let everyone's session be so old that they are told of its end."""
    age_us = round((world.hub.settings.life_s - 30.0) * 1e6)
    async with world.hub.hub.core.database.write() as connection:
        await connection.execute(update(sessions).values(created_us=sessions.c.created_us - age_us))
    for each in listeners:
        if each.actor != "token":
            await each.page.hear(browser.SessionUpdate)


async def _values(world: World, about: str) -> None:
    site, _, device = about.partition("/")
    gateway = world.gateways[site]
    await gateway.samples(
        (f"{device}/open", NOW, number(about, "open")),
        (f"{device}/shut", NOW, number(about, "shut")),
        (f"{device}/words", NOW, hidden(about)),
    )
    await gateway.hear(frames.Ack, lambda ack: ack.below == gateway.sequence)


async def _lease(world: World, acting, about: str) -> None:
    site, _, device = about.partition("/")
    gateway = world.gateways[site]
    await acting.say(browser.PageLease(site=site, device=device, op=LeaseOp.TAKE))
    ask = await gateway.hear(frames.LeaseRequest, lambda ask: ask.device == device)
    state = frames.LeaseState(
        device=device, session=ask.session, who=hidden(about), epoch=7, remains_ms=3000
    )
    await gateway.say(state)
    await acting.hear(browser.LeaseUpdate, lambda news: news.device == device and news.yours)
    await gateway.say(frames.ControlTick(tick=DEVICES.index(about)))
    await acting.hear(browser.TickUpdate, lambda news: news.tick == DEVICES.index(about))


async def _drive(world: World, acting, about: str) -> None:
    site, _, device = about.partition("/")
    gateway = world.gateways[site]
    for seq in range(1, PRESSES + 1):
        await acting.say(
            browser.PageDrive(
                site=site, device=device, epoch=7, seq=seq, tick=1, linear=0.5, angular=0.0
            )
        )
        # As a page does: while the disk stalls and no session can be checked, none passes.
        with contextlib.suppress(TimeoutError):
            async with asyncio.timeout(1.0):
                await gateway.hear(frames.DriveFrame, lambda drive: drive.device == device)
                break
    else:
        raise AssertionError("no driving frame reached the gateway")
    await gateway.say(
        frames.DriveState(device=device, linear=0.5, angular=0.0, cap=1.0, why=hidden(about))
    )
    await gateway.say(frames.TwinState(device=device, twin="twin", why=hidden(about)))


async def _stop(world: World, acting, about: str) -> None:
    site, _, device = about.partition("/")
    gateway = world.gateways[site]
    await acting.say(browser.PageStop(site=site, device=device, id=hidden(about)))
    ask = await gateway.hear(frames.StopRequest, lambda ask: ask.device == device)
    await gateway.say(frames.StopState(device=device, latched=True, who=ask.who, id=ask.id))
    await acting.say(browser.PageReset(site=site, device=device, epoch=7))
    ask = await gateway.hear(frames.ResetRequest, lambda ask: ask.device == device)
    await gateway.say(frames.ResetToken(device=device, session=ask.session, token=hidden(about)))
    await acting.hear(browser.ResetTokenUpdate, lambda key: key.device == device)
    await gateway.say(frames.StopState(device=device, latched=False, who=hidden(about)))


def _stop_elsewhere(world: World, about: str) -> None:
    """Tell how far a STOP got at a second gateway, which is not there: who hears it is the same."""
    site, _, device = about.partition("/")
    news = browser.HeldStopUpdate(site=site, device=device, id=hidden(about), held=1)
    world.hub.hub.core.browsers.broadcast_message(news)


async def _command(world: World, acting, about: str) -> None:
    site, _, device = about.partition("/")
    gateway = world.gateways[site]
    await acting.say(
        browser.PageCommand(site=site, device=device, command="turn", id=f"{about} turn")
    )
    ask = await gateway.hear(frames.CommandRequest, lambda ask: ask.device == device)
    for phase in (CommandPhase.ACCEPTED, CommandPhase.SUCCEEDED):
        await gateway.say(
            frames.CommandState(
                id=ask.id, device=device, command="turn", phase=phase, message=hidden(about)
            )
        )
    await acting.hear(
        browser.CommandUpdate,
        lambda news: news.device == device and news.phase is CommandPhase.SUCCEEDED,
    )


async def _interlock(world: World, acting, about: str) -> None:
    """Lock the site's interlock and override it; what it says is about this device."""
    site, _, _device = about.partition("/")
    said = {"why": hidden(about), "overridden_by": hidden(about), "reason": hidden(about)}
    state = frames.InterlockState(interlock="lock", locked=True, override_ms=5000, **said)
    await world.gateways[site].say(state)
    await acting.hear(browser.InterlockUpdate, lambda news: news.why == hidden(about))


async def _reach(world: World, acting, about: str) -> None:
    site, _, device = about.partition("/")
    gateway = world.gateways[site]
    await gateway.say(frames.DeviceState(device=device, reached=False, why=hidden(about)))
    await acting.hear(browser.DeviceUpdate, lambda news: news.why == hidden(about))
    await gateway.say(frames.DeviceState(device=device, reached=True))
    await acting.hear(browser.DeviceUpdate, lambda news: news.device == device and news.reached)


async def _alarm(_world: World, acting, about: str) -> None:
    """Hear of the alarm that the device's words have raised."""
    site, _, device = about.partition("/")
    await acting.hear(
        browser.AlarmUpdate,
        lambda news: (news.site, news.device, news.phase) == (site, device, "active"),
    )


async def _sighting(world: World, acting, about: str) -> None:
    """Let the device's camera see somebody come and go."""
    site, _, device = about.partition("/")
    for ended_us in (0, NOW + 1):
        await world.gateways[site].say(
            frames.SightingReport(
                stream=f"{device}/{STREAM}", label="person", many=1, confidence=0.9, began_us=NOW,
                ended_us=ended_us,
            )
        )  # fmt: skip
        await acting.hear(
            browser.SightingUpdate,
            lambda news, at=ended_us: (news.camera, news.ended_us) == (f"{device}/{STREAM}", at),
        )


async def _anomaly(_world: World, acting, about: str) -> None:
    """Hear of the anomalies that the device's numbers are."""
    site, _, device = about.partition("/")
    for signal in WATCHED:
        await acting.hear(
            browser.AnomalyUpdate,
            lambda news, at=f"{device}/{signal}": (news.site, news.address) == (site, at),
        )


async def _night(world: World, acting, about: str) -> None:
    """Let the night begin, be planned and observe something; what it says is about this device."""
    site, _, _device = about.partition("/")
    gateway = world.gateways[site]
    _, request = await make_group(world, site)
    await gateway.say(frames.NightState(phase=frames.NightPhase.CLOSED, why=hidden(about)))
    reason = WhyNot(request=request, cause=VetoCause.ROOF, sentence=hidden(about))
    plan = Plan(made_at=1.0, night_start=2.0, night_end=3.0)
    await gateway.say(frames.NightPlan(plan=plan, why_not=[reason]))
    await gateway.say(
        frames.ObservationUpdate(
            number=DEVICES.index(about), id=about, request=request, why=hidden(about),
            state=ObservationState.IN_PROGRESS, time=NOW / 1e6,
        )
    )  # fmt: skip
    await acting.hear(browser.NightUpdate, lambda news: news.why == hidden(about))
    await acting.hear(browser.NightPlanUpdate, lambda news: news.site == site)
    await acting.hear(browser.ObservingRequestUpdate, lambda news: news.request == request)


async def _event(world: World, about: str) -> None:
    site, _, device = about.partition("/")
    gateway = world.gateways[site]
    await gateway.say(frames.Event(kind="noise", device=device, message=hidden(about)))
