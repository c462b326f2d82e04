"""``talaia doctor``: which parts are here, whether the machine is fit, and what to do.

Looks only: it connects to no robot, starts no server and changes nothing.
"""

from __future__ import annotations

import argparse
import importlib.metadata
import importlib.util
import os
import platform
import shutil
import subprocess
import sys
from pathlib import Path
from typing import TYPE_CHECKING

from talaia import __version__
from talaia.cli.examining.findings import PartFinding, PartState
from talaia.cli.examining.host import examine_host
from talaia.ros_installation import (
    RosOrigin,
    bridge_command,
    bridge_environment,
    choose_ros,
    find_ros,
)

if TYPE_CHECKING:
    from collections.abc import Iterator, Sequence

    from talaia.objects.provider_trial import ProviderTrial
    from talaia.ros_installation import RosChoice

__all__ = ["examine_machine", "main"]

# The part that takes it, the module that shows that it is there, and the extra that brings it.
_PARTS = (
    ("hub", "fastapi", "hub"),
    ("hub on PostgreSQL", "asyncpg", "postgresql"),
    ("hub on MariaDB", "aiomysql", "mariadb"),
    ("messages to chats", "apprise", "chats"),
    ("gateway", "rosbags", "gateway"),
    ("faster event loop", "uvloop", "fast"),
    ("recordings", "mcap", "recording"),
    ("cameras as H.264", "av", "camera"),
    ("objects on pictures", "onnxruntime", "objects"),
    ("configurator", "PySide6", "configurator"),
    ("simulated vehicle", "mujoco", "sim"),
    ("simulated observatory", "astropy", "observatory"),
)
# Of the messages that a robot is told something by; to be read, a type needs no package.
_MESSAGES = ("std_msgs", "geometry_msgs", "sensor_msgs", "nav_msgs", "std_srvs")
# Imports from a memory card.
_IMPORT_S = 30.0
_RMW = "RMW_IMPLEMENTATION"
# By which ROS 2 hears nothing of other machines; the first until Humble, the other from Iron on.
_THIS_MACHINE = (("ROS_LOCALHOST_ONLY", "1"), ("ROS_AUTOMATIC_DISCOVERY_RANGE", "LOCALHOST"))
# The middleware by which a type without its package can be read.
_USUAL_RMW = "rmw_fastrtps_cpp"


def examine_machine() -> Iterator[PartFinding]:
    """Look for all parts, the most asked for first."""
    yield PartFinding(
        PartState.OK,
        "Talaia",
        f"{__version__}, Python {platform.python_version()} on {sys.platform} "
        f"{platform.machine()}, in {sys.prefix}",
    )
    yield from _examine_ros2()
    yield from _examine_ros1()
    server = shutil.which("indiserver")
    yield (
        PartFinding(PartState.OK, "INDI server", str(server))
        if server
        else PartFinding(
            PartState.ABSENT, "INDI server", "not on this machine", "run `apt install indi-bin`"
        )
    )
    for what, module, extra in _PARTS:
        if importlib.util.find_spec(module) is not None:
            yield PartFinding(PartState.OK, what, _version_of(module))
        else:
            remedy = f"run `pip install 'talaia[{extra}]'`"
            yield PartFinding(PartState.ABSENT, what, "not installed", remedy)
    if importlib.util.find_spec("onnxruntime") is not None:
        # Arrays, which --help and wrong words do not wait for.
        from talaia.objects.provider_trial import try_providers

        yield from _examine_detectors(try_providers())


def _examine_detectors(trials: Sequence[ProviderTrial]) -> Iterator[PartFinding]:
    """Say what detectors of objects can run on here, and which is the fastest."""
    fastest = min((trial for trial in trials if not trial.problem), key=_picture_s, default=None)
    for trial in trials:
        what = f"objects by {trial.name}"
        if trial.problem:
            remedy = (
                "install its driver, or leave it: the processor is used"
                if trial.name != "cpu"
                else "run `pip install 'talaia[objects]'`"
            )
            yield PartFinding(PartState.PROBLEM, what, trial.problem, remedy)
            continue
        detail = f"{1_000 * trial.picture_s:.0f} ms a picture, by one thread"
        if trial is fastest and trial.name != "cpu":
            detail += f"; talaia gateway --detector-provider {trial.name} uses it"
        yield PartFinding(PartState.OK, what, detail)


def _picture_s(trial: ProviderTrial) -> float:
    return trial.picture_s


def _examine_ros2() -> Iterator[PartFinding]:
    found = find_ros()
    choice = choose_ros(found, os.environ, bridged=True)
    if choice.origin is RosOrigin.NONE:
        # Whoever sourced one means to use it; else it is one of several ways to a robot.
        state = PartState.PROBLEM if os.environ.get("AMENT_PREFIX_PATH") else PartState.ABSENT
        yield PartFinding(state, "ROS 2", choice.reason, choice.remedy)
        return
    yield PartFinding(PartState.OK, "ROS 2", choice.reason)
    if choice.origin is RosOrigin.WHEELS and found.installations:
        yield PartFinding(
            PartState.OK,
            "ROS 2 on this machine",
            f"{', '.join(found.installations)}, not used; its robots are reached all the same",
        )
    if choice.origin is RosOrigin.BRIDGED:
        # What packages it has is known by its own Python alone.
        yield from _examine_bridge(choice)
        absent = []
    else:
        absent = [name for name in _MESSAGES if importlib.util.find_spec(name) is None]
    if absent:
        packages = " ".join(f"ros-$ROS_DISTRO-{name.replace('_', '-')}" for name in absent)
        remedy = (
            "run `pip install 'talaia[ros2]'`"
            if choice.origin is RosOrigin.WHEELS
            else f"run `apt install {packages}`"
        )
        yield PartFinding(PartState.PROBLEM, "ROS 2 messages", f"no {', '.join(absent)}", remedy)
    middleware = os.environ.get(_RMW, "")
    if middleware and middleware != _USUAL_RMW:
        detail = f"{middleware}; types whose package is not here can be read with {_USUAL_RMW} only"
        yield PartFinding(PartState.OK, "ROS 2 middleware", detail)
    yield _examine_domain()


def _examine_domain() -> PartFinding:
    """Say which robots are heard: those of another domain or machine are the first surprise."""
    domain = os.environ.get("ROS_DOMAIN_ID", "")
    if domain and not domain.isdecimal():
        remedy = "set it to a number from 0 to 101, the same as on the robot"
        return PartFinding(
            PartState.PROBLEM, "ROS 2 domain", f"ROS_DOMAIN_ID is {domain!r}", remedy
        )
    said = f"{domain}, by ROS_DOMAIN_ID" if domain else "0, for ROS_DOMAIN_ID is not set"
    for variable, here in _THIS_MACHINE:
        if os.environ.get(variable, "").upper() == here:
            said += f"; only robots on this machine are heard ({variable})"
    return PartFinding(PartState.OK, "ROS 2 domain", f"{said}; it must be the robot's")


def _examine_bridge(choice: RosChoice) -> Iterator[PartFinding]:
    """Try whether a system's ROS 2 can be used by its own Python."""
    words = [*bridge_command(choice), "-c", f"import rclpy, {', '.join(_MESSAGES)}"]
    try:
        done = subprocess.run(  # noqa: S603 - an interpreter of the system's
            words,
            env=bridge_environment(os.environ),
            capture_output=True,
            text=True,
            timeout=_IMPORT_S,
            check=False,
        )
    except (OSError, subprocess.TimeoutExpired) as error:
        remedy = f"install {choice.python}, or name the Python that has rclpy in TALAIA_ROS_PYTHON"
        yield PartFinding(PartState.PROBLEM, "ROS 2 by its Python", str(error), remedy)
        return
    if done.returncode:
        said = (done.stderr.strip().splitlines() or ["it says nothing"])[-1]
        packages = " ".join(f"ros-$ROS_DISTRO-{name.replace('_', '-')}" for name in _MESSAGES)
        remedy = f"source its setup.bash, and run `apt install ros-$ROS_DISTRO-rclpy {packages}`"
        yield PartFinding(PartState.PROBLEM, "ROS 2 by its Python", said, remedy)


def _examine_ros1() -> Iterator[PartFinding]:
    # By the system's own Python, which the bridge runs it with.
    rospy = next(
        (
            str(path)
            for folder in ("/usr/lib/python3/dist-packages", "/opt/ros/noetic/lib/python3")
            for path in sorted(Path(folder).glob("rospy"))
        ),
        "",
    )
    if rospy:
        yield PartFinding(PartState.OK, "ROS 1", f"rospy in {rospy}, by /usr/bin/python3")
    else:
        yield PartFinding(
            PartState.ABSENT,
            "ROS 1",
            "no rospy of the system's Python",
            "run `apt install python3-rospy python3-actionlib python3-std-srvs`",
        )


def _version_of(module: str) -> str:
    """Give a module's name and the version of its package, without importing it."""
    for name in (module, f"{module}-Essentials"):
        try:
            return f"{module} {importlib.metadata.version(name)}"
        except importlib.metadata.PackageNotFoundError:
            continue
    return module


def main(argv: Sequence[str]) -> int:
    """Print what was found; 1 when something is there and cannot be used."""
    parser = argparse.ArgumentParser(
        "talaia doctor",
        description="Say what Talaia finds on this machine: which ROS 2 it uses and why, ROS 1, "
        "INDI, the parts that are installed, what runs, and whether port, clock, disk and "
        "certificate are fit for a hub; with what to do about the rest. Ends with 1 if something "
        "cannot be used.",
    )
    parser.add_argument(
        "--data", type=Path, default=Path("talaia-data"), help="the hub's data folder (talaia-data)"
    )
    parser.add_argument("--port", type=int, default=8443, help="the hub's port (8443)")
    options = parser.parse_args(argv)
    findings = [*examine_machine(), *examine_host(options.data, options.port)]
    width = max(len(finding.what) for finding in findings)
    for finding in findings:
        print(f"{finding.state}  {finding.what:<{width}}  {finding.detail}")
        if finding.remedy:
            print(f"    {'':<{width}}  → {finding.remedy}")
    return int(any(finding.state is PartState.PROBLEM for finding in findings))
