"""All files of a deployment, by their path in its folder."""

from __future__ import annotations

from typing import TYPE_CHECKING, NamedTuple

from talaia.deploy.containers import DatabaseKind, compose, dockerfile
from talaia.deploy.readme import readme
from talaia.deploy.systemd import gateway_unit, hub_unit

if TYPE_CHECKING:
    from collections.abc import Callable

    from talaia.model.site import Site

__all__ = ["Choice", "File", "project"]


class File(NamedTuple):
    """A file's text and rights."""

    text: str
    mode: int = 0o644


class Choice(NamedTuple):
    """What a person chose.

    Attributes:
        database: where accounts and history are kept.
        port: of the dashboard.
        hosts: names under which the dashboard is reached.
        version: of Talaia, for the images.
        program: absolute path of ``talaia`` on a robot's own computer.
        setup: absolute path of a ROS installation's ``setup.bash``; empty for none.

    """

    database: DatabaseKind
    port: int
    hosts: tuple[str, ...]
    version: str
    program: str
    setup: str = ""


def project(
    site: Site, description: str, choice: Choice, random: Callable[[], str]
) -> dict[str, File]:
    """Make a deployment of a site.

    Args:
        site: the description.
        description: its text, which is copied as it stands.
        choice: see `Choice`.
        random: gives another secret word at each call, of letters and digits only.

    """
    domain = site.ros2.domain if site.ros2 is not None else None
    database = choice.database
    extras = ["hub"] if database is DatabaseKind.SQLITE else ["hub", database.value]
    files = {
        "README.md": File(readme(site, choice.database, choice.port, choice.setup)),
        "site.yaml": File(description),
        "compose.yaml": File(compose(site.site, database, choice.port, choice.hosts, domain)),
        "hub.Dockerfile": File(dockerfile(extras, choice.version)),
        "gateway.Dockerfile": File(dockerfile(["gateway", "ros2"], choice.version)),
        "wheels/.keep": File(""),
        ".dockerignore": File("secrets\nsystemd\n"),
        ".gitignore": File("secrets/\n"),
        f"systemd/talaia-gateway-{site.site}.service": File(
            gateway_unit(site.site, choice.program, choice.setup)
        ),
        "systemd/talaia-hub.service": File(hub_unit(choice.program, choice.port, choice.hosts)),
    }
    if database is not DatabaseKind.SQLITE:
        password = random()
        files["secrets/database_password"] = File(password, 0o600)
        if database is DatabaseKind.MARIADB:
            files["secrets/database_root_password"] = File(random(), 0o600)
        url = f"{database.value}://talaia:{password}@database/talaia"
        # The hub's user in its container reads it, and only that container has it.
        files["secrets/database_url"] = File(url, 0o644)
    return files
