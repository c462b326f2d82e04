"""The one bridge process of a gateway: begun when it is needed, ended when nobody uses it."""

from __future__ import annotations

import os
import threading
from typing import TYPE_CHECKING, Any

from talaia.gateway.adapters.ros2.system_ros.process import BridgeLost, BridgeProcess
from talaia.ros_installation import bridge_command, bridge_environment

if TYPE_CHECKING:
    from talaia.ros_installation import RosChoice

__all__ = ["SHARED", "SharedProcess"]


class SharedProcess:
    """The process that is there now. Any thread."""

    def __init__(self) -> None:
        """Use none: ROS 2 is this process's own."""
        self._choice: RosChoice | None = None
        self._turn = threading.Lock()
        self._process: BridgeProcess | None = None
        # Contexts that are joined by it.
        self._joined = 0

    @property
    def in_use(self) -> bool:
        """Whether ROS 2 is another process's."""
        return self._choice is not None

    def use(self, choice: RosChoice) -> None:
        """Take which ROS is used."""
        self._choice = choice

    def now(self) -> BridgeProcess:
        """Give the process; begins it where there is none, which blocks for a second or two.

        Raises:
            BridgeLost: it cannot be begun.

        """
        with self._turn:
            return self._begin()

    def join(self) -> BridgeProcess:
        """Give the process, to be released."""
        with self._turn:
            process = self._begin()
            self._joined += 1
            return process

    def release(self, process: BridgeProcess) -> None:
        """End it where nobody else has joined by it. Blocks."""
        with self._turn:
            if process is not self._process:
                return
            self._joined -= 1
            if self._joined > 0 and not process.lost:
                return
            self._process = None
        process.close()

    def ask(self, question: str, /, **words: object) -> Any:  # noqa: ANN401 - what was asked for
        """See `BridgeProcess.ask`."""
        return self.now().ask(question, **words)

    def python_command(self) -> list[str]:
        """Give the words that start that ROS's Python; what it runs follows them.

        Raises:
            BridgeLost: there is none.

        """
        if self._choice is None:
            raise BridgeLost("no system's ROS 2 is used")
        return bridge_command(self._choice)

    def _begin(self) -> BridgeProcess:
        command = self.python_command()
        if self._process is None or self._process.lost:
            self._joined = 0
            self._process = BridgeProcess(command, bridge_environment(os.environ))
        return self._process


# The one of this process: modules that stand in are the process's, too.
SHARED = SharedProcess()
