"""The page that stands beside a deployment's files and says how to start it."""

from __future__ import annotations

import re
from typing import TYPE_CHECKING

from talaia.deploy.containers import TABLES_PORT
from talaia.deploy.options import DatabaseKind
from talaia.deploy.several_hubs import HISTORY_FILE, history_names, hub_names

if TYPE_CHECKING:
    from talaia.deploy.options import DeployOptions
    from talaia.model.site import Site

__all__ = ["write_readme"]

# Where CommonMark may see mark-up; a backslash before it takes that away.
_MARKS = re.compile(r"([\\`*_{}\[\]()#+!|<>~-])")


def _plain_text(text: str) -> str:
    """Give a name as it is read, whatever it holds: no mark-up, no line end."""
    shown = "".join(letter if letter.isprintable() else " " for letter in text)
    return _MARKS.sub(r"\\\1", shown)


def write_readme(site: Site, choice: DeployOptions) -> str:
    """Write the page of one deployment."""
    database, port, setup = choice.database, choice.port, choice.setup
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
    several = choice.hubs > 1
    first_hub = hub_names(choice.hubs)[0] if several else "hub  "
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
docker compose logs {first_hub}        # shows the link with which the first admin is made
```

The dashboard is at https://localhost:{port}. Its certificate is its own: compare the \
fingerprint your browser shows with the one in the hub's log, or give it yours (`--tls-cert`, \
`--tls-key`).
{secrets}{table_note}{_several_text(choice) if several else ""}
The gateway runs in the host's network, where DDS finds the robot. Its key is made at the \
first start, by the service `enrol`, and kept in the volume `link`. To make another, remove \
that volume.

Talaia's own wheels lie in `wheels/`, and the build takes them from nowhere else. What they \
need is installed by version and hash (`locks/`): what does not fit ends the build. The images \
of others stand by their tags; `talaia generate --force --pin IMAGE@sha256:…` writes their \
digests.

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

{_keep_text(choice)}
"""


def _keep_text(choice: DeployOptions) -> str:
    if choice.hubs > 1:
        return (
            "Back up the database with its own tools (`pg_dump`), and the volume `hub-data`: "
            "`seal.key` and the certificate are there, "
            + (
                f"and what is on its way. Recordings and pictures are in {choice.files.url}: keep "
                "versions there, or a copy of it."
                if choice.files is not None
                else "recordings and pictures, too."
            )
        )
    return (
        "`docker compose exec hub talaia backup --help` copies accounts and history while they are "
        "in use."
    )


def _several_text(choice: DeployOptions) -> str:
    """Say what several hubs are, here and in Kubernetes."""
    names = hub_names(choice.hubs)
    create = "kubectl -n talaia create secret generic"
    bucket = choice.files
    kept = (
        "recordings, pictures and imports" if bucket is None else "imports and what is on its way"
    )
    bucket_text, bucket_secrets = "", ""
    if bucket is not None:
        bucket_text = (
            f"\n\nRecordings, films and the archive's pictures are in `{bucket.url}`; the key to "
            "it is in `secrets/files_key`. What lay in a folder before is moved there by `docker "
            f"compose run --rm {names[0]} move-files --data /data` and the options `--files…` of "
            "`compose.yaml`, while no hub runs."
        )
        bucket_secrets = "".join(
            f" \\\n  --from-file=secrets/{name}" for name in sorted(bucket.secrets)
        )
    kept_text = bucket_text + _history_text(choice)
    database_pods = _history_pods(choice, create)
    hub_secrets = bucket_secrets + _history_secrets(choice)
    return f"""
### Several hubs

{choice.hubs} hubs (`{names[0]}` to `{names[-1]}`) are one: one of them leads, the others hand \
through and take over. HAProxy (`haproxy.cfg`) lets TLS pass through to any that is ready. All \
have the volume `hub-data`, where `seal.key`, the certificate, {kept} are.{kept_text} \
On one machine this bears a hub that dies or is replaced, and no machine that dies: for that, \
Kubernetes (below), or several machines by hand (`talaia docs scale`).

A new version, hub by hub:

```sh
docker compose build
for hub in {" ".join(names)}; do docker compose up --detach --no-deps --wait "$hub"; done
```

From one hub on PostgreSQL to several: `talaia generate … --hubs {choice.hubs} --force` into the \
folder of before, `docker compose stop hub`, then `docker compose up --build --detach \
--remove-orphans`. Passwords, database and data folder stay.

### In Kubernetes

`kubernetes/` has plain manifests. Secrets are made of the files here, and stand in none of them:

```sh
# The image, to a registry of yours; name that in kubernetes/kustomization.yaml.
docker build -f hub.Dockerfile -t registry.example/talaia-hub:{choice.tag} .
docker push registry.example/talaia-hub:{choice.tag}
kubectl apply -f kubernetes/namespace.yaml
{create} talaia-hub --from-file=database_url=secrets/kubernetes_database_url \\
  --from-file=secrets/cluster_url --from-file=secrets/internal_ca.pem{hub_secrets}
{create} talaia-nats --from-file=secrets/nats.conf \\
  --from-file=secrets/nats_cert.pem --from-file=secrets/nats_key.pem
{create} talaia-database --from-file=secrets/database_password \\
  --from-file=secrets/database_cert.pem --from-file=secrets/database_key.pem{database_pods}
kubectl apply -k kubernetes
# Shows the link with which the first admin is made.
kubectl -n talaia logs --prefix --selector app.kubernetes.io/name=hub
```

The claim `hub-data` is for all hubs at once (`ReadWriteMany`: NFS, CephFS, a cloud's file store); \
where that is not the default class, name one in `hubs.yaml`. The database is one pod with one \
disk: for one that outlives its machine, put the URL of yours into the secret `talaia-hub`, and \
take `database.yaml` out of `kustomization.yaml`. Gateways are not in the cluster but with their \
robots: enrol each with a code from the page Gateways.
"""


def _history_text(choice: DeployOptions) -> str:
    """Say where histories are, where they have databases of their own."""
    names = history_names(choice.history_servers)
    if not names:
        return ""
    listed = ", ".join(f"`{name}`" for name in names)
    moving = (
        f"docker compose exec {hub_names(choice.hubs)[0]} talaia history move SITE --to "
        f"{names[-1]} --data /data --history-servers /run/secrets/{HISTORY_FILE}"
    )
    if choice.shards:
        return _shards_text(names, listed)
    return (
        f"\n\nHistories are in databases of their own ({listed}; `secrets/{HISTORY_FILE}`), all "
        f"else in `database`. A new site's history is in `{names[0]}`; `{moving}` moves one while "
        "all goes on. Back up each with its own tools, all at the same time."
    )


def _shards_text(names: list[str], listed: str) -> str:
    return (
        f"\n\nSites are divided among {len(names) + 1} leads: histories are in databases of their "
        f"own ({listed}; `secrets/{HISTORY_FILE}`), and each has a lead for its sites; the shard "
        "`main` has all else. A new site goes where the fewest are. People, scripts and gateways "
        "come to any hub and see all sites. A hub that leads nothing takes over at once; where "
        "there is none, one leads two shards after a few seconds, and bears both. To change the "
        "shards, or to take a site to another one (`talaia history move`), end all hubs first. "
        "Back up each database with its own tools, all at the same time."
    )


def _history_secrets(choice: DeployOptions) -> str:
    if not choice.history_servers:
        return ""
    return (
        f" \\\n  --from-file={HISTORY_FILE}=secrets/kubernetes_{HISTORY_FILE}"
        " \\\n  --from-file=secrets/history_ca.pem"
    )


def _history_pods(choice: DeployOptions, create: str) -> str:
    return "".join(
        f"\n{create} talaia-{name} --from-file=secrets/{name}_password \\\n"
        f"  --from-file=secrets/{name}_cert.pem --from-file=secrets/{name}_key.pem"
        for name in history_names(choice.history_servers)
    )
