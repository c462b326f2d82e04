"""What a person chose of a deployment."""

from __future__ import annotations

from typing import TYPE_CHECKING, NamedTuple

if TYPE_CHECKING:
    from talaia.deploy.containers import DatabaseKind

__all__ = ["DeployOptions"]


class DeployOptions(NamedTuple):
    """What a person chose.

    Attributes:
        database: where accounts and history are kept.
        port: of the dashboard.
        hosts: names under which the dashboard is reached.
        version: of Talaia, for the images.
        program: absolute path of ``talaia`` on a robot's own computer.
        setup: absolute path of a ROS installation's ``setup.bash``; empty for none.
        ros_distro: the distribution whose image the gateway's is made from; empty takes the wheels.
        arch: of the gateway's machine as Docker calls it (``arm64``); empty is the builder's own.
        hubs: how many; more than one are one on PostgreSQL.

    """

    database: DatabaseKind
    port: int
    hosts: tuple[str, ...]
    version: str
    program: str
    setup: str = ""
    ros_distro: str = ""
    arch: str = ""
    hubs: int = 1

    @property
    def tag(self) -> str:
        """Of images: a tag may have no ``+``, which the version of a checkout has."""
        return self.version.replace("+", "-")
