"""What a person chose of a deployment."""

from __future__ import annotations

from enum import StrEnum
from typing import NamedTuple

__all__ = [
    "FEWEST_HUBS",
    "MOST_HISTORY_SERVERS",
    "MOST_HUBS",
    "ROS_DISTROS",
    "DatabaseKind",
    "DeployOptions",
    "FilesChoice",
]

# Those that are kept up, oldest first; each has images for amd64 and arm64.
ROS_DISTROS = ("humble", "jazzy", "kilted", "rolling")
FEWEST_HUBS, MOST_HUBS = 2, 9
MOST_HISTORY_SERVERS = 9


class DatabaseKind(StrEnum):
    """Where accounts and history are kept."""

    SQLITE = "sqlite"
    MARIADB = "mariadb"
    POSTGRESQL = "postgresql"


class FilesChoice(NamedTuple):
    """A bucket of an object store, in which hubs keep recordings and pictures.

    Attributes:
        url: ``s3://bucket/folder``.
        endpoint: of the store; empty: AWS's own.
        region: of the store; empty: the usual one.
        key: text of the file that holds the key.
        ca: authorities of the store's certificate (PEM); empty: the usual ones.

    """

    url: str
    endpoint: str
    region: str
    key: str
    ca: str = ""

    @property
    def secrets(self) -> dict[str, str]:
        """What hubs read from files, by the file's name."""
        found = {"files_key": self.key}
        return {**found, "files_ca.pem": self.ca} if self.ca else found

    def hub_words(self, folder: str) -> list[str]:
        """Give the hub's options; what is secret lies in ``folder``."""
        words = ["--files", self.url, "--files-key-file", f"{folder}/files_key"]
        if self.endpoint:
            words += ["--files-endpoint", self.endpoint]
        if self.region:
            words += ["--files-region", self.region]
        if self.ca:
            words += ["--files-ca", f"{folder}/files_ca.pem"]
        return words


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
        files: bucket in which several hubs keep recordings and pictures; none: a shared folder.
        history_servers: databases of their own for histories of sites.
        shards: each of these databases has a lead of its own among the hubs.

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
    files: FilesChoice | None = None
    history_servers: int = 0
    shards: bool = False

    @property
    def tag(self) -> str:
        """Of images: a tag may have no ``+``, which the version of a checkout has."""
        return self.version.replace("+", "-")
