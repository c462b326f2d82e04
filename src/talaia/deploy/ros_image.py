"""A gateway's image on a distribution's own ROS 2, for arm64 as well: `ros:<distro>`.

The gateway has a Python of its own there, and uses the image's ROS 2 by a process of that ROS's
Python. So one recipe serves Humble (3.10) and Jazzy (3.12), and nothing of the two mixes.
"""

from __future__ import annotations

import re
from typing import TYPE_CHECKING

from talaia.deploy.containers import USER, install_steps, write_steps

if TYPE_CHECKING:
    from collections.abc import Iterable, Sequence

__all__ = ["message_packages", "write_ros_dockerfile"]

# What every gateway may publish or call with; `ros-base` has some of them.
_USUAL = ("geometry_msgs", "nav_msgs", "sensor_msgs", "std_msgs", "std_srvs")
# Packages of the workspace alone are not in the distribution: their names would end the build.
_KNOWN = re.compile(r"[a-z][a-z0-9_]*_(?:msgs|srvs|interfaces)\Z")
_PYTHON = "3.12"


def message_packages(types: Iterable[str]) -> list[str]:
    """Name the packages of messages of a distribution that these types are in, and the usual."""
    named = {name.split("/", 1)[0] for name in types}
    return sorted({*_USUAL, *(name for name in named if _KNOWN.match(name))})


def write_ros_dockerfile(
    distro: str, extras: Sequence[str], version: str, packages: Iterable[str]
) -> str:
    """Write the recipe.

    Args:
        distro: of `ROS_DISTROS`.
        extras: of Talaia; those of ROS's wheels are not wanted.
        version: of Talaia, whose wheel is in ``wheels/``.
        packages: of messages, by their ROS names.

    """
    debian = " ".join(f"ros-{distro}-{name.replace('_', '-')}" for name in packages)
    uv, home = "/opt/uv/bin/uv", "/opt/talaia"
    # A wheel alone: nothing of the distribution's may build uv.
    locked = ["--require-hashes", "--only-binary", ":all:", "-r", "/locks/uv.txt"]
    # The distribution's Python only brings uv, which brings the gateway's: uv knows the hash of
    # each Python that it downloads.
    steps = [
        ["python3", "-m", "venv", "/opt/uv"],
        ["/opt/uv/bin/pip", "install", "--no-cache-dir", *locked],
        [uv, "venv", "--python", _PYTHON, "--python-preference", "only-managed", home],
        *install_steps(
            [uv, "pip", "install", "--python", f"{home}/bin/python", "--no-cache"],
            "gateway",
            extras,
            version,
        ),
    ]
    return f"""\
FROM ros:{distro}-ros-base
RUN apt-get update && apt-get install -y --no-install-recommends python3-venv {debian} \\
    && rm -rf /var/lib/apt/lists/*
COPY wheels/ /wheels/
COPY locks/ /locks/
ENV UV_PYTHON_INSTALL_DIR=/opt/python
{write_steps(steps)}
RUN groupadd --gid 10001 talaia && useradd --uid 10001 --gid 10001 --no-create-home talaia \\
    && install -d -o talaia -g talaia -m 0700 /data /link
USER {USER}
ENV PYTHONUNBUFFERED=1 ROS_LOG_DIR=/tmp
ENTRYPOINT ["/opt/talaia/bin/talaia"]
"""
