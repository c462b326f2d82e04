"""A compose project: hub, database, gateway; every value goes through a serializer.

Secrets are files that `talaia generate` fills with random words; there is no default password
anywhere. The gateway's key never leaves the machine: a one-shot service makes it at the first
start and hands it over in a volume.

Long, because each service with all that bounds it stands here, in one place.
"""

from __future__ import annotations

import json
from typing import TYPE_CHECKING

import yaml

from talaia.deploy.locks import built_packages
from talaia.deploy.options import DatabaseKind

if TYPE_CHECKING:
    from collections.abc import Iterable, Mapping, Sequence

__all__ = [
    "DATABASE_USER",
    "IMAGES",
    "TABLES_PORT",
    "TABLES_SECRET",
    "USER",
    "base_service",
    "dump_project",
    "enrol_service",
    "gateway_service",
    "hub_service",
    "hub_words",
    "install_steps",
    "postgresql_service",
    "write_compose_file",
    "write_dockerfile",
    "write_steps",
]

# By tag: to build anew brings the fixes of what lies below. `--pin` adds digests.
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
DATABASE_USER = "999:999"
# The one of phpMyAdmin's Apache, which its image is also tried with.
_WEB_USER = "33:33"
# What phpMyAdmin seals its cookies with, as its image wants it.
TABLES_SECRET = "phpmyadmin.php"  # noqa: S105 - a file's name
# Where phpMyAdmin is, on the host itself.
TABLES_PORT = 8081
# Threads and processes of one container.
_MOST_TASKS = 1024


def write_dockerfile(
    image: str, extras: Sequence[str], version: str, debian: Iterable[str] = ()
) -> str:
    """Write an image's recipe: Talaia, what the lock file of its name names, and nobody's root.

    Args:
        image: ``hub`` or ``gateway``; ``locks/`` holds a file of its name.
        extras: of Talaia.
        version: of Talaia, whose wheel is in ``wheels/``.
        debian: packages of the system's.

    """
    packages = " ".join(debian)
    system = (
        f"RUN apt-get update && apt-get install -y --no-install-recommends {packages} \\\n"
        "    && rm -rf /var/lib/apt/lists/*\n"
        if packages
        else ""
    )
    return f"""\
FROM {PYTHON_IMAGE}
{system}COPY wheels/ /wheels/
COPY locks/ /locks/
{write_steps(install_steps(["pip", "install", "--no-cache-dir"], image, extras, version))}
RUN groupadd --gid 10001 talaia && useradd --uid 10001 --gid 10001 --no-create-home talaia \\
    && install -d -o talaia -g talaia -m 0700 /data /link
USER {USER}
ENV PYTHONUNBUFFERED=1
ENTRYPOINT ["talaia"]
"""


def install_steps(
    install: Sequence[str], image: str, extras: Sequence[str], version: str
) -> list[list[str]]:
    """Give the steps that install Talaia: by hash what is of others, and no name from an index.

    Args:
        install: how pip's installation is called.
        image: whose lock file it is, as `write_dockerfile`.
        extras: of Talaia.
        version: of Talaia.

    """
    wanted = f"talaia[{','.join(extras)}]=={version}"
    locked = [*install, "--require-hashes", "--only-binary", ":all:"]
    steps: list[list[str]] = []
    # To build a package, pip would fetch its builder without hashes. So one that has no wheel is
    # built by what a step before installs, and nothing else may be built.
    building: list[str] = []
    if built := built_packages(extras):
        steps = [[*locked, "-r", "/locks/build.txt"]]
        building = ["--no-build-isolation", *(f"--no-binary={package}" for package in built)]
    steps.append([*locked, *building, "-r", f"/locks/{image}.txt"])
    # Without an index: what a lock lacks ends the build, and is not looked for elsewhere.
    return [*steps, [*install, "--no-index", "--find-links", "/wheels", wanted]]


def write_steps(steps: Iterable[Sequence[str]]) -> str:
    """Write steps as lists, which a recipe runs without a shell: brackets stay what they are."""
    return "\n".join(f"RUN {json.dumps(step)}" for step in steps)


def write_compose_file(
    site: str,
    *,
    database: DatabaseKind,
    port: int,
    hosts: Iterable[str],
    ros_domain: int | None,
    arch: str = "",
) -> str:
    """Write ``compose.yaml``.

    Args:
        site: the site's short name.
        database: where accounts and history are kept.
        port: of the dashboard, on the host.
        hosts: names under which the dashboard is reached, beside the machine's own.
        ros_domain: the ROS domain; none leaves it to the description.
        arch: of the gateway's machine, ``arm64``; empty is the builder's own.

    """
    services: dict[str, object] = {}
    secrets: dict[str, object] = {}
    volumes: dict[str, object] = {"hub-data": {}, "link": {}, "gateway-data": {}}
    hub, enrol = hub_service(hosts, {"ports": [f"{port}:8443"]}), enrol_service(site, port)
    if database is not DatabaseKind.SQLITE:
        if database is DatabaseKind.MARIADB:
            services |= _mariadb_services()
            services["phpmyadmin"] = _phpmyadmin_service()
        else:
            services["database"] = postgresql_service()
        volumes["database"] = {}
        secrets = {name: {"file": f"./secrets/{name}"} for name in _secret_files(database)}
        # Both open the database.
        for service in (hub, enrol):
            service["environment"] = {"TALAIA_DATABASE_URL_FILE": "/run/secrets/database_url"}
            service["secrets"] = ["database_url"]
        hub["depends_on"] = {"database": {"condition": "service_healthy"}}
    # In the order in which they start, for whoever reads the file.
    services |= {"hub": hub, "enrol": enrol, "gateway": gateway_service(ros_domain, arch)}
    # Secrets only where there is a database: compose refuses a list of none.
    project: dict[str, object] = {"services": services, "volumes": volumes}
    if secrets:
        project["secrets"] = secrets
    return dump_project(project)


def dump_project(project: Mapping[str, object]) -> str:
    """Write a compose project: each value on a line of its own, none taken for a variable."""
    return yaml.safe_dump(_literal_text(dict(project)), sort_keys=False, width=1_000_000)


def _secret_files(database: DatabaseKind) -> list[str]:
    root = ["database_root_password"] if database is DatabaseKind.MARIADB else []
    return ["database_password", *root, "database_url"]


def base_service(
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


def hub_words(hosts: Iterable[str], data: str = "/data") -> list[str]:
    """Write the words of a hub in a container."""
    words = ["hub", "--data", data, "--host", "0.0.0.0", "--port", "8443"]  # noqa: S104 - a server
    # The first is what the health check dials; without it the hub would refuse its own host.
    for host in ("127.0.0.1", *hosts):
        words += ["--allow-host", host]
    return words


def hub_service(hosts: Iterable[str], more: Mapping[str, object]) -> dict[str, object]:
    """Write a hub; ``more`` is what this one has besides."""
    return base_service(
        {
            "build": {"context": ".", "dockerfile": "hub.Dockerfile"},
            "command": hub_words(hosts),
            "volumes": ["hub-data:/data"],
            "stop_grace_period": "15s",
            "healthcheck": {
                "test": ["CMD", "python", "-c", _HEALTH],
                "interval": "10s",
                "timeout": "5s",
                "retries": 6,
                "start_period": "30s",
            },
            **more,
        },
        "4g",
    )


def enrol_service(site: str, port: int, hub: str = "hub") -> dict[str, object]:
    """Write what makes the gateway's key and ends; it is tried again only until that has worked."""
    address = f"wss://127.0.0.1:{port}"
    words = ["enrol", site, "--data", "/data", "--to", "/link/gateway.key", "--hub", address]
    return base_service(
        {
            "build": {"context": ".", "dockerfile": "hub.Dockerfile"},
            "command": words,
            "restart": "on-failure",
            # The hub's certificate is there, whose hash goes into the key file.
            "volumes": ["hub-data:/data", "link:/link"],
            "depends_on": {hub: {"condition": "service_healthy"}},
        },
        "1g",
    )


def gateway_service(ros_domain: int | None, arch: str) -> dict[str, object]:
    """Write the gateway, in the host's own network."""
    words = ["gateway", "/etc/talaia/site.yaml", "--key-file", "/link/gateway.key"]
    # A volume: its spool, and the place that it was handed down, outlive the container.
    words += ["--data", "/data"]
    if ros_domain is not None:
        words += ["--ros-domain", str(ros_domain)]
    return base_service(
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
        "database": base_service(
            {
                "image": IMAGES["mariadb"],
                "user": DATABASE_USER,
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
    """Started only when its profile is asked for, and reached on this machine only.

    Whoever signs in there gives the database's own name and password.
    """
    return base_service(
        {
            "image": IMAGES["phpmyadmin"],
            "profiles": ["phpmyadmin"],
            # Apache as its own user from the start: as root it would need two capabilities to
            # become it. The port below 1024 is then open to it by the sysctl.
            "user": _WEB_USER,
            "sysctls": {"net.ipv4.ip_unprivileged_port_start": "0"},
            "environment": {"PMA_HOST": "database"},
            # The image would write that file at the start, into a root that cannot be written.
            "volumes": [f"./secrets/{TABLES_SECRET}:/etc/phpmyadmin/config.secret.inc.php:ro"],
            "ports": [f"127.0.0.1:{TABLES_PORT}:80"],
            "depends_on": {"database": {"condition": "service_healthy"}},
        },
        "512m",
        # Apache's locks, the sessions, and templates that phpMyAdmin compiles.
        [
            f"{place}:mode=0700,uid=33,gid=33"
            for place in ("/run", "/sessions", "/var/www/html/tmp")
        ],
    )


def postgresql_service(networks: Sequence[str] = (), name: str = "database") -> dict[str, object]:
    """Write a database of PostgreSQL: its volume is ``name``, its password in a file of it."""
    return base_service(
        {
            "image": IMAGES["postgresql"],
            "user": DATABASE_USER,
            "environment": {
                "POSTGRES_DB": "talaia",
                "POSTGRES_USER": "talaia",
                "POSTGRES_PASSWORD_FILE": f"/run/secrets/{name}_password",
            },
            "secrets": [f"{name}_password"],
            "volumes": [f"{name}:/var/lib/postgresql/data"],
            "healthcheck": {
                "test": ["CMD", "pg_isready", "-U", "talaia", "-d", "talaia"],
                "interval": "5s",
                "timeout": "5s",
                "retries": 24,
            },
            **({"networks": list(networks)} if networks else {}),
        },
        "2g",
        ["/var/run/postgresql"],
    )


def _literal_text(value: object) -> object:
    """Double every ``$``, which compose would take for a variable."""
    if isinstance(value, str):
        return value.replace("$", "$$")
    # Keys are ours and hold none.
    if isinstance(value, dict):
        return {key: _literal_text(item) for key, item in value.items()}
    return [_literal_text(item) for item in value] if isinstance(value, list) else value
