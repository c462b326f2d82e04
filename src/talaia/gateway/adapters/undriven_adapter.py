"""What adapters have in common that can drive nothing."""

from __future__ import annotations

from typing import TYPE_CHECKING

from talaia.gateway.ports import CommandOutcome
from talaia.wire.frames import CommandPhase

if TYPE_CHECKING:
    from collections.abc import Callable, Collection

    from talaia.gateway.adapters.json_signals import JsonSignals
    from talaia.gateway.ports import ChannelReading, SampleSink
    from talaia.gateway.velocity_demand import VelocityDemand
    from talaia.wire.frames import Scalar

__all__ = ["JsonAdapter", "UndrivenAdapter"]


class UndrivenAdapter:
    """The part of an `Adapter` that tells nobody to move: `check` refuses a drive here."""

    def drive(self, device: str, demand: VelocityDemand, key: str = "") -> None:
        """Tell nobody: nothing here is driven."""

    def stop(self, device: str, *, stopped: bool) -> None:
        """Tell nobody: what is not driven has no STOP of its own."""


class JsonAdapter(UndrivenAdapter):
    """What adapters have in common whose signals are fields of JSON: they read, and do nothing."""

    def __init__(self, signals: JsonSignals, samples: SampleSink, kind: str) -> None:
        """Give what ``signals`` read to ``samples``; ``kind`` is the connection's, for people."""
        self._signals, self._samples, self._kind = signals, samples, kind

    def watch(self, streams: Collection[str]) -> None:
        """Take no pictures: what comes is none."""

    def latest(self, address: str) -> ChannelReading | None:
        """See `ReadingSource.latest`."""
        return self._signals.latest.get(address)

    def act(
        self,
        device: str,
        command: str,
        fields: dict[str, Scalar],
        done: Callable[[CommandOutcome], None],
    ) -> Callable[[], None] | None:
        """Refuse: nothing is told to the other side."""
        said = f"a connection of kind {self._kind} has no commands"
        done(CommandOutcome(CommandPhase.REFUSED, said))
        return None

    def _publish_samples(self) -> None:
        columns = self._signals.take_columns()
        if columns is not None:
            self._samples.put_samples(columns)
