"""Topics that carry many sensors by name: CloudConnect's texts, and ROS's diagnostics. Pure."""

from __future__ import annotations

from collections.abc import Iterable
from typing import TYPE_CHECKING, NamedTuple

from talaia.gateway.adapters.cloudconnect import parse_metric
from talaia.gateway.errors import FieldError
from talaia.gateway.samples.field_paths import number_of
from talaia.model.connections.ros import DIAGNOSTICS

if TYPE_CHECKING:
    from collections.abc import Iterator

__all__ = ["NAMED_TYPES", "SensorReading", "names_in", "readings_in"]

_METRIC = "std_msgs/msg/String"
NAMED_TYPES = (_METRIC, DIAGNOSTICS)


class SensorReading(NamedTuple):
    """What one sensor says.

    Attributes:
        value: a number; of diagnostics the level, 0 to 3.
        text: words beside it; none of a kind that has no words.

    """

    name: str
    value: float
    text: str | None = None


def readings_in(message: object, type_name: str) -> Iterator[SensorReading]:
    """Give all that a message says of sensors.

    Raises:
        FieldError: it is no such message.

    """
    if type_name != DIAGNOSTICS:
        metric = parse_metric(str(getattr(message, "data", "")))
        yield SensorReading(metric.name, metric.magnitude)
        return
    statuses = getattr(message, "status", ())
    if not isinstance(statuses, Iterable):
        raise FieldError("status", "is no list")
    # Names are the robot's own, and one may stand there twice: the last one counts.
    for status in statuses:
        level = number_of(getattr(status, "level", None), "status.level")
        name, text = getattr(status, "name", ""), getattr(status, "message", "")
        yield SensorReading(str(name), level, str(text))


def names_in(message: object, type_name: str) -> Iterator[str]:
    """Give the names of the sensors in a message; see `readings_in`."""
    return (reading.name for reading in readings_in(message, type_name))
