"""Figures of the hub and of sites as Prometheus metrics, by what an account may see. Pure.

Names and units follow Prometheus's conventions; what is stale is left out, so that Prometheus marks
the series as stale instead of drawing a line through old values.
"""

from __future__ import annotations

from fnmatch import fnmatchcase
from typing import TYPE_CHECKING, NamedTuple

from prometheus_client.core import (
    GaugeMetricFamily,
    InfoMetricFamily,
    Metric,
    StateSetMetricFamily,
)

from talaia.clock import SECOND
from talaia.hub.auth.permissions import ANY, Right, sees_device, sees_signal
from talaia.model.site import SignalType

if TYPE_CHECKING:
    from collections.abc import Callable, Iterable, Iterator, Sequence

    from talaia.hub.auth.permissions import Grants
    from talaia.hub.cluster.peers import HubNotice
    from talaia.hub.live.alarms.alarm_state import LiveAlarm
    from talaia.hub.live.sites import LiveSite
    from talaia.model.site import Channel, Signal

__all__ = ["HubFigures", "ScrapeRequest", "collect_metrics"]

_SIGNAL = ("site", "device", "signal", "part", "unit")


class HubFigures(NamedTuple):
    """What the hub knows of itself.

    Attributes:
        version: of Talaia.
        pages: that are connected now.
        clients: of other tools that are connected now, by protocol.
        hubs: those that are one with this one, and itself; empty: it is alone.
        files_up: whether files in a bucket can be read and written; None: they are in a folder.

    """

    version: str
    pages: int
    clients: dict[str, int]
    hubs: Sequence[HubNotice] = ()
    files_up: bool | None = None


class ScrapeRequest(NamedTuple):
    """What a scrape asks for.

    Attributes:
        site: the only site; empty for every one.
        signals: patterns of addresses (``base/*``, ``*/temperature*``) with the wildcards of
            ``fnmatch``; empty takes those on the first page (``primary``).

    """

    site: str = ""
    signals: Sequence[str] = ()

    def takes_signal(self, address: str, signal: Signal) -> bool:
        """Tell whether a signal is asked for."""
        if not self.signals:
            return signal.primary
        return any(fnmatchcase(address, pattern) for pattern in self.signals)


def collect_metrics(
    hub: HubFigures,
    sites: Iterable[LiveSite],
    *,
    grants: Grants,
    asked: ScrapeRequest,
    alarms_of: Callable[[str], Iterable[LiveAlarm]],
    now_ns: int,
) -> Iterator[Metric]:
    """Give all figures that an account may have; ``now_ns`` is monotonic.

    Of the hub itself: with the right ``metrics`` on every site. Of a site: with it there, and of
    its signals and alarms those that the account sees besides.
    """
    if grants.has_right(Right.METRICS, ANY):
        yield from _hub_metrics(hub)
    shown = [
        live
        for live in sites
        if asked.site in {"", live.name} and grants.has_right(Right.METRICS, live.name)
    ]
    yield from _gateway_metrics(shown)
    yield from _alarm_metrics(shown, grants, alarms_of)
    yield from _signal_metrics(shown, grants, asked, now_ns)


def _hub_metrics(hub: HubFigures) -> Iterator[Metric]:
    yield InfoMetricFamily("talaia_hub", "The hub's version", {"version": hub.version})
    yield GaugeMetricFamily("talaia_pages_connected", "Pages that are connected now", hub.pages)
    clients = GaugeMetricFamily(
        "talaia_clients_connected", "Clients of other tools, by protocol", labels=["protocol"]
    )
    for protocol, count in hub.clients.items():
        clients.add_metric([protocol], count)
    yield clients
    if hub.files_up is not None:
        said = "1 while the store of files can be read and written"
        yield GaugeMetricFamily("talaia_file_store_up", said, hub.files_up)
    if hub.hubs:
        yield from _cluster_metrics(hub.hubs)


def _cluster_metrics(hubs: Sequence[HubNotice]) -> Iterator[Metric]:
    leads = GaugeMetricFamily(
        "talaia_hub_leads", "1 for the hub that leads, 0 for one that waits", labels=["hub"]
    )
    gateways = GaugeMetricFamily(
        "talaia_hub_gateways", "Links of gateways that came in at a hub", labels=["hub"]
    )
    sockets = GaugeMetricFamily(
        "talaia_hub_sockets", "Other sockets that came in at a hub", labels=["hub"]
    )
    cores = GaugeMetricFamily("talaia_hub_cpu_cores", "Cores that a hub takes", labels=["hub"])
    memory = GaugeMetricFamily("talaia_hub_memory_bytes", "Memory of a hub", labels=["hub"])
    database = GaugeMetricFamily(
        "talaia_hub_database_seconds", "How long the database takes to answer", labels=["hub"]
    )
    for notice in hubs:
        leads.add_metric([notice.name], notice.leads)
        gateways.add_metric([notice.name], notice.gateways)
        sockets.add_metric([notice.name], notice.sockets)
        cores.add_metric([notice.name], notice.cpu)
        memory.add_metric([notice.name], notice.memory_bytes)
        database.add_metric([notice.name], notice.database_ms / 1000)
    yield from (leads, gateways, sockets, cores, memory, database)


def _gateway_metrics(sites: Sequence[LiveSite]) -> Iterator[Metric]:
    linked = GaugeMetricFamily(
        "talaia_gateway_linked", "1 while the site's gateway is connected", labels=["site"]
    )
    since = GaugeMetricFamily(
        "talaia_gateway_link_changed_timestamp_seconds",
        "When the gateway connected or was lost",
        labels=["site"],
    )
    loop = GaugeMetricFamily(
        "talaia_gateway_round_trip_seconds", "From hub to gateway and back", labels=["site"]
    )
    for live in sites:
        linked.add_metric([live.name], float(live.online))
        if live.presence.since_us:
            since.add_metric([live.name], live.presence.since_us / 1e6)
        # After a loss it is that of the last beat before, which says nothing of now.
        if live.online:
            loop.add_metric([live.name], live.presence.loop_ms / 1e3)
    yield from (linked, since, loop)


def _alarm_metrics(
    sites: Sequence[LiveSite], grants: Grants, alarms_of: Callable[[str], Iterable[LiveAlarm]]
) -> Iterator[Metric]:
    phases = StateSetMetricFamily(
        "talaia_alarm_phase", "How an alarm stands", labels=["site", "alarm", "severity"]
    )
    known = GaugeMetricFamily(
        "talaia_alarm_known", "0 while it cannot be judged", labels=["site", "alarm"]
    )
    for live in sites:
        for alarm in alarms_of(live.name):
            about = alarm.about
            # Of the whole site where it is about more than one device.
            if not grants.has_right(Right.VIEW, live.name, about.device or ANY):
                continue
            all_phases = type(alarm.state.phase)
            phases.add_metric(
                [live.name, about.alarm, about.severity.value],
                {phase.value: phase is alarm.state.phase for phase in all_phases},
            )
            known.add_metric([live.name, about.alarm], float(alarm.watch.known))
    yield from (phases, known)


def _signal_metrics(
    sites: Sequence[LiveSite], grants: Grants, asked: ScrapeRequest, now_ns: int
) -> Iterator[Metric]:
    values = GaugeMetricFamily(
        "talaia_signal_value", "Newest value, in the unit of its label", labels=_SIGNAL
    )
    states = StateSetMetricFamily(
        "talaia_signal_state", "Newest state", labels=["site", "device", "signal"]
    )
    ages = GaugeMetricFamily(
        "talaia_signal_age_seconds", "Age of the newest value, stale or not", labels=_SIGNAL[:4]
    )
    reached = GaugeMetricFamily(
        "talaia_device_reached",
        "0 while the gateway does not reach the device",
        labels=["site", "device"],
    )
    for live in sites:
        for device in live.description.devices:
            if live.online and sees_device(grants, live.description, device):
                reached.add_metric([live.name, device], float(device not in live.current.unreached))
        for at, channel, signal in _channels(live, grants, asked):
            arrived_ns = int(live.latest.arrived_ns[at])
            # Nothing was heard of it yet.
            if arrived_ns < 0:
                continue
            age_s = max(0.0, (now_ns - arrived_ns) / SECOND)
            place = [live.name, channel.device, channel.signal, channel.part]
            ages.add_metric(place, age_s)
            if signal.max_age and age_s > signal.max_age:
                continue
            value = float(live.latest.value[at])
            if signal.type is SignalType.STATE:
                states.add_metric(
                    place[:3], {word: value == number for number, word in enumerate(signal.states)}
                )
            else:
                values.add_metric([*place, signal.unit], value)
    yield from (values, states, ages, reached)


def _channels(
    live: LiveSite, grants: Grants, asked: ScrapeRequest
) -> Iterator[tuple[int, Channel, Signal]]:
    """Go through the numbers and states that are asked for and may be seen, with their places."""
    for at, channel in enumerate(live.channels):
        signal = live.description.devices[channel.device].signals[channel.signal]
        if (
            not channel.text
            and asked.takes_signal(f"{channel.device}/{channel.signal}", signal)
            and sees_signal(grants, live.description, channel.device, channel.signal)
        ):
            yield at, channel, signal
