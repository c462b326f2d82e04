"""Which ROS 2 a process uses: one that is sourced, or the wheels beside Talaia; never both in one.

`choose_ros` is pure and decides; `use_ros` carries it out, before the first import of ``rclpy``.
The libraries of two ROS installations in one process crash it or fail to load at random: one's
``rclpy`` finds the other's ``librcl`` by ``LD_LIBRARY_PATH``.

Long, because the rule, what it changes and how a process begins anew have to fit each other.
"""

from __future__ import annotations

import importlib.util
import os
import platform
import re
import sys
from enum import StrEnum
from importlib.abc import MetaPathFinder
from importlib.machinery import PathFinder
from pathlib import Path
from typing import TYPE_CHECKING, NamedTuple

from talaia.errors import TalaiaError

if TYPE_CHECKING:
    from collections.abc import Mapping, Sequence
    from importlib.machinery import ModuleSpec
    from types import ModuleType

__all__ = [
    "ForeignRos",
    "RosChoice",
    "RosOrigin",
    "choose_ros",
    "find_ros",
    "ros_environment",
    "use_ros",
]

# Set by the wheels' own start-up module, which does nothing where it finds it. It runs in every
# Python process of an environment that has the wheels, by a ``.pth`` file, and sets the library
# path anew, in another order each time and whatever is sourced.
_WHEELS_READY = "_ROS_WHEELS_BOOTSTRAP_COMPLETE"
# Set by `use_ros` when it starts the process anew, so that this happens once.
_CHOSEN = "TALAIA_ROS_CHOSEN"
_LIBRARIES = "LD_LIBRARY_PATH"
_PREFIXES = "AMENT_PREFIX_PATH"
_PYTHONS = "PYTHONPATH"
# Where Debian and Ubuntu packages of ROS lie.
_OPT = Path("/opt/ros")
# A distribution's Python packages: ``lib/python3.10/site-packages``, or below ``local``.
_PACKAGES = re.compile(r"/(?:local/)?lib/python(3\.\d+)/(?:site|dist)-packages/?$")


class ForeignRos(TalaiaError):
    """What is called ``rclpy`` here is not ROS's, or belongs to another Python."""


class RosOrigin(StrEnum):
    """Where the ROS 2 of this process comes from."""

    SOURCED = "sourced"
    WHEELS = "wheels"
    # `rclpy` stands in the environment as any other package (conda, Debian's python3-rclpy).
    INSTALLED = "installed"
    NONE = "none"


class RosChoice(NamedTuple):
    """What is used, and why.

    Attributes:
        origin: which kind.
        where: folder of it; empty where there is none.
        reason: one sentence for `talaia doctor`.
        remedy: what to do where nothing can be used; empty else.
        environment: variables that have to be changed before ``rclpy`` is imported; none of them
            where the process can go on as it is.

    """

    origin: RosOrigin
    where: str
    reason: str
    remedy: str = ""
    environment: Mapping[str, str] = {}


class FoundRos(NamedTuple):
    """What there is on this machine.

    Attributes:
        package: folder of ``rclpy``; empty where no such package is found.
        wheels: whether the wheels' start-up module is installed.
        libraries: the wheels' folders of libraries.
        installations: of Debian or Ubuntu packages, not necessarily sourced.
        python: of this process, ``3.11``.
        machine: ``x86_64``, ``aarch64``.

    """

    package: str
    wheels: bool
    libraries: Sequence[str]
    installations: Sequence[str]
    python: str
    machine: str


def choose_ros(found: FoundRos, environment: Mapping[str, str]) -> RosChoice:
    """Choose: a sourced ROS of this Python, else the wheels, else what is installed.

    A ROS that is sourced for another Python cannot be loaded here. Where there are wheels, they
    are used with its paths taken out: its robot is reached by DDS all the same.
    """
    sourced = _split(environment.get(_PREFIXES, ""))
    pythons = {
        match[1]: path
        for path in _split(environment.get(_PYTHONS, ""))
        if any(path.startswith(f"{prefix}/") for prefix in sourced)
        and (match := _PACKAGES.search(path))
    }
    if found.python in pythons:
        where = pythons[found.python]
        return RosChoice(
            RosOrigin.SOURCED,
            where,
            f"{where} is sourced, for this Python",
            environment=_sourced_environment(found, environment, sourced),
        )
    other = next(iter(pythons), "")
    if found.wheels:
        reason = "the ROS 2 wheels beside Talaia"
        if other:
            reason += f"; {pythons[other]} is sourced, but for Python {other}"
        return RosChoice(
            RosOrigin.WHEELS,
            found.package,
            reason,
            environment=_wheels_environment(found, environment, sourced),
        )
    if found.package and not other:
        return RosChoice(RosOrigin.INSTALLED, found.package, f"rclpy of {found.package}")
    return RosChoice(RosOrigin.NONE, "", "there is no ROS 2 for this Python", _remedy(found, other))


def _sourced_environment(
    found: FoundRos, environment: Mapping[str, str], sourced: Sequence[str]
) -> dict[str, str]:
    """Give the library path as sourcing left it: without the wheels, in the prefixes' order."""
    before = _split(environment.get(_LIBRARIES, ""))
    kept = [path for path in before if path not in found.libraries]
    if kept == before:
        return {}

    def order(path: str) -> int:
        for at, prefix in enumerate(sourced):
            if path == prefix or path.startswith(f"{prefix}/"):
                return at
        return len(sourced)

    return {_LIBRARIES: os.pathsep.join(sorted(kept, key=lambda path: (order(path), path)))}


def _wheels_environment(
    found: FoundRos, environment: Mapping[str, str], sourced: Sequence[str]
) -> dict[str, str]:
    """Give what the wheels need changed; nothing where it is so already."""

    def outside(name: str) -> list[str]:
        return [
            path
            for path in _split(environment.get(name, ""))
            if not any(path == prefix or path.startswith(f"{prefix}/") for prefix in sourced)
        ]

    # Sorted, so that every start finds the same libraries.
    ours = sorted(found.libraries)
    rest = [path for path in outside(_LIBRARIES) if path not in ours]
    wanted = {_LIBRARIES: os.pathsep.join([*ours, *rest]), _WHEELS_READY: "1"}
    if sourced and _PYTHONS in environment:
        wanted[_PYTHONS] = os.pathsep.join(outside(_PYTHONS))
    # The prefixes stay: definitions of messages are looked for there.
    return {name: value for name, value in wanted.items() if environment.get(name) != value}


def _remedy(found: FoundRos, other: str) -> str:
    if other:
        return (
            f"the sourced ROS 2 is for Python {other} and this is Python {found.python}: make "
            f"Talaia's environment with `python{other} -m venv --system-site-packages`"
        )
    if found.installations:
        setup = f"{found.installations[0]}/setup.bash"
        return f"run `source {setup}` first, in an environment of that ROS's own Python"
    if found.machine == "x86_64":
        return "run `pip install 'talaia[ros2]'`, or install ROS 2 and source its setup.bash"
    return (
        f"install ROS 2 and source its setup.bash (its wheels are for x86_64, not {found.machine})"
    )


def find_ros() -> FoundRos:
    """Look at this machine; imports nothing of ROS."""
    spec = importlib.util.find_spec("rclpy")
    # A folder without `__init__` has no origin.
    package = str(Path(spec.origin).parent) if spec is not None and spec.origin else ""
    packages = Path(sys.prefix) / f"lib/python{_python()}/site-packages"
    folders = [Path(sys.prefix) / "lib", *packages.glob("ros_*.libs")]
    return FoundRos(
        package=package,
        wheels=importlib.util.find_spec("ros_wheels_bootstrapper") is not None,
        libraries=[str(folder.resolve()) for folder in folders if folder.is_dir()],
        installations=sorted(str(path.parent) for path in _OPT.glob("*/setup.bash")),
        python=_python(),
        machine=platform.machine(),
    )


def ros_environment() -> dict[str, str]:
    """Give what a process that uses ROS 2 is best started with beside this one's environment."""
    return dict(choose_ros(find_ros(), os.environ).environment)


def use_ros(*, ordered: bool = False) -> RosChoice:
    """Make ``rclpy`` importable; to be called before anything of ROS is imported.

    Starts the process anew, with the same number and arguments, where variables have to change
    that the dynamic loader reads at the start only.

    Args:
        ordered: also where libraries are all found, but in another order than at other starts.

    Raises:
        ForeignRos: there is none for this Python, or what is called so is something else.

    """
    choice = choose_ros(find_ros(), os.environ)
    if choice.origin is RosOrigin.NONE:
        raise ForeignRos(f"{choice.reason}; {choice.remedy}")
    # A second time would be a circle: then it is tried as it is.
    if (
        _is_to_change(choice.environment, ordered=ordered)
        and os.environ.get(_CHOSEN) != choice.origin
    ):
        changed = {**os.environ, **choice.environment, _CHOSEN: choice.origin}
        os.execve(sys.executable, sys.orig_argv, changed)  # noqa: S606
    if choice.origin is RosOrigin.SOURCED and not any(
        isinstance(finder, _SourcedOnly) for finder in sys.meta_path
    ):
        sys.meta_path.insert(0, _SourcedOnly(_split(os.environ.get(_PYTHONS, ""))))
    try:
        import rclpy.context  # noqa: F401
    except ImportError as error:
        raise ForeignRos(
            f"rclpy of {choice.where} cannot be used ({error}); {_remedy_of_broken(choice)}"
        ) from error
    return choice


def _is_to_change(wanted: Mapping[str, str], *, ordered: bool) -> bool:
    """Tell whether variables differ; the library path by its order only where that is asked."""
    return any(
        name != _LIBRARIES or ordered or set(_split(os.environ.get(name, ""))) != set(_split(value))
        for name, value in wanted.items()
    )


class _SourcedOnly(MetaPathFinder):
    """Finds packages that the wheels bring in the sourced ROS, or not at all.

    A message package of the wheels beside a sourced ``rclpy`` would load the other libraries.
    """

    def __init__(self, paths: Sequence[str]) -> None:
        """Find them in ``paths`` alone."""
        # Here, for it takes 0.3 s to go through all that is installed, and few need it.
        from importlib.metadata import packages_distributions

        self._paths = list(paths)
        self._names = {
            name
            for name, distributions in packages_distributions().items()
            if any(distribution.startswith("ros-") for distribution in distributions)
        }

    def find_spec(
        self, fullname: str, path: Sequence[str] | None, target: ModuleType | None = None
    ) -> ModuleSpec | None:
        """See `MetaPathFinder.find_spec`.

        Raises:
            ModuleNotFoundError: the sourced ROS has no such package.

        """
        if path is not None or fullname not in self._names:
            return None
        spec = PathFinder.find_spec(fullname, self._paths, target)
        if spec is None:
            raise ModuleNotFoundError(
                f"the sourced ROS 2 has no package {fullname}; install it there", name=fullname
            )
        return spec


def _remedy_of_broken(choice: RosChoice) -> str:
    if choice.origin is RosOrigin.WHEELS:
        return "run `pip install --force-reinstall 'talaia[ros2]'`"
    if choice.origin is RosOrigin.SOURCED:
        return "source its setup.bash anew, and see that `python3 -c 'import rclpy'` works there"
    return "it is not ROS's own: run `pip uninstall rclpy`, then `talaia doctor`"


def _python() -> str:
    return f"{sys.version_info.major}.{sys.version_info.minor}"


def _split(paths: str) -> list[str]:
    return [path.rstrip("/") for path in paths.split(os.pathsep) if path]
