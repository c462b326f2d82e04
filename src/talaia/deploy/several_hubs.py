"""A compose project of several hubs: HAProxy before them, NATS and PostgreSQL behind them."""

from __future__ import annotations

from typing import TYPE_CHECKING

from talaia.deploy.containers import (
    base_service,
    dump_project,
    enrol_service,
    gateway_service,
    hub_service,
    hub_words,
    postgresql_service,
)

if TYPE_CHECKING:
    from collections.abc import Iterable, Sequence

    from talaia.deploy.options import FilesChoice

__all__ = [
    "CLUSTER_IMAGES",
    "HISTORY_FILE",
    "NATS_PORT",
    "SECRET_FOLDER",
    "history_names",
    "hub_names",
    "write_balancer_config",
    "write_bus_config",
    "write_compose_of_several",
]

CLUSTER_IMAGES = {"nats": "nats:2.11-alpine", "haproxy": "haproxy:3.0-alpine"}
# Where containers read their secrets, in compose and in Kubernetes.
SECRET_FOLDER = "/run/secrets"  # noqa: S105 - a folder
NATS_PORT = 4222
# Which databases have histories, with their passwords.
HISTORY_FILE = "history_servers.yaml"
# Numbers, as for the databases: HAProxy's own user in its image, and nobody.
_HAPROXY_USER, _NATS_USER = "99:99", "65534:65534"
# HAProxy's own word whether any hub is ready, and NATS's; each in its own container alone.
_STATE_PORT, _NATS_STATE_PORT = 8404, 8222
# Where Docker puts its networks: HAProxy's address is one of theirs. A hub has no port on the host,
# so nobody else comes to it by one of these.
_CONTAINER_NETWORKS = ("10.0.0.0/8", "172.16.0.0/12", "192.168.0.0/16")


def hub_names(hubs: int) -> list[str]:
    """Name the hubs, which are services of these names."""
    return [f"hub-{number}" for number in range(1, hubs + 1)]


def history_names(count: int) -> list[str]:
    """Name the databases of histories, which are services of these names."""
    return [f"history-{number}" for number in range(1, count + 1)]


def write_compose_of_several(
    site: str,
    *,
    hubs: int,
    port: int,
    hosts: Iterable[str],
    ros_domain: int | None,
    arch: str = "",
    files: FilesChoice | None = None,
    history_servers: int = 0,
) -> str:
    """Write ``compose.yaml`` for several hubs; see `write_compose_file` for the rest.

    Args:
        site: the site's short name.
        hubs: how many.
        port: of the dashboard, on the host; behind it is HAProxy.
        hosts: names under which the dashboard is reached, beside the machine's own.
        ros_domain: the ROS domain; none leaves it to the description.
        arch: of the gateway's machine, ``arm64``; empty is the builder's own.
        files: bucket in which hubs keep recordings and pictures; none: the volume that they share.
        history_servers: how many databases of their own histories have.

    """
    histories = history_names(history_servers)
    names, hosts = hub_names(hubs), tuple(hosts)
    enrol = enrol_service(site, port, names[0])
    enrol |= {"networks": ["back"], **_database_access()}
    services: dict[str, object] = {
        "database": postgresql_service(["back"]),
        **{name: postgresql_service(["back"], name) for name in histories},
        "nats": _nats_service(),
        **{
            name: _one_of_several(name, names, hosts, files=files, histories=histories)
            for name in names
        },
        "haproxy": _haproxy_service(port, names),
        "enrol": enrol,
        "gateway": gateway_service(ros_domain, arch),
    }
    secrets = (
        *("database_password", "database_url", "cluster_url", "internal_ca.pem"),
        *("nats.conf", "nats_cert.pem", "nats_key.pem"),
        *(files.secrets if files is not None else ()),
        *([HISTORY_FILE] if histories else ()),
        *(f"{name}_password" for name in histories),
    )
    project: dict[str, object] = {
        "services": services,
        # Behind the hubs nothing is reached from outside, and nothing reaches out.
        "networks": {"front": {}, "back": {"internal": True}},
        # `hub-data` is one for all hubs.
        "volumes": {
            name: {} for name in ("hub-data", "link", "gateway-data", "database", *histories)
        },
        "secrets": {name: {"file": f"./secrets/{name}"} for name in secrets},
    }
    return dump_project(project)


def write_bus_config(password: str) -> str:
    """Write ``nats.conf``, which holds the hubs' password.

    Args:
        password: of letters and digits.

    """
    return f"""\
# Made by `talaia generate`. Core NATS alone: it keeps nothing.
listen: "0.0.0.0:{NATS_PORT}"
http: "127.0.0.1:{_NATS_STATE_PORT}"
tls {{
  cert_file: "{SECRET_FOLDER}/nats_cert.pem"
  key_file: "{SECRET_FOLDER}/nats_key.pem"
}}
authorization {{
  users: [
    {{
      user: "talaia", password: "{password}"
      permissions: {{ publish: "talaia.>", subscribe: "talaia.>" }}
    }}
  ]
}}
"""


def write_balancer_config(hubs: Sequence[str]) -> str:
    """Write ``haproxy.cfg``: TLS passes through, to any hub that is ready."""
    servers = "\n".join(f"  server {hub} {hub}:8443" for hub in hubs)
    return f"""\
# Made by `talaia generate --hubs {len(hubs)}`.
global
  log stdout format raw local0 notice
  # Two for each connection; where the system allows less, HAProxy makes do with that.
  fd-hard-limit 50000

defaults
  mode tcp
  log global
  timeout connect 2s
  # Pages and gateways say something every second or so; a line that says nothing is dead.
  timeout client 2m
  timeout server 2m
  # A hub that has just closed its door: the next one.
  retries 3
  option redispatch 1

# Containers get another address when they start again.
resolvers containers
  parse-resolv-conf
  hold valid 1s

frontend dashboard
  bind :8443
  default_backend hubs

backend hubs
  # No session sticks to a hub; sockets last for days, so the one with the fewest is next.
  balance leastconn
  option httpchk GET /api/ready
  http-check send hdr Host 127.0.0.1
  http-check expect status 200
  timeout check 2s
  # A hub's own certificate is for browsers and gateways, whose TLS passes through here; a check
  # only asks whether the hub is ready. `send-proxy-v2` tells the hub who comes. Sessions of a hub
  # that is late with its answer stay: gateways and pages notice one that is gone within seconds,
  # and to cut off all at once makes a busy hub busier.
  default-server check check-ssl verify none inter 500ms fall 2 rise 1 send-proxy-v2 \
check-send-proxy resolvers containers init-addr last,libc,none
{servers}

# For whoever watches this process.
frontend state
  mode http
  bind 127.0.0.1:{_STATE_PORT}
  timeout client 5s
  monitor-uri /
  monitor fail if {{ nbsrv(hubs) lt 1 }}
"""


def _database_access() -> dict[str, object]:
    return {
        "environment": {"TALAIA_DATABASE_URL_FILE": f"{SECRET_FOLDER}/database_url"},
        "secrets": ["database_url"],
    }


def _one_of_several(
    name: str,
    names: Sequence[str],
    hosts: Iterable[str],
    *,
    files: FilesChoice | None,
    histories: Sequence[str],
) -> dict[str, object]:
    words = hub_words(hosts)
    words += ["--cluster-file", f"{SECRET_FOLDER}/cluster_url", "--cluster-name", name]
    words += ["--cluster-ca", f"{SECRET_FOLDER}/internal_ca.pem"]
    for network in _CONTAINER_NETWORKS:
        words += ["--proxy-protocol", network]
    secrets = ["database_url", "cluster_url", "internal_ca.pem"]
    if files is not None:
        words += files.hub_words(SECRET_FOLDER)
        secrets += files.secrets
    if histories:
        # A hub starts without them, and uses each as soon as it is there.
        words += ["--history-servers", f"{SECRET_FOLDER}/{HISTORY_FILE}"]
        secrets.append(HISTORY_FILE)
    # The first makes the tables and the keys that all have; the others come once it is there.
    after: dict[str, object] = {
        "database": {"condition": "service_healthy"},
        "nats": {"condition": "service_started"},
    }
    if name != names[0]:
        after[names[0]] = {"condition": "service_healthy"}
    return hub_service(
        hosts,
        {
            "command": words,
            "environment": {"TALAIA_DATABASE_URL_FILE": f"{SECRET_FOLDER}/database_url"},
            "secrets": secrets,
            "networks": ["front", "back"],
            "depends_on": after,
            # It hands its pages and gateways over first.
            "stop_grace_period": "30s",
        },
    )


def _haproxy_service(port: int, names: Sequence[str]) -> dict[str, object]:
    return base_service(
        {
            "image": CLUSTER_IMAGES["haproxy"],
            "user": _HAPROXY_USER,
            "volumes": ["./haproxy.cfg:/usr/local/etc/haproxy/haproxy.cfg:ro"],
            "ports": [f"{port}:8443"],
            "networks": ["front"],
            "depends_on": {names[0]: {"condition": "service_healthy"}},
            "healthcheck": _web_check(_STATE_PORT, "/"),
        },
        "512m",
    )


def _nats_service() -> dict[str, object]:
    return base_service(
        {
            "image": CLUSTER_IMAGES["nats"],
            "user": _NATS_USER,
            "command": ["--config", f"{SECRET_FOLDER}/nats.conf"],
            "secrets": ["nats.conf", "nats_cert.pem", "nats_key.pem"],
            "networks": ["back"],
            "healthcheck": _web_check(_NATS_STATE_PORT, "/healthz"),
        },
        "512m",
    )


def _web_check(port: int, path: str) -> dict[str, object]:
    # Of both images' busybox.
    return {
        "test": ["CMD", "wget", "--quiet", "--spider", f"http://127.0.0.1:{port}{path}"],
        "interval": "5s",
        "timeout": "3s",
        "retries": 6,
    }
