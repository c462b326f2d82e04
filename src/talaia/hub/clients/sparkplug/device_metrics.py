"""One device in Sparkplug's words: its metrics with their aliases, and which of them changed."""

from __future__ import annotations

from typing import TYPE_CHECKING, NamedTuple

from talaia.hub.clients.mqtt.channel_reading import is_reached, read_channel, reading_mark
from talaia.wire.mqtt.payloads import ValueQuality
from talaia.wire.sparkplug.payloads import SparkplugMetric, SparkplugType

if TYPE_CHECKING:
    from collections.abc import Iterator

    from talaia.hub.clients.mqtt.publication import PublishedChannel, SitePublication
    from talaia.hub.live.sites import LiveSite
    from talaia.wire.sparkplug.payloads import ReadMetric

__all__ = ["STOP_METRIC", "ControlMetric", "DeviceMetrics"]

_QUALITY = {ValueQuality.GOOD: 192, ValueQuality.STALE: 500, ValueQuality.LOST: 0}
# Nothing was heard of it yet.
_UNKNOWN = 0
_CONTROL = "Device Control"
STOP_METRIC = f"{_CONTROL}/Stop"
_ANSWER = f"{_CONTROL}/Answer"


class ControlMetric(NamedTuple):
    """A metric that asks for something when it is written.

    Attributes:
        command: empty: STOP (software).
        kind: a text takes the command's arguments as JSON; a truth value asks when it is true.

    """

    command: str
    kind: SparkplugType


class DeviceMetrics:
    """A device of a site.

    Attributes:
        born: the broker has been told of its birth, and of no death since.

    """

    def __init__(
        self, live: LiveSite, device: str, publication: SitePublication, *, first_alias: int
    ) -> None:
        """Take the device's part of ``publication``; aliases count up from ``first_alias``."""
        self.born = False
        self._live = live
        self._device = device
        self._channels = [one for one in publication.channels if one.device == device]
        self._names = [_metric_name(live.channels[one.at].address) for one in self._channels]
        self._controls = dict(_controls_of(live, device, publication))
        self._first_alias = first_alias
        # By place: what was told last.
        self._marks: dict[int, tuple[int, ValueQuality]] = {}
        self._answer = ""
        self._answer_due = False

    @property
    def end_alias(self) -> int:
        """The first alias that is free after these."""
        return self._first_alias + len(self._channels) + 1

    @property
    def name(self) -> str:
        """The device's name at the broker."""
        return f"{self._live.name}.{self._device}"

    @property
    def is_reached(self) -> bool:
        """Whether the gateway is connected and reaches the device."""
        return is_reached(self._live, self._device)

    def describe_birth(self, now_ns: int, now_ms: int) -> list[SparkplugMetric]:
        """Give all metrics, with names, types and values."""
        self.born = True
        self._answer_due = False
        metrics = [
            self._metric(place, now_ns, now_ms)._replace(name=self._names[place])
            for place in range(len(self._channels))
        ]
        if self._controls:
            metrics.append(self._answer_metric(now_ms)._replace(name=_ANSWER))
        for name, control in self._controls.items():
            idle = "" if control.kind is SparkplugType.STRING else False
            metrics.append(SparkplugMetric(idle, control.kind, now_ms, name))
        return metrics

    def list_changes(self, now_ns: int, now_ms: int) -> list[SparkplugMetric]:
        """Give what is not as it was told last, by alias."""
        changed = [
            self._metric(place, now_ns, now_ms)
            for place, channel in enumerate(self._channels)
            if reading_mark(self._live, channel, now_ns) not in {None, self._marks.get(place)}
        ]
        if self._answer_due:
            self._answer_due = False
            changed.append(self._answer_metric(now_ms))
        return changed

    def set_answer(self, answer: str) -> None:
        """Have it told what became of a command."""
        self._answer, self._answer_due = answer, bool(self._controls)

    def find_control(self, metric: ReadMetric) -> ControlMetric | None:
        """Tell what a written metric asks for; None: it is none that can be written."""
        return self._controls.get(metric.name)

    def _metric(self, place: int, now_ns: int, now_ms: int) -> SparkplugMetric:
        channel, alias = self._channels[place], self._first_alias + 1 + place
        kind = _kind_of(channel)
        mark = reading_mark(self._live, channel, now_ns)
        if mark is None:
            return SparkplugMetric(
                None, kind, now_ms, alias=alias, unit=channel.unit, quality=_UNKNOWN
            )
        self._marks[place] = mark
        reading = read_channel(self._live, channel, mark[1])
        value = reading.value
        if kind is SparkplugType.STRING and not isinstance(value, str):
            # A state that has no word for it.
            value = f"{value:g}"
        return SparkplugMetric(
            value,
            kind,
            reading.time_us // 1000,
            alias=alias,
            unit=channel.unit,
            quality=_QUALITY[reading.quality],
        )

    def _answer_metric(self, now_ms: int) -> SparkplugMetric:
        return SparkplugMetric(self._answer, SparkplugType.STRING, now_ms, alias=self._first_alias)


def _kind_of(channel: PublishedChannel) -> SparkplugType:
    return SparkplugType.STRING if channel.text or channel.states else SparkplugType.DOUBLE


def _metric_name(address: str) -> str:
    """Name a channel below its device: parts of a position stand in a folder."""
    return address.split("/", 1)[1].replace(".", "/")


def _controls_of(
    live: LiveSite, device: str, publication: SitePublication
) -> Iterator[tuple[str, ControlMetric]]:
    for owner, command in sorted(publication.commands):
        if owner == device:
            has_arguments = live.description.devices[device].commands[command].arguments
            kind = SparkplugType.STRING if has_arguments else SparkplugType.BOOLEAN
            yield f"{_CONTROL}/{command}", ControlMetric(command, kind)
    if device in publication.stops:
        yield STOP_METRIC, ControlMetric("", SparkplugType.BOOLEAN)
