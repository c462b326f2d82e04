"""What a robot's gateway says, told to every page that may know, and written down.

Long, because each message of a gateway has its telling and its writing here, in one place.
"""

from __future__ import annotations

from typing import TYPE_CHECKING

from talaia.clock import MS, SECOND
from talaia.hub.auth.permissions import sees_signal
from talaia.hub.live.gateways.doubles.held_stops import HeldStops
from talaia.hub.live.gateways.gateway_log import GatewayLog
from talaia.hub.live.gateways.gateway_words import event_words, is_described, with_known_names
from talaia.hub.live.pages.interlock_news import interlock_news
from talaia.hub.store.audit import PART_OF_ANOMALY
from talaia.model.alarms.signal_groups import group_named
from talaia.wire import browser as page, frames
from talaia.wire.browser_messages.relay import relay_message
from talaia.wire.frames import CommandPhase

if TYPE_CHECKING:
    from collections.abc import Sequence

    from talaia.clock import Clock
    from talaia.hub.anomaly.episode_runner import EpisodeRunner
    from talaia.hub.live.alarms.alarm_engine import AlarmEngine
    from talaia.hub.live.pages.outbox import Frame
    from talaia.hub.live.pages.page_connections import Browser, Browsers
    from talaia.hub.live.sites import LiveSite, Sites
    from talaia.hub.ports import AnomalyReport
    from talaia.hub.store.audit import Audit
    from talaia.model.site import Site

__all__ = ["RobotEvents", "site_news"]

# One that is kept out dials again at least this often (µs), and then some.
RIVAL_US = 120_000_000
# Commands of a site by which somebody acts on a device at once, that are shown.
_MOST_ACTING = 500
# After one of these nothing more comes of a command.
_FINAL = frozenset(
    {
        CommandPhase.SUCCEEDED,
        CommandPhase.FAILED,
        CommandPhase.REFUSED,
        CommandPhase.CANCELLED,
        CommandPhase.UNKNOWN,
    }
)

RobotMessage = (
    frames.LeaseState
    | frames.ControlTick
    | frames.DriveState
    | frames.TwinState
    | frames.StopState
    | frames.ResetToken
    | frames.CommandState
    | frames.InterlockState
    | frames.EnclosureState
    | frames.RecorderState
    | frames.DeviceState
    | frames.Event
)


class RobotEvents:
    """Tells pages what is so, now and whenever it changes."""

    def __init__(
        self, *, sites: Sites, browsers: Browsers, alarms: AlarmEngine, audit: Audit, clock: Clock
    ) -> None:
        """Write down in ``audit`` what happened and how it ended."""
        # Only greets pages from here; what alarms come to they tell by themselves.
        self._alarms = alarms
        self._sites = sites
        self._browsers = browsers
        # Takes records into memory and writes them by itself: nothing here waits for the database.
        self._gateway_log = GatewayLog(audit, clock)
        # Of gateways that wait; what they say is no word of the site.
        self.held_stops = HeldStops(browsers, audit)
        # Monotonic for what runs out, wall for moments that people read.
        self._clock = clock

    def greet(self, browser: Browser) -> None:
        """Tell a page that has just come what is true now, of all it may see."""
        for live in self._sites:
            browser.send_message(site_news(live))
            for device in live.current.leases:
                browser.send_message(_lease_news(live, device, browser, self._clock.monotonic_ns()))
            # Kept over a lost link: a latched STOP is shown while the gateway is away too.
            for stop in live.retained.stops.values():
                browser.send_message(relay_message(page.StopUpdate, stop, live.name))
            self.held_stops.greet(live, browser)
            for drive in live.current.drives.values():
                browser.send_message(relay_message(page.DriveUpdate, drive, live.name))
            for twin in live.current.twins.values():
                browser.send_message(relay_message(page.TwinUpdate, twin, live.name))
            self.greet_interlocks(live, browser)
            for device in live.current.unreached:
                browser.send_message(_device_news(live, device))
            now_ns = self._clock.monotonic_ns()
            for state, heard_ns in live.current.acting.values():
                # A page that comes late counts on from when it was heard.
                later_s = (now_ns - heard_ns) / SECOND
                browser.send_message(_command_news(live, state, state.who, later_s))
        self._alarms.greet(browser)

    def publish_site(self, live: LiveSite) -> None:
        """Tell every page how a site stands."""
        self._browsers.broadcast_message(site_news(live))

    def publish_description(self, live: LiveSite) -> None:
        """Tell every page how a site stands that is described anew, and its interlocks."""
        self.publish_site(live)
        for browser in self._browsers:
            self.greet_interlocks(live, browser)

    def greet_interlocks(self, live: LiveSite, browser: Browser) -> None:
        """Tell a page how all interlocks of a site stand."""
        for name in live.current.interlocks:
            self._tell_interlock(live, name, browser)

    def publish_message(self, live: LiveSite, told: RobotMessage) -> None:
        """Pass on what a gateway says, to each page that may know.

        What it says of a device, an interlock or an enclosure that is not described is passed
        over: it may still speak of one that was taken out, and a hostile one makes names up.
        """
        if not is_described(live, told):
            return
        told = with_known_names(live, told)
        match told:
            case frames.LeaseState():
                self._handle_lease(live, told)
            case frames.ControlTick():
                news = relay_message(page.TickUpdate, told, live.name)
                # Only pages that hold a lease drive by it.
                for session in {state.session for state, _ in live.current.leases.values()}:
                    browser = self._browsers.get(session)
                    if browser is not None:
                        browser.send_message(news)
            case frames.DriveState():
                live.current.drives[told.device] = told
                self._browsers.broadcast_message(relay_message(page.DriveUpdate, told, live.name))
            case frames.TwinState():
                live.current.twins[told.device] = told
                self._browsers.broadcast_message(relay_message(page.TwinUpdate, told, live.name))
            case frames.StopState():
                self._handle_stop(live, told)
            case frames.ResetToken():
                # Only for the page that asked: nobody else is to release the STOP by its token.
                browser = self._browsers.get(told.session)
                if browser is not None:
                    browser.send_message(
                        page.ResetTokenUpdate(
                            site=live.name,
                            device=told.device,
                            token=told.token,
                            refused=told.refused,
                        )
                    )
            case frames.CommandState():
                self._command_state(live, told)
            case frames.InterlockState():
                live.current.interlocks[told.interlock] = (told, self._clock.monotonic_ns())
                # One by one: how much is said depends on the rights of each.
                for browser in self._browsers:
                    self._tell_interlock(live, told.interlock, browser)
            case frames.EnclosureState():
                # Kept for the alarms, which look at it; no page is told of it here.
                live.retained.enclosures[told.enclosure] = told.why
            case frames.RecorderState():
                live.retained.recorder = told
            case frames.DeviceState():
                self._device_state(live, told)
            case frames.Event():
                kind, message = event_words(told.kind, told.message)
                self.report_event(
                    live,
                    kind,
                    device=told.device,
                    message=message,
                    who=told.who,
                    good=told.good,
                    time_us=told.time_us,
                    source="gateway",
                )

    def report_event(
        self,
        live: LiveSite,
        kind: str,
        *,
        device: str = "",
        message: str = "",
        who: str = "",
        good: bool = True,
        time_us: int = 0,
        source: str = "hub",
    ) -> None:
        """Write an event down and tell it to all who may know; ``source``: whose word it is."""
        # Written down first: its moment stands in where the gateway gives none.
        entry = self._gateway_log.append_row(
            live, kind, who, device=device, message=message, good=good, source=source
        )
        self._browsers.broadcast_message(
            page.EventUpdate(
                site=live.name,
                kind=kind,
                device=device,
                message=message,
                who=who,
                time_us=time_us or entry.time_us,
                good=good,
            )
        )

    def report_anomaly(
        self, news: AnomalyReport, *, joined: bool = False, among: Sequence[str] = ()
    ) -> None:
        """Tell of an anomaly that began or ended.

        Args:
            news: what a detector says.
            joined: it is a part of an episode that has a line of its own.
            among: addresses of what else was unusual in the episode that ends with it.

        """
        live = self._sites.find_site(news.site)
        if live is None:
            return
        device, name = _place_of(live.description, news.channel)
        kind, time_us = "anomaly began", news.began_us
        if news.ended_us is not None:
            kind, time_us = "anomaly ended", news.ended_us
        # A kind of its own: the logbook has one line for an episode, and these when asked for.
        kind = kind.replace("anomaly", PART_OF_ANOMALY) if joined else kind
        others = ", ".join(_place_of(live.description, one)[1] for one in among)
        message = f"{name}: {news.why}" + (f"; with {others}" if others else "")
        good = news.ended_us is not None
        self.report_event(
            live, kind, device=device, message=message[:500], good=good, time_us=time_us
        )

    def report_detector(self, site: str, watched: EpisodeRunner) -> None:
        """Tell everyone who may see the signal how a detector stands; see `DetectorSink`."""
        live = self._sites.find_site(site)
        if live is None:
            return
        device, _, signal = watched.address.partition("/")
        news = _detector_news(site, device, watched)
        # Encoded once in each form, for all pages.
        encoded: dict[str, Frame] = {}
        for browser in self._browsers:
            if sees_signal(browser.who.grants, live.description, device, signal):
                browser.send_message(news, encoded)

    def rival_seen(self, live: LiveSite) -> None:
        """Show people that another gateway has this one's key, for as long as it goes on."""
        live.rivals.seen_us = self._clock.wall_ns() // 1000
        self._browsers.broadcast_message(site_news(live))

    def forget_rival(self, live: LiveSite) -> None:
        """Show it no more once the other gateway has not been there for a while."""
        # Wall time, as pages are shown; a clock that is set hides the rival sooner or later, no
        # more.
        if live.rivals.seen_us and self._clock.wall_ns() // 1000 - live.rivals.seen_us > RIVAL_US:
            live.rivals.seen_us = 0

    def link_lost(self, live: LiveSite) -> None:
        """Show all leases as free and every command under way as unknown."""
        # A copy: `_handle_lease` writes into it.
        for device in list(live.current.leases):
            self._handle_lease(live, frames.LeaseState(device=device))
        for pending in list(live.current.pending.values()):
            self._command_state(
                live,
                frames.CommandState(
                    id=pending.id,
                    # Not failed: it may well have been done.
                    device=pending.device,
                    command=pending.command,
                    phase=CommandPhase.UNKNOWN,
                    message="the connection was lost; look at the device to see what it did",
                    who=pending.who,
                ),
            )
        # The rest is not told: a page takes all of a site that is away as not known anyway.
        live.forget_current()

    def _device_state(self, live: LiveSite, state: frames.DeviceState) -> None:
        if state.reached:
            live.current.unreached.pop(state.device, None)
        else:
            # For how long is said, not since when: the gateway's wall clock may be wrong.
            since_us = self._clock.wall_ns() // 1000 - state.for_ms * 1000
            live.current.unreached[state.device] = (state.why, since_us)
        self._browsers.broadcast_message(_device_news(live, state.device))

    def _tell_interlock(self, live: LiveSite, name: str, browser: Browser) -> None:
        news = interlock_news(
            live,
            name,
            grants=browser.who.grants,
            mono_ns=self._clock.monotonic_ns(),
            wall_ns=self._clock.wall_ns(),
        )
        if news is not None:
            browser.send_message(news)

    def _handle_lease(self, live: LiveSite, state: frames.LeaseState) -> None:
        before = live.current.leases.get(state.device)
        now_ns = self._clock.monotonic_ns()
        live.current.leases[state.device] = (state, now_ns)
        # A refusal is the answer to one page; nobody else is told.
        if state.refused:
            browser = self._browsers.get(state.asked)
            if browser is not None:
                browser.send_message(_lease_news(live, state.device, browser, now_ns, answer=True))
        else:
            for browser in self._browsers:
                browser.send_message(_lease_news(live, state.device, browser, now_ns))
        # Renewals change neither the session nor its epoch, and are not written down.
        held = (before[0].session, before[0].epoch) if before else ("", 0)
        if held[0] != state.session or (state.session and held[1] != state.epoch):
            kind = "lease taken" if state.session else "lease freed"
            # A lease that is free names nobody: it was the former holder's.
            who = state.who or (before[0].who if before else "")
            self._gateway_log.append_row(
                live, kind, who, device=state.device, message=f"epoch {state.epoch or held[1]}"
            )

    def _handle_stop(self, live: LiveSite, state: frames.StopState) -> None:
        before = live.retained.stops.get(state.device)
        live.retained.stops[state.device] = state
        self._browsers.broadcast_message(relay_message(page.StopUpdate, state, live.name))
        said = (state.latched, state.confirmed)
        # A gateway repeats itself; only what is new is written down.
        if said != ((before.latched, before.confirmed) if before else (False, False)):
            what = "stop released"
            if state.latched:
                what = "stop confirmed by the robot" if state.confirmed else "stop latched"
            # The id of the press that this answers, as the row of the press has it.
            self._gateway_log.append_row(
                live, what, state.who, device=state.device, message=state.id
            )

    def _command_state(self, live: LiveSite, state: frames.CommandState) -> None:
        # Who asked is known by the hub, or nobody has asked it.
        asker = live.handed_down.asker_of(state.id)
        who = state.who if asker is None else asker
        final = state.phase in _FINAL
        if not live.handed_down.may_go_on(state.id, state.phase, final=final):
            # Replayed or out of order: it is over, for pages and in the name of who asked for it.
            if final and live.handed_down.contradicts_end(state.id, state.phase):
                self._write_end(live, state, f"gateway: {who}", own=True)
            return
        acting = live.current.acting
        if state.acting and not final:
            if state.id in acting or len(acting) < _MOST_ACTING:
                acting[state.id] = state, self._clock.monotonic_ns()
        else:
            live.current.acting.pop(state.id, None)
        self._browsers.broadcast_message(_command_news(live, state, who))
        if state.over:
            message = f"{state.command} {state.id} interrupts {state.over}"
            self._gateway_log.append_row(
                live, "command interrupts", who, device=state.device, message=message
            )
        if final:
            live.current.pending.pop(state.id, None)
            # One that the hub did not hand down is the site's own: a night's, a local client's.
            self._write_end(live, state, who, own=asker is None)

    def _write_end(
        self, live: LiveSite, state: frames.CommandState, who: str, *, own: bool
    ) -> None:
        self._gateway_log.append_row(
            live,
            f"command {'of the site ' if own else ''}{state.phase}",
            who,
            device=state.device,
            message=f"{state.command} {state.id} {state.message}".rstrip(),
            good=state.phase is CommandPhase.SUCCEEDED,
        )


def _detector_news(site: str, device: str, watched: EpisodeRunner) -> page.AnomalyUpdate:
    """Say how a detector stands, and of a group who made it so."""
    return page.AnomalyUpdate(
        site=site,
        device=device,
        address=watched.address,
        detector=watched.word,
        # Since when one is on is told apart from the newest, which may be over.
        on=watched.episodes.began_us >= 0,
        from_us=watched.from_us,
        to_us=watched.to_us,
        score=watched.score,
        why=watched.why,
        forgiven=watched.forgiven,
        confirmed=watched.confirmed,
        learning=watched.learning,
        mode=watched.mode,
        shares=[
            page.AnomalyShare(
                signal=watched.members[one.place], share=one.share, spreads=one.spreads
            )
            for one in watched.shares
        ],
    )


def _lease_news(
    live: LiveSite, device: str, browser: Browser, now_ns: int, *, answer: bool = False
) -> page.LeaseUpdate:
    state, heard_ns = live.current.leases[device]
    yours = state.session == browser.key
    # Spans are counted on by our own monotonic clock, so that no two clocks are compared.
    passed_ms = (now_ns - heard_ns) // MS
    answer_ms = max(0, state.rival_ms - passed_ms) if state.rival else 0
    return page.LeaseUpdate(
        site=live.name,
        device=device,
        holder=state.who if state.session else "",
        yours=yours,
        # Driving needs it: only the holder is told.
        epoch=state.epoch if yours else 0,
        remains_ms=max(0, state.remains_ms - passed_ms) if state.session else 0,
        rival=state.rival_who if answer_ms else "",
        asking=bool(answer_ms) and state.rival == browser.key,
        answer_ms=answer_ms,
        # A page that is greeted later has not asked.
        refused=state.refused if answer else "",
        forceable=answer and state.forceable,
    )


def _device_news(live: LiveSite, device: str) -> page.DeviceUpdate:
    why, since_us = live.current.unreached.get(device, ("", 0))
    reached = device not in live.current.unreached
    return page.DeviceUpdate(
        site=live.name, device=device, reached=reached, why=why, since_us=since_us
    )


def site_news(live: LiveSite) -> page.SiteUpdate:
    """Say whether a site is there."""
    return page.SiteUpdate(
        site=live.name,
        online=live.online,
        since_us=live.presence.since_us,
        catalogue=live.edition,
        loop_ms=live.presence.loop_ms,
        skew_ms=live.presence.skew_ms,
        why=live.presence.why,
        rival_us=live.rivals.seen_us,
    )


def _command_news(
    live: LiveSite, state: frames.CommandState, who: str, later_s: float = 0.0
) -> page.CommandUpdate:
    """Give what pages are told; ``later_s`` after it was heard."""
    acting_s = state.acting_s + later_s if state.acting else 0.0
    return relay_message(page.CommandUpdate, state, live.name, who=who, acting_s=acting_s)


def _place_of(site: Site, address: str) -> tuple[str, str]:
    """Give the device and the name of what a detector looks at.

    A group of several devices has none: its events are the site's.
    """
    device, _, signal = address.partition("/")
    if not device:
        group = group_named(site, signal)
        return ("", signal) if group is None else (group.device, group.name)
    # The description may have changed since the detector looked.
    described = site.devices.get(device)
    known = described.signals.get(signal) if described is not None else None
    return device, known.name if known is not None else signal
