"""All interlocks and link-loss policies of a site, from the gateway's own copy of it. Pure.

Conditions are judged anew at each command and each driving frame, and ten times a second. A hub
is not needed for any of it.
"""

from __future__ import annotations

import time
from typing import TYPE_CHECKING

from talaia.clock import MS
from talaia.gateway.safety.condition_judge import ConditionJudge, signal_meaning
from talaia.gateway.safety.dome_following import FOLLOW_LABEL
from talaia.gateway.safety.enclosure_supervisor import EnclosureSupervisor
from talaia.gateway.safety.interlock_monitor import InterlockMonitor
from talaia.gateway.safety.link_losses import LinkLosses
from talaia.gateway.safety.outlet_guard import refuse_power_cut
from talaia.gateway.safety.pointing_limits import pointed_place, pointing_problem
from talaia.model.maps.site_map import zone_meaning

if TYPE_CHECKING:
    from collections.abc import Callable, Mapping

    from talaia.gateway.ports import ControlOutput, Field, ReadingSource
    from talaia.gateway.safety.interlock_monitor import SequenceStarter
    from talaia.model.interlocks.interlock import Interlock
    from talaia.model.site import Site
    from talaia.wire.frames import OverrideRequest

__all__ = ["Interlocks"]

# Ten times a second: a tenth of the second in which a roof has to begin to close.
LOOK_NS = 100 * MS


class Interlocks:
    """What may not be done now, and why; and what is done by itself.

    Attributes:
        conditions: what conditions and sensors say now.
        enclosures: what keeps roofs closed, and says what waits for them.

    """

    def __init__(
        self,
        *,
        site: Site,
        readings: ReadingSource,
        output: ControlOutput,
        run: SequenceStarter,
        now_ns: int,
        wall_ns: Callable[[], int] = time.time_ns,
    ) -> None:
        """Start locked and without a link.

        Args:
            site: the description.
            readings: the newest values, see `Site.safety_signals`.
            output: tells the hub, and writes down.
            run: begins sequences.
            now_ns: monotonic.
            wall_ns: UTC, for where the Sun stands.

        """
        self._site = site  # Replaced by `redescribe`.
        self._wall_ns = wall_ns  # UTC; only for the Sun and for robots' stamps.
        self._output = output  # Tells the hub and writes the record.
        self._run = run  # Begins sequences of commands by label.
        # Since when there is no hub, and what follows that; asked by conditions, too.
        self._losses = LinkLosses(site, now_ns)
        self.conditions = ConditionJudge(
            site=site, readings=readings, losses=self._losses, now_ns=now_ns, wall_ns=wall_ns
        )
        self.enclosures = EnclosureSupervisor(
            site=site, readings=readings, judge=self.conditions, output=output, run=run
        )
        # By name, in the order of the description: the first that locks gives the reason.
        self._monitors = {
            name: InterlockMonitor(
                name=name, site=site, judge=self.conditions, output=output, run=run, now_ns=now_ns
            )
            for name in site.interlocks
        }
        # When `evaluate_all` looked last: so long ago that the first one looks at once (monotonic).
        self._looked_ns = now_ns - LOOK_NS
        # When the last look came to its end: who supervises us goes by this, for a look that
        # fails half-way has judged nothing.
        self._judged_ns = now_ns

    def redescribe(self, site: Site, now_ns: int) -> None:
        """Judge by another description from here on.

        What is described as it was, with the signals it looks at, goes on with its dwell time and
        its override. All else begins locked, as after a restart.
        """
        before, self._site = self._site, site
        # Before the monitors, which ask it at once.
        self.conditions.redescribe(site, now_ns)
        former, self._monitors = self._monitors, {}
        for name, rule in site.interlocks.items():
            if before.interlocks.get(name) == rule and not _means_other(before, site, rule):
                self._monitors[name] = former[name]
                continue
            if name in former:
                monitor = former[name].for_description(site, now_ns)
            else:
                monitor = InterlockMonitor(
                    name=name,
                    site=site,
                    judge=self.conditions,
                    output=self._output,
                    run=self._run,
                    now_ns=now_ns,
                    why="it has just been described",
                )
            self._monitors[name] = monitor
            # Pages hold the former description's state until they are told.
            self._output.send(monitor.interlock_state(now_ns))
        self.enclosures.redescribe(site)
        self._losses.redescribe(site)

    def refusal_reason(
        self, device: str, what: str, now_ns: int, args: Mapping[str, Field] | None = None
    ) -> str:
        """Say why a command of a device (or ``drive``) may not be done now; empty when it may.

        ``args`` are the command's, by name: where a telescope is pointed is looked at as well.
        """
        # In the order of the description: the first that refuses is the one people are told.
        for monitor in self._monitors.values():
            rule = monitor.rule
            if f"{device}/{what}" in rule.refuse or f"{device}/*" in rule.refuse:
                # Not the last look's result: 100 ms are long when a roof begins to open.
                monitor.evaluate_conditions(now_ns)
                if monitor.locked:
                    return f"{rule.name}: {monitor.why}"
                # Nothing locks, but nothing was heard either: after a standstill of ours fresh
                # values come first.
                if unheard := self.conditions.unheard_problem(rule, now_ns):
                    return f"{rule.name}: {unheard}"
        return self._pointing_problem(device, what, args or {})

    def refuse_power_cut(
        self, device: str, command: str, now_ns: int, args: Mapping[str, Field]
    ) -> str:
        """Say why a command takes power that a safe state needs; empty when it takes none."""
        return refuse_power_cut(
            site=self._site,
            device=device,
            command=command,
            args=args,
            sighted=lambda sighting: self.conditions.sighting_holds(sighting, now_ns),
        )

    def closing_reason(self, enclosure: str) -> str:
        """Say why an enclosure has to be closed, as it was judged last; empty: it may be open."""
        return self._closing_reason(enclosure)

    def attend_devices(self, attended: Callable[[str], bool]) -> None:
        """Let a part of the gateway look after devices without a hub, while it says that it does.

        The link-loss policy of such a device waits; it is due at once when nobody attends any more.
        """
        self._losses.attended = attended

    def speed_share(self, device: str, now_ns: int) -> float:
        """Say at which share of its limits a device may be driven now, 0 to 1."""
        target, share = f"{device}/drive", 1.0
        for monitor in self._monitors.values():
            # Several may slow it: the least counts, and they are not multiplied.
            if target in monitor.rule.slow:
                monitor.evaluate_conditions(now_ns)
                if monitor.locked:
                    share = min(share, monitor.rule.slow[target])
        return share

    def begin_command(
        self, device: str, command: str, who: str, *, args: Mapping[str, Field], now_ns: int
    ) -> None:
        """Hear of each command that was accepted: of a roof's closing, or where a dome turns to."""
        self.enclosures.apply_command(device, command, who)
        place, pointing = self._site.place, self._site.devices[device].pointing
        names = pointing.commands.get(command) if pointing is not None else None
        if place is not None and names is not None:
            to = pointed_place(names, args, place, self._wall_ns())
            if not isinstance(to, str):
                self.enclosures.begin_slew(device, to.az, now_ns)

    def _pointing_problem(self, device: str, what: str, args: Mapping[str, Field]) -> str:
        described, place = self._site.devices.get(device), self._site.place
        if described is None or described.pointing is None or place is None:
            return ""
        # Commands that point nowhere are not looked at here.
        rule = described.pointing
        if (names := rule.commands.get(what)) is None:
            return ""
        wall_ns = self._wall_ns()
        return pointing_problem(rule=rule, names=names, args=args, place=place, wall_ns=wall_ns)

    def handle_override(self, ask: OverrideRequest, now_ns: int) -> None:
        """Override a condition for a time, or end that; who asked is told by the state."""
        monitor = self._monitors.get(ask.interlock)
        if monitor is None:
            refused = f"there is no interlock {ask.interlock!r}"
            self._output.record_event("override_refused", "", refused, ask.who, good=False)
            return
        monitor.handle_override(ask, now_ns)

    def link_up(self, now_ns: int) -> None:
        """Tell a new link how all stand; what was to follow its loss is called off."""
        self._losses.link_up()
        for monitor in self._monitors.values():
            self._output.send(monitor.interlock_state(now_ns))
        for name in self._site.enclosures:
            self.enclosures.send_state(name)

    def link_lost(self, now_ns: int) -> None:
        """Count from now."""
        # What this process slept through before the loss is not counted as time without a hub.
        self.conditions.mark_running(now_ns)
        self._losses.link_lost(now_ns)

    @property
    def judged_ns(self) -> int | None:
        """When all was last judged to the end (monotonic); none where there is nothing to judge."""
        return self._judged_ns if self._monitors or self._site.enclosures else None

    def due_ns(self) -> int | None:
        """Give when `evaluate_all` wants to be called next; none where nothing is watched."""
        if not self._monitors and not self._site.enclosures and self._losses.idle:
            return None
        return self._looked_ns + LOOK_NS

    def evaluate_all(self, now_ns: int) -> None:
        """Look at everything."""
        # `evaluate_all` is called whenever anything of driving is due, up to 25 times a second.
        if now_ns - self._looked_ns < LOOK_NS:
            return
        # Before the work: a look that fails half-way is not tried again at every turn of the loop.
        self._looked_ns = now_ns
        self.conditions.observe_values(now_ns)
        for monitor in self._monitors.values():
            monitor.evaluate_conditions(now_ns)
            monitor.send_if_conditions_changed(now_ns)
        # Before the roofs, for a lost link may want them closed.
        self._act_on_link_loss(now_ns)
        for name in self._site.enclosures:
            self._keep_closed(name, now_ns)
        self._judged_ns = now_ns

    def _act_on_link_loss(self, now_ns: int) -> None:
        """Begin what is due without a hub."""
        for device, policy in self._losses.due_policies(
            lambda since: self.conditions.age_ns(since, now_ns)
        ):
            away = f"no hub for {policy.after:g} s"
            self._output.record_event("link_loss_acted", device, away, "", good=False)
            if policy.run:
                self._run(f"link loss {device}", policy.run)

    def _keep_closed(self, name: str, now_ns: int) -> None:
        why = self._closing_reason(name)
        self.enclosures.keep_closed(name, why, now_ns)
        if why:
            # A dome that has to close turns after no telescope.
            return
        step = self.enclosures.following_step(name, now_ns)
        if step is None:
            return
        device, _, command = step.command.partition("/")
        # A dome follows only as far as a person might turn it; interlocks count for it as well.
        if not self.refusal_reason(device, command, now_ns):
            self._run(f"{FOLLOW_LABEL}{device}", (step,))

    def _closing_reason(self, name: str) -> str:
        """Say why an enclosure has to be closed; empty when it may be open."""
        for interlock in self._site.enclosures[name].unsafe:
            monitor = self._monitors.get(interlock)
            # The interlock may be missing while descriptions are exchanged.
            if monitor is not None and (why := monitor.closing_reason):
                return why
        return self._losses.closing_reason(name)


def _means_other(before: Site, after: Site, rule: Interlock) -> bool:
    """Tell whether what an interlock looks at is described as something else than before."""
    watched = {address for condition in rule.when for address in condition.signals()}
    sun = any(part.sun for condition in rule.when for part in (condition, *condition.all_of))
    changed = any(
        signal_meaning(before, address) != signal_meaning(after, address) for address in watched
    )
    zones = [zone for condition in rule.when for zone in condition.zones()]
    moved = any(zone_meaning(before, zone) != zone_meaning(after, zone) for zone in zones)
    return changed or moved or (sun and before.place != after.place)
