"""What every simulated server has: topics, services, faults and power, whatever carries them.

A server says which topics it publishes, which services it offers, and what it does when it is
asked. The shells (`ros2_shell`, `ros1_shell`) bring that to the robot's network.
"""

from __future__ import annotations

from typing import TYPE_CHECKING, Any, NamedTuple

from talaia.sim.observatory.models.ticket import Ticket

if TYPE_CHECKING:
    from collections.abc import Callable, Mapping

__all__ = ["Ask", "ImageFrame", "Server", "Stamped", "Value"]


class Stamped(NamedTuple):
    """A temperature (°C) with the time at which it was measured (s, UTC)."""

    value: float
    unix_s: float


# A bool goes as Bool, an int as UInt8, a float as Float64, a str as String, what has a time of its
# own as sensor_msgs/Temperature.
Value = bool | int | float | str | Stamped


class Ask(NamedTuple):
    """A request with arguments: their names with an example of each type, and who does it."""

    arguments: dict[str, Value]
    act: Callable[..., Ticket]


class ImageFrame(NamedTuple):
    """A picture for a topic.

    Attributes:
        encoding: as `sensor_msgs/Image` names it.
        step: bytes of a row.
        file: the whole file, where there is one.

    """

    width: int
    height: int
    encoding: str
    step: int
    data: bytes
    name: str = ""
    file: bytes = b""


class Server:
    """What the shells ask of a server.

    Attributes:
        triggers: services without arguments.
        switches: services with one truth.
        asks: services with named arguments.
        hears: topics of other servers, absolute, with what is done with their values.
        pictures: it has a topic for them.
        hanging: it neither answers nor publishes, as a process that is stuck.
        own_acts: what it has begun by itself, for the ledger.
        outlet: of the power distribution unit, counted from 1, that it hangs on; 0 for none.
        powered: it has power. Without it publishes nothing, moves nothing and refuses all.

    """

    name = ""
    outlet = 0
    pictures = False

    def __init__(self) -> None:
        """Offer nothing yet."""
        self.triggers: dict[str, Callable[[], Ticket]] = {}
        self.switches: dict[str, Callable[[bool], Ticket]] = {}
        self.asks: dict[str, Ask] = {}
        self.hears: dict[str, tuple[type, Callable[[Any], None]]] = {}
        self.hanging = False
        self.own_acts: list[tuple[str, Ticket]] = []
        self.powered = True
        if self.outlet:
            # The outlet says by a topic whether it gives power.
            self.hears[f"/pdu/on{self.outlet}"] = (bool, self.set_power)

    @property
    def silent(self) -> bool:
        """Tell whether nothing is published."""
        return self.hanging or not self.powered

    def set_power(self, on: bool) -> None:  # noqa: FBT001 - a topic's value
        """Take power, or lose it: what moved stands, and nothing goes on when power is back."""
        if self.powered and not on:
            self.lose_power()
        self.powered = on

    def lose_power(self) -> None:
        """End what is under way, as a controller does that goes dark."""

    def pass_time(self, seconds: float, unix_s: float) -> None:
        """Let time pass; nothing moves without power."""
        if self.powered:
            self.step(seconds, unix_s)

    def without_power(self) -> Ticket | None:
        """Give the answer to whatever is asked while there is no power; none while there is."""
        if self.powered:
            return None
        return Ticket.refused(f"the {self.name} does not answer; it has no power")

    @property
    def truth(self) -> str:
        """Give how its hardware really stands, for the ledger; empty when nobody wants to know."""
        return ""

    def topic_values(self) -> Mapping[str, Value]:
        """Give what is published now, by the topic's name below the server's."""
        return {}

    def take_frame(self, *, watched: bool) -> ImageFrame | None:
        """Give a picture that nobody was given yet; ``watched`` tells whether anybody looks."""
        del watched
        return None

    def step(self, seconds: float, unix_s: float) -> None:
        """Let time pass."""

    def inject_fault(self, word: str) -> str:
        """Bring a fault about, or end all with ``ok``; give what is wrong with the word."""
        if word == "hang":
            self.hanging = True
            return ""
        if word == "ok":
            self.hanging = False
            return ""
        return f"{self.name}: there is no fault {word!r}"
