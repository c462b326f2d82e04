"""The page that stands beside a deployment's files and says how to start it."""

from __future__ import annotations

import re
from typing import TYPE_CHECKING

from talaia.deploy.containers import TABLES_PORT, DatabaseKind

if TYPE_CHECKING:
    from talaia.model.site import Site

__all__ = ["write_readme"]

# Where CommonMark may see mark-up; a backslash before it takes that away.
_MARKS = re.compile(r"([\\`*_{}\[\]()#+!|<>~-])")


def _plain_text(text: str) -> str:
    """Give a name as it is read, whatever it holds: no mark-up, no line end."""
    shown = "".join(letter if letter.isprintable() else " " for letter in text)
    return _MARKS.sub(r"\\\1", shown)


def write_readme(site: Site, database: DatabaseKind, port: int, setup: str) -> str:
    """Write the page of one deployment."""
    secrets = (
        ""
        if database is DatabaseKind.SQLITE
        else "\n`secrets/` holds random passwords that were made for you. Keep them out of version "
        "control (`.gitignore` does) and out of chats.\n"
    )
    table_note = (
        "\n`docker compose --profile phpmyadmin up --detach` also starts phpMyAdmin, to look at "
        f"the tables, on http://127.0.0.1:{TABLES_PORT} (user `talaia`, password in "
        "`secrets/database_password`): each sensor is a view of its own name.\n"
        if database is DatabaseKind.MARIADB
        else ""
    )
    ros = (
        "The unit reads `" + setup.replace("`", "") + "` first.\n"
        if setup
        else "A ROS 2 of the system's is found below `/opt/ros` and used by its own Python, "
        "whatever Python the environment has: `talaia doctor` says which. This is the way on "
        "arm64 (Jetson, Raspberry Pi), for which there are no ROS 2 wheels. Where a workspace has "
        "messages of your own, generate again with `--ros-setup /path/to/install/setup.bash`.\n"
    )
    return f"""\
# {_plain_text(site.name)}

A Talaia control room for the site `{site.site}`, made by `talaia generate`.

## In containers

```sh
docker compose up --build --detach
docker compose logs hub          # shows the link with which the first admin is made
```

The dashboard is at https://localhost:{port}. Its certificate is its own: compare the \
fingerprint your browser shows with the one in the hub's log, or give it yours (`--tls-cert`, \
`--tls-key`).
{secrets}{table_note}
The gateway runs in the host's network, where DDS finds the robot. Its key is made at the \
first start, by the service `enrol`, and kept in the volume `link`. To make another, remove \
that volume.

Talaia's own wheel lies in `wheels/`, and the build takes it from nowhere else. What it needs is \
installed by version and hash (`locks/`): what does not fit ends the build. The images of others \
stand by their tags; `talaia generate --force --pin IMAGE@sha256:…` writes their digests.

## The gateway on the robot's own computer

```sh
sudo useradd --system --no-create-home talaia
sudo python3 -m venv /opt/talaia && sudo /opt/talaia/bin/pip install 'talaia[gateway]'
sudo install -d /etc/talaia/{site.site} && sudo install -m 644 site.yaml /etc/talaia/{site.site}/
# trade the code from the page Gateways for a key:
sudo /opt/talaia/bin/talaia gateway enrol --help
sudo install -m 644 systemd/talaia-gateway-{site.site}.service /etc/systemd/system/
sudo systemctl enable --now talaia-gateway-{site.site}
```

{ros}
The key file is `/etc/talaia/{site.site}/gateway.key`, owned by the user `talaia`.

## Keep it

`docker compose exec hub talaia backup --help` copies accounts and history while they are in use.
"""
