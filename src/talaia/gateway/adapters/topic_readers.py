"""From decoded ROS messages to samples: one plan for each topic, compiled once.

What comes out goes straight into columns; there is no object for each sample. The same for every
way to reach ROS. Long, because plans, and what they read into, know each other's rows.
"""

from __future__ import annotations

import math
from typing import TYPE_CHECKING, NamedTuple, cast

import msgspec
import numpy as np

from talaia.gateway.adapters.named_sensors import readings_in
from talaia.gateway.errors import FieldError
from talaia.gateway.ports import ChannelReading
from talaia.gateway.samples.field_paths import compile_getter, reader_of, text_of
from talaia.gateway.samples.header_times import HeaderTimes
from talaia.gateway.samples.rate_limit import Sampler, rule_of
from talaia.gateway.samples.source_stamps import StampReader
from talaia.model.connection import RosSource, source_as
from talaia.model.connections.ros import DIAGNOSTICS
from talaia.model.site import SignalType, parts_of
from talaia.wire.columns import Columns

if TYPE_CHECKING:
    from collections.abc import Callable, Mapping, Sequence

    from talaia.gateway.adapters.connection_scope import ConnectionScope
    from talaia.gateway.adapters.unreadable_reports import UnreadableReports
    from talaia.model.site import Signal

__all__ = [
    "SampleBuffer",
    "TopicPlan",
    "file_in",
    "lifecycle_plans_of",
    "make_live_plans",
    "parameter_plans_of",
    "plans_of",
]


# Of one topic: names may be anything, and a robot that counts in them would fill the logbook.
MOST_ANNOUNCED = 50
# Fields of `UInt8MultiArray`; see `file_in`.
_DATA, _OFFSET = compile_getter("data"), compile_getter("layout.data_offset")


class SampleBuffer:
    """Columns that grow. Used by one thread."""

    def __init__(self) -> None:
        """Start empty."""
        # Three columns of one length; lists grow cheaper than arrays.
        self._channel: list[int] = []
        self._time: list[int] = []
        self._value: list[float] = []
        self._texts: dict[int, str] = {}  # By position in the columns.

    def add_number(self, channel: int, time_us: int, value: float) -> None:
        """Append a number."""
        self._channel.append(channel)
        self._time.append(time_us)
        self._value.append(value)

    def add_text(self, channel: int, time_us: int, text: str) -> None:
        """Append a text."""
        self._texts[len(self._channel)] = text
        self.add_number(channel, time_us, math.nan)

    def take_columns(self) -> Columns | None:
        """Give what was gathered and start anew; none if that is nothing."""
        if not self._channel:
            return None
        columns = Columns(
            np.array(self._channel, np.uint16),
            np.array(self._time, np.int64),
            np.array(self._value, np.float64),
            self._texts,
        )
        self._channel, self._time, self._value, self._texts = [], [], [], {}
        return columns


class _Row(NamedTuple):
    """One signal of a topic: where its numbers go and how they are read and thinned out."""

    address: str  # Of the signal.
    channel: int  # Of its first value; the others follow.
    # None for texts, and for what is found by name.
    read: Callable[[object], tuple[float, ...]] | None
    text: Callable[[object], object] | None  # Of text signals only.
    sampler: Sampler | None  # None where every value is kept.
    tapped: bool  # Its newest reading is kept for interlocks.
    scale: float  # For what is found by name; `read` has it in it.
    signal: Signal
    stamp: StampReader | None = None  # Where the value's own stamp is read; keeps how it went on.


class TopicPlan:
    """What is wanted of one topic.

    Attributes:
        latest: newest readings of tapped channels, before any thinning; read by other threads.

    """

    def __init__(
        self,
        *,
        topic: str,
        type_name: str,
        rows: list[_Row],
        delays: Sequence[_Row] = (),
        by_name: Mapping[str, list[_Row]],
        latest: dict[str, ChannelReading],
        complain: Callable[[str, str], None],
        announce: Callable[[str, str, str], None] | None = None,
        header_times: HeaderTimes | None = None,
    ) -> None:
        """Take the rows by field and those by the name of a sensor.

        Args:
            topic: the ROS topic.
            type_name: its type.
            rows: signals read from a field.
            delays: signals that tell by how much messages come after their stamps.
            by_name: signals of a topic that carries many sensors, see `named_sensors`.
            latest: where tapped readings go.
            complain: told once for each address that cannot be read, with the problem.
            announce: told once of each sensor of such a topic that no signal is of: device, topic
                and name.
            header_times: judges the stamps that samples have the time of; none where samples
                have the time of arrival.

        """
        self.topic = topic
        self.type_name = type_name
        self._rows = rows  # In the description's order.
        self._delays = delays
        self._by_name = by_name  # By the name of a sensor.
        self._latest = latest  # Shared by all plans of the adapter.
        self._complain = complain
        self._announce = announce
        self._announced: set[str] = set()  # Names of sensors, at most `MOST_ANNOUNCED`.
        self._bad: set[str] = set()  # Addresses (and the topic) that were told as unreadable.
        self._header_times = header_times
        samplers = self._all_rows()
        # Those that can hold a value back.
        self._thinned = [row for row in samplers if row.sampler is not None]

    @property
    def thins(self) -> bool:
        """Whether it may hold values back: only then `take_due` has something to do."""
        return bool(self._thinned)

    @property
    def channel(self) -> int:
        """The number of the first signal's first channel."""
        return self._all_rows()[0].channel

    @property
    def states(self) -> tuple[str, ...]:
        """The states of the first signal; none where it is no state."""
        return self._all_rows()[0].signal.states

    def _all_rows(self) -> list[_Row]:
        named = (row for rows in self._by_name.values() for row in rows)
        return [*self._rows, *self._delays, *named]

    def take_over(self, before: TopicPlan) -> None:
        """Go on where another plan of the topic stops: held-back values are not lost."""
        # By number, which a signal keeps under another address; see `ChannelNumbering`.
        samplers = {row.channel: row.sampler for row in before._all_rows()}

        stamped = {row.address: row for row in before._all_rows()}

        def mended(row: _Row) -> _Row:
            was = samplers.get(row.channel)
            known = stamped.get(row.address)
            # How a stamp went on is lost only with another source: else safety would wait for it
            # again.
            if known is not None and known.signal.source == row.signal.source and known.stamp:
                row = row._replace(stamp=known.stamp)
            if was is None or row.sampler is None or was.rule != row.sampler.rule:
                return row
            return row._replace(sampler=was)

        self._rows = [mended(row) for row in self._rows]
        self._delays = [mended(row) for row in self._delays]
        self._by_name = {name: [mended(row) for row in of] for name, of in self._by_name.items()}
        rows = self._all_rows()
        self._thinned = [row for row in rows if row.sampler is not None]
        self._announced = before._announced
        same = {row.address: row.signal for row in before._all_rows()}
        # What was told of a signal that is described as before is not told again.
        self._bad = {row.address for row in rows if same.get(row.address) == row.signal}
        self._bad = (self._bad | {self.topic}) & before._bad
        self._header_times = before._header_times

    def read_message(self, message: object, time_us: int, mono_ns: int, into: SampleBuffer) -> None:
        """Read one message into ``into``. What cannot be read is told once.

        Args:
            message: decoded.
            time_us: when it came, by the wall clock.
            mono_ns: when it came, by the monotonic clock.
            into: takes samples.

        """
        stamps = self._header_times
        if stamps is not None and type(message) is not stamps.headless:
            time_us = stamps.time_of(message, time_us)
        for row in self._rows:
            try:
                if row.text is not None:
                    into.add_text(row.channel, time_us, text_of(row.text(message)))
                    continue
                assert row.read is not None  # noqa: S101 - a row has one of the two
                values = row.read(message)
                # Before the sampler: interlocks see every reading.
                if row.tapped:
                    numbers = values if len(values) > 1 else ()
                    self._tap(row, message, values[0], mono_ns, numbers=numbers)
                    if numbers:
                        self._tap_parts(row, values, mono_ns)
            except FieldError as error:
                self._report_unreadable(row.address, error)
                # Only this signal: the others of the message are read all the same.
                continue
            # As `_add` does, without a call for what is by far the most common.
            if row.sampler is None and len(values) == 1:
                into.add_number(row.channel, time_us, values[0])
            else:
                self._add(row, values, time_us, into)
        # Imported recordings have one time alone.
        if stamps is not None:
            late_s = stamps.lag_us / 1e6
            for row in self._delays:
                if row.tapped:
                    self._tap(row, message, late_s, mono_ns)
                self._add(row, (late_s,), time_us, into)
        if self._by_name:
            self._read_named(message, time_us, mono_ns, into)

    def _read_named(self, message: object, time_us: int, mono_ns: int, into: SampleBuffer) -> None:
        try:
            for reading in readings_in(message, self.type_name):
                rows = self._by_name.get(reading.name)
                if rows is None:
                    self._announce_sensor(reading.name)
                    continue
                for row in rows:
                    if row.signal.type is SignalType.TEXT and reading.text is not None:
                        into.add_text(row.channel, time_us, text_of(reading.text))
                        continue
                    value = reading.value * row.scale
                    if row.tapped:
                        self._tap(row, message, value, mono_ns)
                    self._add(row, (value,), time_us, into)
        except FieldError as error:
            self._report_unreadable(self.topic, error)

    def _announce_sensor(self, name: str) -> None:
        # Of diagnostics people choose some on purpose: nobody waits for the others.
        if self._announce is None or self.type_name == DIAGNOSTICS:
            return
        if name not in self._announced and len(self._announced) < MOST_ANNOUNCED:
            self._announced.add(name)
            row = next(row for rows in self._by_name.values() for row in rows)
            self._announce(row.address.split("/", 1)[0], self.topic, name)

    def _report_unreadable(self, address: str, error: FieldError) -> None:
        if address not in self._bad:
            self._bad.add(address)
            self._complain(address, f"{self.topic}: {error}")

    def _tap(
        self,
        row: _Row,
        message: object,
        value: float,
        mono_ns: int,
        *,
        numbers: tuple[float, ...] = (),
    ) -> None:
        if row.stamp is None:
            # One assignment of one tuple: other threads see the old reading or the new.
            self._latest[row.address] = ChannelReading(value, mono_ns, numbers=numbers)
            return
        stamp_ns, advanced_ns = row.stamp.read_stamp(message, mono_ns)
        # None: no stamp has advanced yet, so nothing proves that the value is of now.
        if advanced_ns is not None:
            self._latest[row.address] = ChannelReading(
                value, advanced_ns, stamp_ns, mono_ns, numbers
            )

    def _tap_parts(self, row: _Row, values: tuple[float, ...], mono_ns: int) -> None:
        # Each by its own name: of a position the first alone would say little.
        for part, value in zip(parts_of(row.signal), values, strict=True):
            self._latest[f"{row.address}.{part}"] = ChannelReading(value, mono_ns)

    def _add(self, row: _Row, values: tuple[float, ...], time_us: int, into: SampleBuffer) -> None:
        if row.sampler is None or row.sampler.accept_sample(time_us, values):
            for part, value in enumerate(values):
                into.add_number(row.channel + part, time_us, value)

    def take_due(self, time_us: int, into: SampleBuffer) -> bool:
        """Let held-back values out whose turn has come; tell whether any still waits.

        ``time_us`` is now, by the wall clock.
        """
        waiting = False
        if self._header_times is not None:
            # By the clock of the messages' stamps, as their samples are.
            time_us -= self._header_times.lag_us
        for row in self._thinned:
            sampler = row.sampler
            if sampler is None or not sampler.holding:
                continue
            values = sampler.due_values(time_us)
            if values is None:
                waiting = True
                continue
            for part, value in enumerate(values):
                into.add_number(row.channel + part, time_us, value)
        return waiting

    def take_past(self, time_us: int, into: SampleBuffer) -> None:
        """Let out what was held back and whose turn came before ``time_us``, each at its turn.

        For messages that are read from a file, where time is what they say it is.
        """
        for row in self._thinned:
            sampler = row.sampler
            if sampler is None or not sampler.holding or sampler.turn_us >= time_us:
                continue
            # Read before `due`, which begins the next interval.
            turn_us = sampler.turn_us
            for part, value in enumerate(sampler.due_values(turn_us) or ()):
                into.add_number(row.channel + part, turn_us, value)


def file_in(message: object) -> bytes:
    """Give the bytes of a decoded ``std_msgs/msg/UInt8MultiArray``.

    Raises:
        FieldError: it has none.

    """
    data, offset = cast("bytes", _DATA(message)), cast("int", _OFFSET(message))
    try:
        # The message says where its data begin: what is in front is padding.
        return bytes(memoryview(data)[offset:])
    except (TypeError, ValueError) as error:
        raise FieldError("data", f"it is not a file: {error}") from error


def plans_of(
    scope: ConnectionScope,
    latest: dict[str, ChannelReading],
    complain: Callable[[str, str], None],
    *,
    announce: Callable[[str, str, str], None] | None = None,
    header_times: Callable[[], HeaderTimes] | None = None,
) -> list[TopicPlan]:
    """Make the plans of a scope; signals of one topic and type share one.

    See `TopicPlan` for the rest.
    """
    rows: dict[tuple[str, str], list[_Row]] = {}
    names: dict[tuple[str, str], dict[str, list[_Row]]] = {}
    delays: dict[tuple[str, str], list[_Row]] = {}
    for device_id, device in scope.devices.items():
        for signal_id, signal in device.signals.items():
            source = source_as(signal.source, RosSource)
            if not source.topic:
                continue
            address = f"{device_id}/{signal_id}"
            key = (source.topic, source.type)
            row = _plan_row(
                address, scope.channel[address], signal, tapped=address in scope.guarded
            )
            # Both, so that a topic with named signals alone has a plan as well.
            rows.setdefault(key, [])
            names.setdefault(key, {})
            if source.delay:
                delays.setdefault(key, []).append(row)
            elif source.name:
                names[key].setdefault(source.name, []).append(row)
            else:
                rows[key].append(row)
    return [
        TopicPlan(
            topic=topic,
            type_name=type_name,
            rows=read,
            delays=delays.get((topic, type_name), ()),
            by_name=names[topic, type_name],
            latest=latest,
            complain=complain,
            announce=announce,
            header_times=None if header_times is None else header_times(),
        )
        for (topic, type_name), read in rows.items()
    ]


def make_live_plans(
    scope: ConnectionScope,
    latest: dict[str, ChannelReading],
    reports: UnreadableReports,
    shift_us: Callable[[], int | None] | None = None,
) -> list[TopicPlan]:
    """Make the plans of a robot that is heard now: timed by its stamps, its news reported.

    See `HeaderTimes` for ``shift_us``.
    """
    return plans_of(
        scope,
        latest,
        reports.report_unreadable,
        announce=reports.report_new_sensor,
        header_times=lambda: HeaderTimes(shift_us),
    )


def parameter_plans_of(
    scope: ConnectionScope, latest: dict[str, ChannelReading], complain: Callable[[str, str], None]
) -> list[TopicPlan]:
    """Make a plan for each signal that is a parameter; its message has the value as ``data``."""
    return _node_plans_of(scope, latest, complain, lambda source: source.parameter)


def lifecycle_plans_of(
    scope: ConnectionScope, latest: dict[str, ChannelReading], complain: Callable[[str, str], None]
) -> list[TopicPlan]:
    """Make a plan for each signal that is a node's state; its message has it as ``data``."""
    return _node_plans_of(scope, latest, complain, lambda source: source.lifecycle)


def _node_plans_of(
    scope: ConnectionScope,
    latest: dict[str, ChannelReading],
    complain: Callable[[str, str], None],
    name_in: Callable[[RosSource], str],
) -> list[TopicPlan]:
    plans = []
    for device_id, device in scope.devices.items():
        for signal_id, signal in device.signals.items():
            name = name_in(source_as(signal.source, RosSource))
            if not name:
                continue
            address = f"{device_id}/{signal_id}"
            # What a node answers holds nothing but the value.
            of_data = msgspec.structs.replace(signal, source=RosSource(field="data"))
            tapped = address in scope.guarded
            row = _plan_row(address, scope.channel[address], of_data, tapped=tapped)
            plans.append(
                TopicPlan(
                    topic=name,
                    type_name="",
                    rows=[row],
                    by_name={},
                    latest=latest,
                    complain=complain,
                )
            )
    return plans


def _plan_row(address: str, channel: int, signal: Signal, *, tapped: bool) -> _Row:
    rule = rule_of(signal)
    sampler = None if rule is None else Sampler(rule)
    source, stamp = source_as(signal.source, RosSource), None
    # What is no field is found while a message is read.
    if source.name or source.delay:
        texts = signal.type is SignalType.TEXT
        return _Row(
            address, channel, None, None, None if texts else sampler, tapped, signal.scale, signal
        )
    if signal.type is SignalType.TEXT:
        return _Row(address, channel, None, compile_getter(source.field), None, tapped, 1.0, signal)
    if tapped and source.stamp:
        stamp = StampReader(compile_getter(source.stamp), source)
    return _Row(address, channel, reader_of(signal), None, sampler, tapped, 1.0, signal, stamp)
