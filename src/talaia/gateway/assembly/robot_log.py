"""The robot's own log, kept for the hub where a connection's description says so."""

from __future__ import annotations

from typing import TYPE_CHECKING

from talaia.gateway.assembly.gateway_part import GatewayPart
from talaia.gateway.robot_log.line_files import LineFiles
from talaia.gateway.robot_log.log_reporter import LogReporter

if TYPE_CHECKING:
    from collections.abc import Awaitable, Callable, Mapping

    from talaia.gateway.assembly.foundation import FoundationPart

__all__ = ["RobotLogPart"]


class RobotLogPart(GatewayPart):
    """Attributes: reporter: takes lines, and sees that the hub gets them."""

    def __init__(self, *, base: FoundationPart) -> None:
        """Take up what an earlier run left in the data folder."""
        self.reporter = LogReporter(
            boot=base.boot,
            files=LineFiles(base.settings.data / "robot_log"),
            send=base.lanes.send,
            on_disk=base.run_on_disk,
            loop=base.loop,
        )

    @property
    def name(self) -> str:
        """What its task is called by in the log."""
        return "robot log"

    def tasks(self) -> Mapping[str, Callable[[], Awaitable[None]]]:
        """Write down and send."""
        return {"report": self.reporter.run}

    async def close(self) -> None:
        """Write what has just come."""
        await self.reporter.close()
