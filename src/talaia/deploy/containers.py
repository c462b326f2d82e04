"""A compose project: hub, database, gateway; every value goes through a serializer.

Secrets are files that `talaia generate` fills with random words; there is no default password
anywhere. The gateway's key never leaves the machine: a one-shot service makes it at the first
start and hands it over in a volume.

Long, because each service with all that bounds it stands here, in one place.
"""

from __future__ import annotations

import json
from enum import StrEnum
from typing import TYPE_CHECKING

import yaml

if TYPE_CHECKING:
    from collections.abc import Iterable, Mapping

__all__ = ["USER", "DatabaseKind", "write_compose_file", "write_dockerfile"]

# By minor version: to build anew brings the fixes of what lies below.
PYTHON_IMAGE = "python:3.12-slim-bookworm"
IMAGES = {"mariadb": "mariadb:11.4", "postgresql": "postgres:17", "phpmyadmin": "phpmyadmin:5.2"}
# Numbers, not names: volumes keep their owner when the image is built anew.
USER = "10001:10001"
# Asks the hub itself, inside its own container; its certificate is its own, hence unverified.
_HEALTH = (
    "import ssl,sys,urllib.request as u;c=ssl._create_unverified_context();"
    "sys.exit(u.urlopen('https://127.0.0.1:8443/api/health',context=c,timeout=3).status!=200)"
)
# Docker keeps logs without end unless it is told otherwise.
_SMALL = {"max-size": "10m", "max-file": "3"}
# The databases' own user in both images: as root they would need capabilities to become it.
_DATABASE_USER = "999:999"
# Threads and processes of one container.
_MOST_TASKS = 1024


class DatabaseKind(StrEnum):
    """Where accounts and history are kept."""

    SQLITE = "sqlite"
    MARIADB = "mariadb"
    POSTGRESQL = "postgresql"


def write_dockerfile(extras: Iterable[str], version: str, debian: Iterable[str] = ()) -> str:
    """Write an image's recipe: Talaia with what pip finds for it, and nobody's root.

    ``wheels/`` may hold Talaia's own wheel; where it is empty, the version is fetched by pip.
    """
    wanted = f"talaia[{','.join(extras)}]=={version}"
    packages = " ".join(debian)
    system = (
        f"RUN apt-get update && apt-get install -y --no-install-recommends {packages} \\\n"
        "    && rm -rf /var/lib/apt/lists/*\n"
        if packages
        else ""
    )
    # A list, which the recipe runs without a shell: brackets and names stay what they are.
    install = ["pip", "install", "--no-cache-dir", "--find-links", "/wheels", wanted]
    return f"""\
FROM {PYTHON_IMAGE}
{system}COPY wheels/ /wheels/
RUN {json.dumps(install)}
RUN groupadd --gid 10001 talaia && useradd --uid 10001 --gid 10001 --no-create-home talaia \\
    && install -d -o talaia -g talaia -m 0700 /data /link
USER {USER}
ENV PYTHONUNBUFFERED=1
ENTRYPOINT ["talaia"]
"""


def write_compose_file(
    site: str,
    *,
    database: DatabaseKind,
    port: int,
    hosts: Iterable[str],
    ros_domain: int | None,
    phpmyadmin: bool = False,
    arch: str = "",
) -> str:
    """Write ``compose.yaml``.

    Args:
        site: the site's short name.
        database: where accounts and history are kept.
        port: of the dashboard, on the host.
        hosts: names under which the dashboard is reached, beside the machine's own.
        ros_domain: the ROS domain; none leaves it to the description.
        phpmyadmin: with MariaDB, a page that shows its tables.
        arch: of the gateway's machine, ``arm64``; empty is the builder's own.

    """
    services: dict[str, object] = {}
    secrets: dict[str, object] = {}
    volumes: dict[str, object] = {"hub-data": {}, "link": {}, "gateway-data": {}}
    hub = _hub_service(port, hosts)
    # It makes the key and ends; `on-failure` tries again only until that has worked.
    enrol = _base_service(
        {
            "build": {"context": ".", "dockerfile": "hub.Dockerfile"},
            "command": [
                "enrol",
                site,
                "--data",
                "/data",
                "--to",
                "/link/gateway.key",
                "--hub",
                f"wss://127.0.0.1:{port}",
            ],
            "restart": "on-failure",
            # The hub's certificate is there, whose hash goes into the key file.
            "volumes": ["hub-data:/data", "link:/link"],
            "depends_on": {"hub": {"condition": "service_healthy"}},
        },
        "1g",
    )
    if database is not DatabaseKind.SQLITE:
        added = _mariadb_services() if database is DatabaseKind.MARIADB else _postgresql_services()
        services |= added
        if phpmyadmin:
            services["phpmyadmin"] = _phpmyadmin_service()
        volumes["database"] = {}
        secrets = {name: {"file": f"./secrets/{name}"} for name in _secret_files(database)}
        # Both open the database.
        for service in (hub, enrol):
            service["environment"] = {"TALAIA_DATABASE_URL_FILE": "/run/secrets/database_url"}
            service["secrets"] = ["database_url"]
        hub["depends_on"] = {"database": {"condition": "service_healthy"}}
    services |= {"hub": hub, "enrol": enrol, "gateway": _gateway_service(ros_domain, arch)}
    project: dict[str, object] = {"services": services, "volumes": volumes}
    if secrets:
        project["secrets"] = secrets
    # Never folded: each value stays on its line.
    return yaml.safe_dump(_literal_text(project), sort_keys=False, width=1_000_000)


def _secret_files(database: DatabaseKind) -> list[str]:
    root = ["database_root_password"] if database is DatabaseKind.MARIADB else []
    return ["database_password", *root, "database_url"]


def _base_service(
    more: Mapping[str, object], memory: str, writable: Iterable[str] = ()
) -> dict[str, object]:
    """Write what all services have: no capabilities, bounds, and nothing that can be written.

    Args:
        more: of the service; it takes the place of what all have.
        memory: what it may take.
        writable: folders in memory, beside ``/tmp`` and its volumes.

    """
    return {
        "restart": "unless-stopped",
        "cap_drop": ["ALL"],
        "security_opt": ["no-new-privileges:true"],
        "read_only": True,
        "tmpfs": ["/tmp", *writable],  # noqa: S108 - of the container
        # A fault of ours, or of somebody else, must not take the machine with it.
        "mem_limit": memory,
        "pids_limit": _MOST_TASKS,
        # Without it the program would be process 1 and had to reap orphans itself.
        "init": True,
        "logging": {"driver": "json-file", "options": _SMALL},
        **more,
    }


def _hub_service(port: int, hosts: Iterable[str]) -> dict[str, object]:
    words = ["hub", "--data", "/data", "--host", "0.0.0.0", "--port", "8443"]  # noqa: S104 - a server
    for host in ("127.0.0.1", *hosts):
        words += ["--allow-host", host]
    return _base_service(
        {
            "build": {"context": ".", "dockerfile": "hub.Dockerfile"},
            "command": words,
            "ports": [f"{port}:8443"],
            "volumes": ["hub-data:/data"],
            "stop_grace_period": "15s",
            "healthcheck": {
                "test": ["CMD", "python", "-c", _HEALTH],
                "interval": "10s",
                "timeout": "5s",
                "retries": 6,
                "start_period": "30s",
            },
        },
        "4g",
    )


def _gateway_service(ros_domain: int | None, arch: str) -> dict[str, object]:
    words = ["gateway", "/etc/talaia/site.yaml", "--key-file", "/link/gateway.key"]
    words += ["--data", "/data"]
    if ros_domain is not None:
        words += ["--ros-domain", str(ros_domain)]
    return _base_service(
        {
            "build": {"context": ".", "dockerfile": "gateway.Dockerfile"},
            **({"platform": f"linux/{arch}"} if arch else {}),
            "command": words,
            # DDS finds robots by multicast and speaks through shared memory: both need the host's.
            "network_mode": "host",
            "ipc": "host",
            "volumes": [
                "./site.yaml:/etc/talaia/site.yaml:ro",
                "link:/link:ro",
                "gateway-data:/data",
            ],
            # Its home cannot be written, and ROS gives up without a place for its log.
            "environment": {"ROS_LOG_DIR": "/tmp"},  # noqa: S108 - of the container
            # It starts when the key lies in the volume.
            "depends_on": {"enrol": {"condition": "service_completed_successfully"}},
        },
        "2g",
    )


def _mariadb_services() -> dict[str, object]:
    return {
        "database": _base_service(
            {
                "image": IMAGES["mariadb"],
                "user": _DATABASE_USER,
                "environment": {
                    "MARIADB_DATABASE": "talaia",
                    "MARIADB_USER": "talaia",
                    "MARIADB_PASSWORD_FILE": "/run/secrets/database_password",
                    "MARIADB_ROOT_PASSWORD_FILE": "/run/secrets/database_root_password",
                },
                "command": ["--character-set-server=utf8mb4", "--max-allowed-packet=64M"],
                "secrets": ["database_password", "database_root_password"],
                "volumes": ["database:/var/lib/mysql"],
                "healthcheck": {
                    "test": ["CMD", "healthcheck.sh", "--connect", "--innodb_initialized"],
                    "interval": "5s",
                    "timeout": "5s",
                    "retries": 24,
                },
            },
            "2g",
            ["/run/mysqld"],
        )
    }


def _phpmyadmin_service() -> dict[str, object]:
    """On this machine only; whoever signs in there gives the database's own name and password.

    Its image writes its settings as it starts, and its Apache begins as root and becomes another:
    the two rights to do that are all that it has.
    """
    return _base_service(
        {
            "image": IMAGES["phpmyadmin"],
            "environment": {"PMA_HOST": "database"},
            "read_only": False,
            "cap_add": ["SETGID", "SETUID"],
            "ports": ["127.0.0.1:8081:80"],
            "depends_on": {"database": {"condition": "service_healthy"}},
        },
        "512m",
    )


def _postgresql_services() -> dict[str, object]:
    return {
        "database": _base_service(
            {
                "image": IMAGES["postgresql"],
                "user": _DATABASE_USER,
                "environment": {
                    "POSTGRES_DB": "talaia",
                    "POSTGRES_USER": "talaia",
                    "POSTGRES_PASSWORD_FILE": "/run/secrets/database_password",
                },
                "secrets": ["database_password"],
                "volumes": ["database:/var/lib/postgresql/data"],
                "healthcheck": {
                    "test": ["CMD", "pg_isready", "-U", "talaia", "-d", "talaia"],
                    "interval": "5s",
                    "timeout": "5s",
                    "retries": 24,
                },
            },
            "2g",
            ["/var/run/postgresql"],
        )
    }


def _literal_text(value: object) -> object:
    """Double every ``$``, which compose would take for a variable."""
    if isinstance(value, str):
        return value.replace("$", "$$")
    if isinstance(value, dict):
        return {key: _literal_text(item) for key, item in value.items()}
    return [_literal_text(item) for item in value] if isinstance(value, list) else value
