"""What the tests of the simulators share."""

from __future__ import annotations

import json
import os
import selectors
import signal
import subprocess
import sys
import time
import warnings
from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING, Any

import pytest

import talaia
from talaia.sim.ros_domain import domain_environment, reserve_domain

if TYPE_CHECKING:
    from collections.abc import Callable, Iterator

READY_WITHIN_S = 45.0
"""Ten times what it takes; other tests may have the machine."""


def missing(reason: str) -> None:
    """Skip, or fail where everything is required to be there."""
    if os.environ.get("TALAIA_REQUIRE_ALL") == "1":
        pytest.fail(f"required here, but {reason}")
    pytest.skip(reason)


@dataclass
class Vehicle:
    """A simulated vehicle in a process of its own."""

    process: subprocess.Popen[str]
    ready: dict[str, Any]
    log: Path

    def actuations(self) -> list[dict[str, Any]]:
        return [json.loads(line) for line in self.log.read_text().splitlines()]

    def end(self, number: int = signal.SIGTERM) -> int:
        if self.process.poll() is None:
            self.process.send_signal(number)
        try:
            return self.process.wait(15)
        except subprocess.TimeoutExpired:
            self.process.kill()
            self.process.wait()
            raise
        finally:
            assert self.process.stdout is not None
            self.process.stdout.close()


def start_vehicle(log: Path, domain: int, *options: str) -> Vehicle:
    """Start one and wait until it says that it is ready."""
    source = str(Path(talaia.__file__).parents[1])
    paths = [source, *filter(None, [os.environ.get("PYTHONPATH")])]
    process = subprocess.Popen(
        [
            *(sys.executable, "-m", "talaia.sim.vehicle"),
            *("--domain", str(domain), "--log", str(log), *options),
        ],
        stdout=subprocess.PIPE,
        text=True,
        env=os.environ | {"PYTHONPATH": os.pathsep.join(paths)},
    )
    assert process.stdout is not None
    with selectors.DefaultSelector() as selector:
        selector.register(process.stdout, selectors.EVENT_READ)
        heard = selector.select(READY_WITHIN_S)
    line = process.stdout.readline() if heard else ""
    if not line:
        process.kill()
        process.wait()
        process.stdout.close()
        missing("the simulated vehicle did not start; see what it says above")
    return Vehicle(process, json.loads(line), log)


class Peer:
    """A ROS node of the test in the vehicle's domain."""

    def __init__(self, domain: int) -> None:
        """Join a domain."""
        import rclpy
        from rclpy.executors import SingleThreadedExecutor
        from rclpy.signals import SignalHandlerOptions

        self.context = rclpy.Context()
        rclpy.init(
            args=[],
            context=self.context,
            domain_id=domain,
            signal_handler_options=SignalHandlerOptions.NO,
        )
        self.node = rclpy.create_node("peer", context=self.context, enable_rosout=False)
        self.executor = SingleThreadedExecutor(context=self.context)
        self.executor.add_node(self.node)

    def until(self, condition: Callable[[], object], seconds: float = 20.0) -> bool:
        """Handle messages until a condition holds; False when it did not in time."""
        deadline = time.monotonic() + seconds
        while not condition():
            if time.monotonic() > deadline:
                return False
            self.executor.spin_once(timeout_sec=0.02)
        return True

    def collect(self, kind: Any, topic: str, depth: int = 10) -> list[Any]:
        """Subscribe; the list fills while messages are handled."""
        messages: list[Any] = []
        self.node.create_subscription(kind, topic, lambda m: messages.append(m), depth)
        return messages

    def close(self) -> None:
        self.executor.shutdown()
        self.node.destroy_node()
        self.context.try_shutdown()


@pytest.fixture(scope="session")
def ros() -> None:
    """Skip where ROS 2 cannot be imported."""
    try:
        with warnings.catch_warnings():
            # ROS's own modules import what Python has deprecated.
            warnings.simplefilter("ignore", DeprecationWarning)
            import rclpy.executors  # noqa: F401
            import rosidl_generator_py  # noqa: F401
    except ImportError as error:
        missing(f"ROS 2 cannot be imported: {error}")


@pytest.fixture(scope="session")
def domain(ros: None) -> Iterator[int]:
    """A ROS domain for the tests of this folder, and the variables that keep it here."""
    with reserve_domain() as reservation, pytest.MonkeyPatch.context() as patch:
        for name, value in domain_environment(reservation.domain).items():
            patch.setenv(name, value)
        yield reservation.domain


@pytest.fixture
def peer(domain: int) -> Iterator[Peer]:
    """A ROS node of the test."""
    node = Peer(domain)
    yield node
    node.close()
