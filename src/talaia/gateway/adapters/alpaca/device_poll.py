"""Asks one Alpaca device, again and again, how it is and for what the description reads of it.

Whatever does not answer, or answers with an error, is unknown at once: no value outlives the answer
that would have renewed it.
"""

from __future__ import annotations

import math
from typing import TYPE_CHECKING

from talaia.clock import SECOND
from talaia.gateway.adapters.alpaca.protocol import (
    NOT_CONNECTED,
    NOT_IMPLEMENTED,
    AlpacaRefused,
)
from talaia.gateway.adapters.http.fetching import FetchFailed, ServerNotReached
from talaia.gateway.adapters.json_signals import JsonText

if TYPE_CHECKING:
    from collections.abc import Callable, Mapping

    from talaia.clock import Clock
    from talaia.gateway.adapters.alpaca.server import AlpacaServer
    from talaia.gateway.adapters.json_signals import JsonSignals

__all__ = ["AGE_PROPERTY", "DevicePoll"]

AGE_PROPERTY = "timesincelastupdate"
# A device that does not connect to its hardware is told again after these; the last goes on.
_CONNECT_AGAIN_S = (0.0, 10.0, 60.0, 300.0)
# Setting up a device's hardware may take that long.
_CONNECT_S = 60.0
NOT_ASKED = "it has not been asked yet"


class DevicePoll:
    """One device. On the event loop.

    Attributes:
        device: ``telescope/0``.
        why: why it counts as not there; empty while it answers.
        connect: tell it to connect to its hardware when it says that it is not.

    """

    def __init__(
        self,
        device: str,
        ages: Mapping[str, float],
        *,
        aged: frozenset[str],
        signals: JsonSignals,
        clock: Clock,
        connect: bool,
        complain: Callable[[str, str], None],
    ) -> None:
        """Take what is asked.

        Args:
            device: see above.
            ages: by property (``telescope/0/slewing``): how old its value may be (s).
            aged: those whose own age is asked for, too.
            signals: of the connection; keys are properties.
            clock: the gateway's.
            connect: see above.
            complain: told once of each property that cannot be read, with the problem.

        """
        self.device, self.why, self.connect = device, NOT_ASKED, connect
        self._ages, self._aged = ages, aged
        self._signals, self._clock, self._complain = signals, clock, complain
        # Properties that the device says it has not: they are not asked for again.
        self._lacking: set[str] = set()
        # By property: the problem that was told last.
        self._told: dict[str, str] = {}
        self._tries = 0
        self._try_ns = 0  # When it may be told to connect again.

    def restart(self) -> None:
        """Begin with a server anew."""
        self.why, self._tries, self._try_ns = NOT_ASKED, 0, 0
        self._lacking.clear()

    def lose_all(self, why: str) -> None:
        """Make everything of the device unknown."""
        self.why = why
        now_us = self._clock.wall_ns() // 1000
        for key in self._ages:
            self._signals.lose_key(key, now_us)

    async def ask_once(self, server: AlpacaServer) -> None:
        """Ask for everything once.

        Raises:
            ServerNotReached: the whole server is away.

        """
        try:
            if await server.ask_property(f"{self.device}/connected") is not True:
                await self._ask_connect(server)
                return
            # From here on it answers, whatever single properties do.
            self.why, self._tries = "", 0
            for key in self._ages:
                await self._read_property(server, key)
        except ServerNotReached:
            raise
        except FetchFailed as error:
            # The rest of its properties would each cost the whole time-out.
            self.lose_all(f"it does not answer: {error}")
        except AlpacaRefused as error:
            self.lose_all(str(error))

    async def _ask_connect(self, server: AlpacaServer) -> None:
        self.lose_all("it is not connected to its hardware")
        now_ns = self._clock.monotonic_ns()
        if not self.connect or now_ns < self._try_ns:
            return
        again = _CONNECT_AGAIN_S[min(self._tries + 1, len(_CONNECT_AGAIN_S) - 1)]
        self._tries += 1
        self._try_ns = now_ns + round(again * SECOND)
        try:
            # Sent once; another goes only after the device has said anew that it is not connected.
            await server.put_method(f"{self.device}/connected", {"Connected": True}, _CONNECT_S)
        except AlpacaRefused as error:
            self.why = f"it does not connect to its hardware: {error}"

    async def _read_property(self, server: AlpacaServer, key: str) -> None:
        if key in self._lacking:
            return
        # Before it is asked: a value is at least as old as its question.
        mono_ns = self._clock.monotonic_ns()
        try:
            value = await server.ask_property(key)
            if key in self._aged:
                mono_ns -= await self._age_ns(server, key)
        except AlpacaRefused as error:
            if error.number == NOT_CONNECTED:
                raise
            if error.number == NOT_IMPLEMENTED:
                self._lacking.add(key)
            self._lose_property(key, str(error))
            return
        wall_us = self._clock.wall_ns() // 1000
        # -1 stands for unknown (side of pier) and for on the way (filter wheel).
        unknown = value == -1 and self._signals.holds_states(key)
        if unknown or value is None:
            self._signals.lose_key(key, wall_us)
        else:
            payload = JsonText(str(value), value, is_json=True)
            self._signals.read_parsed(key, payload, wall_us, mono_ns)
        self._told.pop(key, None)

    async def _age_ns(self, server: AlpacaServer, key: str) -> int:
        """Ask how old a weather station's value is.

        Raises:
            AlpacaRefused: it does not say, or it is older than it may be.

        """
        sensor = key.rpartition("/")[2]
        age = await server.ask_property(f"{self.device}/{AGE_PROPERTY}?SensorName={sensor}")
        known = isinstance(age, int | float) and not isinstance(age, bool) and math.isfinite(age)
        # ASCOM: negative while no value has come yet.
        if not isinstance(age, int | float) or not known or age < 0:
            raise AlpacaRefused(0, f"the age of its value is {age!r}")
        if age > self._ages[key]:
            raise AlpacaRefused(0, f"its value is {age:.0f} s old")
        return round(age * SECOND)

    def _lose_property(self, key: str, problem: str) -> None:
        self._signals.lose_key(key, self._clock.wall_ns() // 1000)
        if key not in self._told:
            self._complain(key, problem)
        self._told[key] = problem
