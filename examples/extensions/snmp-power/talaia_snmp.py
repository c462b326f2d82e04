"""An adapter for power switches that speak SNMP, such as APC's AP7920.

Outlets are read and switched by sPDUOutletCtl of the PowerNet-MIB; any other number or text of the
agent is read by its object identifier.
"""

from __future__ import annotations

import asyncio
import re
from typing import TYPE_CHECKING, Literal

from puresnmp import V1, V2C, Client, PyWrapper
from puresnmp.exc import SnmpError, Timeout
from x690.types import Integer

from talaia.extend.adapter import (
    AdapterExtension,
    CommandRefused,
    ConnectionLost,
    ExecutionFailed,
    ExtensionKeys,
)

if TYPE_CHECKING:
    from pathlib import Path

    from talaia.extend.adapter import AdapterHost, ExtensionCommand

# sPDUOutletCtl.N: read, it is the outlet's state; written, it is what the outlet is to do.
OUTLET = "1.3.6.1.4.1.318.1.1.12.3.3.1.1.4"
STATES = {1: "on", 2: "off", 4: "unknown"}
ORDERS = {"on": 1, "off": 2, "reboot": 3}
# An agent of this size answers a packet of so many questions.
AT_ONCE = 16


class SnmpConnection(ExtensionKeys, frozen=True, kw_only=True):
    """How the agent is reached.

    Attributes:
        host: its name or address.
        port: its UDP port.
        version: of SNMP; the AP7920 knows 1.
        community_file: a file that holds the community for reading; public where it is left out.
        write_file: a file that holds the community for switching; without it nothing is switched.
        poll: the agent is asked so often (s).
        timeout: without an answer for so long it is not reached (s).

    """

    host: str
    port: int = 161
    version: Literal["1", "2c"] = "1"
    community_file: str = ""
    write_file: str = ""
    poll: float = 2.0
    timeout: int = 2

    def __post_init__(self) -> None:
        """Refuse what makes no sense."""
        if not (1 <= self.port <= 65_535 and self.poll > 0 and self.timeout >= 1):
            raise ValueError("expected a port from 1 to 65535, poll above 0 and timeout from 1")


class SnmpSource(ExtensionKeys, frozen=True, kw_only=True):
    """Where a signal comes from.

    Attributes:
        outlet: an outlet of the switch, by its number.
        oid: or an object identifier: 1.3.6.1.4.1.318.1.1.12.2.3.1.1.2.1.

    """

    outlet: int = 0
    oid: str = ""

    def __post_init__(self) -> None:
        """Refuse what names nothing."""
        if bool(self.outlet) == bool(self.oid) or self.outlet < 0:
            raise ValueError("expected either outlet or oid")
        if self.oid and not re.fullmatch(r"\d+(\.\d+)+", self.oid):
            raise ValueError("oid: expected numbers and points, as 1.3.6.1.2.1.1.3.0")

    @property
    def question(self) -> str:
        """The object identifier that is asked for."""
        return self.oid or f"{OUTLET}.{self.outlet}"


class SnmpCommand(ExtensionKeys, frozen=True, kw_only=True):
    """What is switched.

    Attributes:
        target: outlet; there is nothing else.
        outlet: its number.
        state: on, off or reboot.

    """

    target: Literal["outlet"]
    outlet: int
    state: Literal["on", "off", "reboot"]


class Snmp:
    """Asks an agent again and again, and switches its outlets."""

    def __init__(self, keys: SnmpConnection, host: AdapterHost) -> None:
        """Read the communities; nothing is asked yet."""
        self._keys, self._host = keys, host
        self._reading = self._client(_word_in(host.folder, keys.community_file) or "public")
        write = _word_in(host.folder, keys.write_file)
        self._writing = self._client(write) if write else None

    async def run(self) -> None:
        """Ask for every signal, and publish what is answered."""
        wanted = self._host.signals
        while True:
            for begin in range(0, len(wanted), AT_ONCE):
                some = wanted[begin : begin + AT_ONCE]
                questions = [each.keys.question for each in some]  # type: ignore[attr-defined]
                answers = await self._ask(questions)
                for signal, answer in zip(some, answers, strict=True):
                    value = STATES.get(answer, "unknown") if signal.keys.outlet else answer  # type: ignore[attr-defined]
                    if signal.type == "state" and value not in (*signal.states, None):
                        # Not even the switch knows: the signal grows old, and is unknown then.
                        continue
                    text = value.decode(errors="replace") if isinstance(value, bytes) else value
                    self._host.publish(signal.address, text)
            self._host.connected()
            await asyncio.sleep(self._keys.poll)

    async def execute(self, request: ExtensionCommand) -> str:
        """Switch an outlet, and say what it is then."""
        keys = request.keys
        assert isinstance(keys, SnmpCommand)  # noqa: S101 - what we declared
        if self._writing is None:
            raise CommandRefused("there is no write_file with the community for switching")
        oid = f"{OUTLET}.{keys.outlet}"
        try:
            await self._writing.set(oid, Integer(ORDERS[keys.state]))
        except (SnmpError, OSError) as error:
            raise ExecutionFailed(f"{self._keys.host}: {error or type(error).__name__}") from error
        (answer,) = await self._ask([oid])
        return f"outlet {keys.outlet} is {STATES.get(answer, answer)}"

    def _client(self, community: str) -> PyWrapper:
        kind = V1 if self._keys.version == "1" else V2C
        client = Client(self._keys.host, kind(community), port=self._keys.port)
        client.configure(timeout=self._keys.timeout, retries=2)
        return PyWrapper(client)

    async def _ask(self, questions: list[str]) -> list[object]:
        try:
            return await self._reading.multiget(questions)
        except Timeout as error:
            raise ConnectionLost(f"{self._keys.host} does not answer") from error
        except (SnmpError, OSError) as error:
            raise ConnectionLost(f"{self._keys.host}: {error or type(error).__name__}") from error


def _word_in(folder: Path, name: str) -> str:
    return (folder / name).read_text().strip() if name else ""


extension = AdapterExtension(
    api=1,
    summary="power switches and other agents of SNMP 1 and 2c",
    connection=SnmpConnection,
    source=SnmpSource,
    command=SnmpCommand,
    make=Snmp,
)
