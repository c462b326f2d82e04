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
    "bridge_command",
    "bridge_environment",
    "choose_ros",
    "find_nothing_else",
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
# Names the Python whose rclpy is used, by a process of its own: for a gateway before all else.
_ROS_PYTHON = "TALAIA_ROS_PYTHON"
_LIBRARIES = "LD_LIBRARY_PATH"
_PREFIXES = "AMENT_PREFIX_PATH"
_PYTHONS = "PYTHONPATH"
# Where Debian and Ubuntu packages of ROS lie.
_OPT = Path("/opt/ros")
# What says where this Python has its packages.
_OWN = (_WHEELS_READY, _CHOSEN, "VIRTUAL_ENV", "PYTHONHOME")
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
    # A system's, of another Python: a process of that Python does the work for a gateway.
    BRIDGED = "bridged"
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
        python: the interpreter of a ROS of another Python; empty else.
        setup: what has to be sourced before that; empty where it has been.

    """

    origin: RosOrigin
    where: str
    reason: str
    remedy: str = ""
    environment: Mapping[str, str] = {}
    python: str = ""
    setup: str = ""


class FoundRos(NamedTuple):
    """What there is on this machine.

    Attributes:
        package: folder of ``rclpy``; empty where no such package is found.
        wheels: whether the wheels' start-up module is installed.
        libraries: the wheels' folders of libraries.
        installations: of Debian or Ubuntu packages, not necessarily sourced.
        python: of this process, ``3.11``.
        machine: ``x86_64``, ``aarch64``.
        packages: the folder of Python packages of each of the installations that has rclpy.

    """

    package: str
    wheels: bool
    libraries: Sequence[str]
    installations: Sequence[str]
    python: str
    machine: str
    packages: Mapping[str, str] = {}


def choose_ros(
    found: FoundRos, environment: Mapping[str, str], *, bridged: bool = False
) -> RosChoice:
    """Choose: a sourced ROS, else the wheels, else what is installed.

    A ROS that is sourced for another Python cannot be loaded here. A gateway (``bridged``) has a
    process of that Python do the work; all else uses the wheels, with its paths taken out.
    """
    sourced = _split(environment.get(_PREFIXES, ""))
    pythons = {
        match[1]: path
        for path in _split(environment.get(_PYTHONS, ""))
        if any(path.startswith(f"{prefix}/") for prefix in sourced)
        and (match := _PACKAGES.search(path))
    }
    if bridged and (named := environment.get(_ROS_PYTHON)):
        reason = f"{_ROS_PYTHON} is {named}, and a process of that Python uses its ROS 2"
        return RosChoice(RosOrigin.BRIDGED, named, reason, python=named)
    if bridged and pythons and found.python not in pythons:
        python, where = next(iter(pythons.items()))
        return _bridged_choice(where, python, f"{where} is sourced")
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
    if bridged and found.packages and not other:
        # Distributions are named by the alphabet: the newest is the last.
        prefix, where = max(found.packages.items())
        match = _PACKAGES.search(where)
        python = match[1] if match else found.python
        choice = _bridged_choice(where, python, f"{prefix} is installed")
        return choice._replace(setup=f"{prefix}/setup.bash")
    return RosChoice(RosOrigin.NONE, "", "there is no ROS 2 for this Python", _remedy(found, other))


def _bridged_choice(where: str, python: str, reason: str) -> RosChoice:
    return RosChoice(
        RosOrigin.BRIDGED,
        where,
        f"{reason}, and used by a process of its own Python {python}",
        python=f"python{python}",
    )


def bridge_command(choice: RosChoice) -> list[str]:
    """Give the words that start the Python of a bridged ROS; what it runs follows them."""
    system = f"/usr/bin/{choice.python}"
    python = system if os.access(system, os.X_OK) else choice.python
    if not choice.setup:
        return [python, "-u"]
    # bash gets the words as arguments of its own, so nothing in them is read as shell.
    return ["/bin/bash", "-c", '. "$0" && exec "$@"', choice.setup, python, "-u"]


def bridge_environment(environment: Mapping[str, str]) -> dict[str, str]:
    """Give the environment for that process: without what is for this Python and its wheels."""
    kept = {name: value for name, value in environment.items() if name not in _OWN}
    ours = find_ros().libraries
    libraries = [path for path in _split(environment.get(_LIBRARIES, "")) if path not in ours]
    kept[_LIBRARIES] = os.pathsep.join(libraries)
    return kept


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
        return [path for path in _split(environment.get(name, "")) if not _is_below(path, sourced)]

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
            f"the sourced ROS 2 is for Python {other} and this is Python {found.python}: a gateway "
            "uses it by a process of its own, all else needs `pip install 'talaia[ros2]'` (x86_64)"
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
        packages={
            str(prefix.parent): str(package.parent)
            for prefix in sorted(_OPT.glob("*/setup.bash"))
            # Humble's lies below `local`, with Debian's name for the folder.
            for package in prefix.parent.glob("**/lib/python3.*/*-packages/rclpy")
        },
    )


def ros_environment() -> dict[str, str]:
    """Give what a process that uses ROS 2 is best started with beside this one's environment."""
    return dict(choose_ros(find_ros(), os.environ).environment)


def use_ros(*, ordered: bool = False, bridged: bool = False) -> RosChoice:
    """Make ``rclpy`` importable; to be called before anything of ROS is imported.

    Starts the process anew, with the same number and arguments, where variables have to change
    that the dynamic loader reads at the start only.

    Args:
        ordered: also where libraries are all found, but in another order than at other starts.
        bridged: a ROS of another Python may be chosen; then nothing can be imported of it here.

    Raises:
        ForeignRos: there is none for this Python, or what is called so is something else.

    """
    choice = choose_ros(find_ros(), os.environ, bridged=bridged)
    if choice.origin is RosOrigin.NONE:
        raise ForeignRos(f"{choice.reason}; {choice.remedy}")
    if choice.origin is RosOrigin.BRIDGED:
        # Packages of another Python, which setup.bash has put before our own.
        prefixes = _split(os.environ.get(_PREFIXES, ""))
        sys.path[:] = [path for path in sys.path if not _is_below(path, prefixes)]
        return choice
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


def find_nothing_else() -> None:
    """Have no package of the wheels found in this process from here on."""
    sys.meta_path.insert(0, _SourcedOnly([]))


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


def _is_below(path: str, prefixes: Sequence[str]) -> bool:
    return any(path == prefix or path.startswith(f"{prefix}/") for prefix in prefixes)


def _split(paths: str) -> list[str]:
    return [path.rstrip("/") for path in paths.split(os.pathsep) if path]
