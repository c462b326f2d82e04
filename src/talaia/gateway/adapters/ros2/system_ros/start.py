"""To be imported before anything of ROS 2 by a gateway: rclpy itself, or what stands for it.

Where a system's ROS 2 is of another Python, nothing of it is loaded here: ``rclpy`` and the
packages of messages become stand-ins, and the work is done by a process of that Python.
"""

from __future__ import annotations

import os
import sys
from types import ModuleType
from typing import Any

from talaia.gateway.adapters.ros2.system_ros.process import BridgeLost
from talaia.gateway.adapters.ros2.system_ros.shared_process import SHARED
from talaia.ros_installation import (
    ForeignRos,
    RosChoice,
    RosOrigin,
    find_nothing_else,
    use_ros,
)

__all__ = ["guard_velocity", "is_bridged", "prepare_bridge"]

_NAMES = (
    "",
    ".action",
    ".context",
    ".executors",
    ".impl",
    ".impl.implementation_singleton",
    ".node",
    ".parameter",
    ".qos",
    ".serialization",
    ".signals",
)


def is_bridged() -> bool:
    """Tell whether ROS 2 is another process's."""
    return SHARED.in_use


def prepare_bridge() -> None:
    """Begin the bridge process where one is used; blocks for a second or two.

    Raises:
        BridgeLost: it cannot be begun.

    """
    if SHARED.in_use:
        SHARED.now()


def guard_velocity(publisher: Any, zero: object, steered: object) -> None:  # noqa: ANN401 - rclpy ships no types
    """Have zeros published by the bridge where no velocity comes any more.

    In one process with rclpy nobody is left to do so: there the robot's own time-out does it.
    ``steered`` is the zero of a vehicle whose wheels are steered elsewhere: where the two differ,
    what is published last stays.
    """
    if SHARED.in_use:
        plain, other = publisher.encode(zero), publisher.encode(steered)
        unlike = [at for at, byte in enumerate(plain) if byte != other[at]]
        publisher.guard(plain, (unlike[0], unlike[-1] + 1) if unlike else (0, 0))


def _stand_in(choice: RosChoice) -> None:
    from talaia.gateway.adapters.ros2.system_ros import stand_in_rclpy
    from talaia.gateway.adapters.ros2.system_ros.types import package_module

    SHARED.use(choice)
    try:
        hello = SHARED.now().hello
    except BridgeLost as error:
        raise ForeignRos(
            f"the ROS 2 of {choice.where} cannot be used by its own Python ({error}); see that "
            f"`{choice.python} -c 'import rclpy'` works after its setup.bash"
        ) from error
    packages: dict[str, str] = hello["packages"]
    # Robots before Iron tell no hashes: then definitions are those of this distribution.
    if distribution := hello["distribution"]:
        os.environ["ROS_DISTRO"] = distribution
    # All that is imported of rclpy is one module: names do not collide.
    for name in _NAMES:
        sys.modules[f"rclpy{name}"] = stand_in_rclpy
    for package, folder in packages.items():
        top = sys.modules[package] = ModuleType(package)
        top.__path__, top.__file__ = [], f"{folder}/__init__.py"
        for kind in ("msg", "srv", "action"):
            module = package_module(package, kind, SHARED.ask)
            sys.modules[module.__name__] = module
            setattr(top, kind, module)
    # A package of the wheels would load rclpy's own libraries.
    find_nothing_else()


_choice = use_ros(bridged=True)
if _choice.origin is RosOrigin.BRIDGED:
    _stand_in(_choice)
