"""All files of a deployment, by their path in its folder."""

from __future__ import annotations

import datetime as dt
import re
from typing import TYPE_CHECKING, NamedTuple

from talaia.deploy.containers import (
    TABLES_SECRET,
    write_compose_file,
    write_dockerfile,
)
from talaia.deploy.history_databases import make_history_secrets
from talaia.deploy.kubernetes import write_manifests
from talaia.deploy.locks import BUILD, UV, write_lock
from talaia.deploy.options import DatabaseKind, DeployOptions
from talaia.deploy.readme import write_readme
from talaia.deploy.ros_image import message_packages, write_ros_dockerfile
from talaia.deploy.several_hubs import (
    NATS_PORT,
    SECRET_FOLDER,
    hub_names,
    write_balancer_config,
    write_bus_config,
    write_compose_of_several,
)
from talaia.deploy.systemd import gateway_unit, hub_unit
from talaia.model.closed_lists import DeviceKind
from talaia.model.connection import Ros1Connection, Ros2Connection
from talaia.model.detection import DetectAt

if TYPE_CHECKING:
    from collections.abc import Callable, Iterable, Mapping

    from talaia.model.site import Site

__all__ = ["BUS_SECRETS", "DeployOptions", "File", "make_deployment", "named_images", "pin_images"]

# Made together, of one authority and one password: one alone of another making fits none.
BUS_SECRETS = (
    "secrets/cluster_url",
    "secrets/nats.conf",
    "secrets/internal_ca.pem",
    "secrets/nats_cert.pem",
    "secrets/nats_key.pem",
    "secrets/database_cert.pem",
    "secrets/database_key.pem",
)

# Where a recipe or a compose file names an image of others.
_IMAGE = re.compile(r"^(?P<before>FROM | +image: )(?P<name>\S+)$", re.MULTILINE)

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


def make_deployment(
    site: Site,
    description: str,
    choice: DeployOptions,
    random: Callable[[], str],
    *,
    password: str = "",
) -> dict[str, File]:
    """Make a deployment of a site.

    Args:
        site: the description.
        description: its text, which is copied as it stands.
        choice: see `DeployOptions`.
        random: gives another secret word at each call, of letters and digits only.
        password: of the database, where it has one already; empty makes one.

    """
    database = choice.database
    # Nobody adds to an image later: it gives files of every form. Each database has an extra of
    # its name, with the driver.
    extras = ["hub", "arrow", "chats", "fast"]
    if database is not DatabaseKind.SQLITE:
        extras.append(database.value)
    if choice.hubs > 1:
        extras.append("cluster")
    if choice.files is not None:
        extras.append("s3")
    gateway_extras = _gateway_extras(site, choice)
    looks = [
        stream.detect for device in site.devices.values() for stream in device.streams.values()
    ]
    if any(detect is not None and detect.at is DetectAt.HUB for detect in looks):
        extras.append("objects")
    files = {
        "README.md": File(write_readme(site, choice)),
        "site.yaml": File(description),
        "compose.yaml": File(_compose_file(site, choice)),
        "hub.Dockerfile": File(write_dockerfile("hub", extras, choice.version)),
        "locks/hub.txt": File(write_lock(extras)),
        # Small, and the same for both images: whichever builds something takes it.
        "locks/build.txt": File(write_lock([BUILD])),
        "gateway.Dockerfile": File(_gateway_image(site, choice, gateway_extras)),
        "locks/gateway.txt": File(write_lock(gateway_extras)),
        # Keeps the folder, which the images' COPY needs.
        "wheels/.keep": File(""),
        # Neither passwords nor units go to the builder.
        ".dockerignore": File("secrets\nsystemd\nkubernetes\n"),
        ".gitignore": File("secrets/\n"),
        f"systemd/talaia-gateway-{site.site}.service": File(
            gateway_unit(site.site, choice.program, choice.setup)
        ),
    }
    if choice.hubs == 1:
        unit = hub_unit(choice.program, choice.port, choice.hosts)
        files["systemd/talaia-hub.service"] = File(unit)
    # Only there a recipe brings a Python of its own.
    if choice.ros_distro:
        files["locks/uv.txt"] = File(write_lock([UV]))
    if database is not DatabaseKind.SQLITE:
        password = password or random()
        # Compose hands these on as they are, and in its container each is read by another user;
        # here nobody but the owner comes into their folder.
        files["secrets/database_password"] = File(password, 0o644)
        if database is DatabaseKind.MARIADB:
            files["secrets/database_root_password"] = File(random(), 0o644)
            # PHP, as phpMyAdmin's image reads it; 32 letters and digits need no escape.
            sealing = f"<?php\n$cfg['blowfish_secret'] = '{random()[:32]}';\n"
            files[f"secrets/{TABLES_SECRET}"] = File(sealing, 0o644)
        # Letters and digits need no escape in a URL.
        url = f"{database.value}://talaia:{password}@database/talaia"
        # The hub's user in its container reads it, and only that container has it.
        files["secrets/database_url"] = File(url, 0o644)
    if choice.hubs > 1:
        files |= _files_of_several(choice, password, random)
    return files


def _compose_file(site: Site, choice: DeployOptions) -> str:
    domain = site.ros2.domain if site.ros2 is not None else None
    if choice.hubs > 1:
        return write_compose_of_several(
            site.site,
            hubs=choice.hubs,
            port=choice.port,
            hosts=choice.hosts,
            ros_domain=domain,
            arch=choice.arch,
            files=choice.files,
            history_servers=choice.history_servers,
        )
    return write_compose_file(
        site.site,
        database=choice.database,
        port=choice.port,
        hosts=choice.hosts,
        ros_domain=domain,
        arch=choice.arch,
    )


def _files_of_several(
    choice: DeployOptions, password: str, random: Callable[[], str]
) -> dict[str, File]:
    """Write what several hubs need besides: HAProxy, NATS, certificates and manifests."""
    # Only here: what a single hub's folder is made by needs no library of cryptography.
    from talaia.deploy.internal_tls import make_server_pairs

    bus_password = random()
    authority, pairs = make_server_pairs(("nats", "database"), dt.datetime.now(dt.UTC))
    checked = f"sslmode=verify-full&sslrootcert={SECRET_FOLDER}/internal_ca.pem"
    # As the others: read by another user in its container, and here nobody enters their folder.
    secrets = {
        "cluster_url": f"tls://talaia:{bus_password}@nats:{NATS_PORT}",
        "nats.conf": write_bus_config(bus_password),
        "internal_ca.pem": authority,
        **{f"{name}_cert.pem": pair.certificate for name, pair in pairs.items()},
        **{f"{name}_key.pem": pair.key for name, pair in pairs.items()},
        # There the database is on another machine.
        "kubernetes_database_url": f"postgresql://talaia:{password}@database/talaia?{checked}",
    }
    if choice.files is not None:
        secrets |= choice.files.secrets
    if choice.history_servers:
        secrets |= make_history_secrets(choice.history_servers, random, shards=choice.shards)
    manifests = write_manifests(
        choice.hubs,
        choice.hosts,
        choice.tag,
        bucket=choice.files,
        history_servers=choice.history_servers,
    )
    return {
        "haproxy.cfg": File(write_balancer_config(hub_names(choice.hubs))),
        **{f"secrets/{name}": File(text, 0o644) for name, text in secrets.items()},
        **{f"kubernetes/{name}": File(text) for name, text in manifests.items()},
    }


def named_images(files: Mapping[str, File]) -> list[str]:
    """Name the images of others that a deployment is made of."""
    return sorted(
        {found["name"] for file in files.values() for found in _IMAGE.finditer(file.text)}
    )


def pin_images(files: Mapping[str, File], pins: Iterable[str]) -> dict[str, File]:
    """Write a digest behind each image's tag.

    Args:
        files: of `make_deployment`.
        pins: images with their digests, ``postgres:17@sha256:…``.

    """
    # By the name with its tag, as recipes say it.
    pinned = {pin.partition("@")[0]: pin for pin in pins}
    return {
        path: file._replace(
            text=_IMAGE.sub(
                lambda found: found["before"] + pinned.get(found["name"], found["name"]), file.text
            )
        )
        for path, file in files.items()
    }


_OBSERVATORY = (DeviceKind.DOME, DeviceKind.TELESCOPE)


def _gateway_extras(site: Site, choice: DeployOptions) -> list[str]:
    """Name what the site's connections, recordings and cameras need."""
    links = site.links().values()
    # What is needed by none of its parts is no way in either.
    extras = ["gateway", "fast"]
    # In a distribution's image the ROS 2 is there, and of another Python.
    if not choice.ros_distro and any(isinstance(link, Ros2Connection) for link in links):
        extras.append("ros2")
    if site.recording is not None:
        extras.append("recording")
    # Taking frames to where they were taken needs the library of astronomy.
    if site.night is not None or any(
        device.kind in _OBSERVATORY for device in site.devices.values()
    ):
        extras.append("observatory")
    # Whether objects are seen on its cameras' pictures may be chosen while it runs.
    if any(device.streams for device in site.devices.values()):
        extras.append("objects")
    # H.264 brings a library under the GPL, which only who films takes on.
    if site.filmed_cameras():
        extras.append("camera")
    return extras


def _gateway_image(site: Site, choice: DeployOptions, extras: list[str]) -> str:
    """Write the recipe of a gateway that has what the site's connections need."""
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
    old = any(isinstance(link, Ros1Connection) for link in site.links().values())
    return write_dockerfile("gateway", extras, choice.version, ROS1_PACKAGES if old else ())
