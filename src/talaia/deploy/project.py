"""All files of a deployment, by their path in its folder."""

from __future__ import annotations

from typing import TYPE_CHECKING, NamedTuple

from talaia.deploy.containers import DatabaseKind, write_compose_file, write_dockerfile
from talaia.deploy.readme import write_readme
from talaia.deploy.ros_image import message_packages, write_ros_dockerfile
from talaia.deploy.systemd import gateway_unit, hub_unit
from talaia.model.connection import Ros1Connection, Ros2Connection
from talaia.model.detection import DetectAt

if TYPE_CHECKING:
    from collections.abc import Callable

    from talaia.model.site import Site

__all__ = ["DeployOptions", "File", "make_deployment"]


# rospy and what robots are told something by; to be read, a type needs no package.
ROS1_PACKAGES = (
    "python3-rospy",
    "python3-actionlib",
    "python3-std-srvs",
    "python3-geometry-msgs",
    "python3-sensor-msgs",
    "python3-nav-msgs",
)


class File(NamedTuple):
    """A file's text and rights."""

    text: str
    mode: int = 0o644


class DeployOptions(NamedTuple):
    """What a person chose.

    Attributes:
        database: where accounts and history are kept.
        port: of the dashboard.
        hosts: names under which the dashboard is reached.
        version: of Talaia, for the images.
        program: absolute path of ``talaia`` on a robot's own computer.
        setup: absolute path of a ROS installation's ``setup.bash``; empty for none.
        phpmyadmin: with MariaDB, its tables can be looked at on a page.
        ros_distro: the distribution whose image the gateway's is made from; empty takes the wheels.
        arch: of the gateway's machine as Docker calls it (``arm64``); empty is the builder's own.

    """

    database: DatabaseKind
    port: int
    hosts: tuple[str, ...]
    version: str
    program: str
    setup: str = ""
    phpmyadmin: bool = False
    ros_distro: str = ""
    arch: str = ""


def make_deployment(
    site: Site, description: str, choice: DeployOptions, random: Callable[[], str]
) -> dict[str, File]:
    """Make a deployment of a site.

    Args:
        site: the description.
        description: its text, which is copied as it stands.
        choice: see `DeployOptions`.
        random: gives another secret word at each call, of letters and digits only.

    """
    domain = site.ros2.domain if site.ros2 is not None else None
    database = choice.database
    # Each database has an extra of its name, with the driver.
    extras = ["hub"] if database is DatabaseKind.SQLITE else ["hub", database.value]
    looks = [
        stream.detect for device in site.devices.values() for stream in device.streams.values()
    ]
    if any(detect is not None and detect.at is DetectAt.HUB for detect in looks):
        extras.append("objects")
    files = {
        "README.md": File(
            write_readme(site, database, choice.port, choice.setup, tables=choice.phpmyadmin)
        ),
        "site.yaml": File(description),
        "compose.yaml": File(
            write_compose_file(
                site.site,
                database=database,
                port=choice.port,
                hosts=choice.hosts,
                ros_domain=domain,
                arch=choice.arch,
                phpmyadmin=choice.phpmyadmin,
            )
        ),
        "hub.Dockerfile": File(write_dockerfile(extras, choice.version)),
        "gateway.Dockerfile": File(_gateway_image(site, choice)),
        # Keeps the folder, which the images' COPY needs.
        "wheels/.keep": File(""),
        # Neither passwords nor units go to the builder.
        ".dockerignore": File("secrets\nsystemd\n"),
        ".gitignore": File("secrets/\n"),
        f"systemd/talaia-gateway-{site.site}.service": File(
            gateway_unit(site.site, choice.program, choice.setup)
        ),
        "systemd/talaia-hub.service": File(hub_unit(choice.program, choice.port, choice.hosts)),
    }
    if database is not DatabaseKind.SQLITE:
        password = random()
        # Compose hands these on as they are, and in its container each is read by another user;
        # here nobody but the owner comes into their folder.
        files["secrets/database_password"] = File(password, 0o644)
        if database is DatabaseKind.MARIADB:
            files["secrets/database_root_password"] = File(random(), 0o644)
        # Letters and digits need no escape in a URL.
        url = f"{database.value}://talaia:{password}@database/talaia"
        # The hub's user in its container reads it, and only that container has it.
        files["secrets/database_url"] = File(url, 0o644)
    return files


def _gateway_image(site: Site, choice: DeployOptions) -> str:
    """Write the recipe of a gateway that has what the site's connections need."""
    links = site.links().values()
    extras = ["gateway"]
    # In a distribution's image the ROS 2 is there, and of another Python.
    if not choice.ros_distro and any(isinstance(link, Ros2Connection) for link in links):
        extras.append("ros2")
    if site.recording is not None:
        extras.append("recording")
    # Whether objects are seen on its cameras' pictures may be chosen while it runs.
    if any(device.streams for device in site.devices.values()):
        extras.append("objects")
    if site.filmed_cameras():
        extras.append("camera")
    if choice.ros_distro:
        types = [
            named
            for device in site.devices.values()
            for named in (
                *(command.type for command in device.commands.values()),
                *(getattr(signal.source, "type", "") for signal in device.signals.values()),
            )
            if named
        ]
        packages = message_packages(types)
        return write_ros_dockerfile(choice.ros_distro, extras, choice.version, packages)
    old = any(isinstance(link, Ros1Connection) for link in links)
    return write_dockerfile(extras, choice.version, ROS1_PACKAGES if old else ())
