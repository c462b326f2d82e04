"""What a robot that was found is called: by what tells it from others that are found here. Pure."""

from __future__ import annotations

from typing import TYPE_CHECKING
from urllib.parse import urlsplit

from talaia.model.discovery.device_places import robot_namespace

if TYPE_CHECKING:
    from talaia.model.discovery.probe_report import Found

__all__ = ["name_robot"]

# These are this machine, whose own name says more.
_LOCAL = ("", "localhost", "ip6-localhost", "::1")


def name_robot(found: Found, host: str) -> str:
    """Give the name of what was found, in its own words.

    Several robots are described from one laptop: each by its namespace, else by the machine that
    its master, server or broker runs on, else by this machine and the ROS domain.

    Args:
        found: what a probe saw.
        host: name of the machine that looked.

    """
    # Topics of brokers have no namespace of ROS.
    if found.protocol not in ("mqtt", "http") and (namespace := robot_namespace(found.topics)):
        return namespace
    other = urlsplit(found.master or found.url).hostname or found.host
    if other not in _LOCAL and not other.startswith("127."):
        # An address has no first part that would be a name.
        return other if other.replace(".", "").isdigit() else other.split(".", 1)[0]
    return f"{host}-domain-{found.domain}" if found.domain else host
