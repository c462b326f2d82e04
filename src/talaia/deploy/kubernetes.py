"""Plain Kubernetes manifests for several hubs, with NATS and PostgreSQL behind them.

Secrets are named and never written here: `kubectl` makes them of the files in ``secrets/``. What
stands here fits the standard *restricted* of Kubernetes, which the namespace asks for.

Long, because each object with all that bounds it stands here, in one place.
"""

from __future__ import annotations

from typing import TYPE_CHECKING

import yaml

from talaia.deploy.containers import DATABASE_USER, IMAGES, USER, hub_words
from talaia.deploy.several_hubs import (
    CLUSTER_IMAGES,
    HISTORY_FILE,
    NATS_PORT,
    SECRET_FOLDER,
    history_names,
)

if TYPE_CHECKING:
    from collections.abc import Iterable, Mapping, Sequence

    from talaia.deploy.options import FilesChoice

__all__ = ["HUB_IMAGE", "NAMESPACE", "write_manifests"]

NAMESPACE = "talaia"
# Under this name manifests ask for it; `kustomization.yaml` says where it really is.
HUB_IMAGE = "talaia-hub"
_HUB_PORT, _DATABASE_PORT = 8443, 5432
_NOBODY = "65534:65534"
# A folder of the hub's own in the volume: the volume's root is not its to close to others.
_DATA = "/data/hub"
# Before a hub ends, the service has to have heard of it; meanwhile it goes on serving (s).
_NOTICE_S = 5
# After a machine is gone without a word, what is one alone starts on another (s).
_GONE_S = 20
Manifest = dict[str, object]


def write_manifests(
    hubs: int,
    hosts: Iterable[str],
    version: str,
    *,
    bucket: FilesChoice | None = None,
    history_servers: int = 0,
) -> dict[str, str]:
    """Write the manifests, by the name of their file.

    Args:
        hubs: how many.
        hosts: names under which the dashboard is reached.
        version: of Talaia, by which the hubs' image is tagged.
        bucket: where hubs keep recordings and pictures; none: the claim that they share.
        history_servers: how many databases of their own histories have.

    """
    histories = history_names(history_servers)
    files: dict[str, list[Manifest]] = {
        "namespace.yaml": [_namespace()],
        "database.yaml": _database("database"),
        **{f"{name}.yaml": _database(name) for name in histories},
        "nats.yaml": _nats(),
        "hubs.yaml": _hubs(hubs, _hub_pod(hosts, bucket, histories)),
        "network.yaml": _network_policies(["database", *histories]),
    }
    kustomization: Manifest = {
        "apiVersion": "kustomize.config.k8s.io/v1beta1",
        "kind": "Kustomization",
        "namespace": NAMESPACE,
        "resources": list(files),
        # To be changed to the registry that the cluster reads from.
        "images": [{"name": HUB_IMAGE, "newName": HUB_IMAGE, "newTag": version}],
    }
    files["kustomization.yaml"] = [kustomization]
    return {
        name: yaml.dump_all(
            found, Dumper=_Dumper, sort_keys=False, width=1_000_000, explicit_start=True
        )
        for name, found in files.items()
    }


class _Dumper(yaml.SafeDumper):
    """Writes what stands in two places twice, and without names of its own."""

    def ignore_aliases(self, _data: object) -> bool:
        return True


def _manifest(kind: str, name: str, spec: Mapping[str, object], api: str = "v1") -> Manifest:
    labels = {"app.kubernetes.io/name": name, "app.kubernetes.io/part-of": "talaia"}
    return {
        "apiVersion": api,
        "kind": kind,
        "metadata": {"name": name, "labels": labels},
        "spec": dict(spec),
    }


def _labels(name: str) -> dict[str, str]:
    return {"app.kubernetes.io/name": name}


def _namespace() -> Manifest:
    return {
        "apiVersion": "v1",
        "kind": "Namespace",
        "metadata": {
            "name": NAMESPACE,
            "labels": {"pod-security.kubernetes.io/enforce": "restricted"},
        },
    }


def _pod(user: str, spec: Mapping[str, object]) -> dict[str, object]:
    """Write what all pods have; ``user`` is ``uid:gid``."""
    uid, gid = (int(number) for number in user.split(":"))
    return {
        # None of them speaks to Kubernetes.
        "automountServiceAccountToken": False,
        "enableServiceLinks": False,
        "securityContext": {
            "runAsNonRoot": True,
            "runAsUser": uid,
            "runAsGroup": gid,
            "fsGroup": gid,
            "fsGroupChangePolicy": "OnRootMismatch",
            "seccompProfile": {"type": "RuntimeDefault"},
        },
        **spec,
    }


def _container(
    name: str, image: str, more: Mapping[str, object], *, cpu: str, memory: tuple[str, str]
) -> dict[str, object]:
    """Write what all containers have: no capability, bounds, and a root that cannot be written.

    Args:
        name: of the container.
        image: its image.
        more: of this one.
        cpu: what it is sure to get. There is no limit of it: whoever is slowed down just when much
            happens would hold up STOP.
        memory: what it is sure to get, and what it may take.

    """
    return {
        "name": name,
        "image": image,
        "securityContext": {
            "allowPrivilegeEscalation": False,
            "readOnlyRootFilesystem": True,
            "capabilities": {"drop": ["ALL"]},
        },
        "resources": {
            "requests": {"cpu": cpu, "memory": memory[0]},
            "limits": {"memory": memory[1]},
        },
        **more,
    }


def _template(name: str, pod: Mapping[str, object]) -> dict[str, object]:
    return {"metadata": {"labels": _labels(name)}, "spec": dict(pod)}


def _secret_volume(secret: str) -> dict[str, object]:
    # For the pod's own group only.
    return {"name": "secrets", "secret": {"secretName": secret, "defaultMode": 0o440}}


def _memory_volume(name: str, size: str) -> dict[str, object]:
    return {"name": name, "emptyDir": {"medium": "Memory", "sizeLimit": size}}


def _mount(name: str, path: str) -> dict[str, object]:
    secret = {"readOnly": True} if name == "secrets" else {}
    return {"name": name, "mountPath": path, **secret}


def _service(name: str, ports: list[Manifest], more: Mapping[str, object]) -> Manifest:
    return _manifest("Service", name, {"selector": _labels(name), "ports": ports, **more})


def _after_a_machine() -> list[dict[str, object]]:
    return [
        {
            "key": f"node.kubernetes.io/{state}",
            "operator": "Exists",
            "effect": "NoExecute",
            "tolerationSeconds": _GONE_S,
        }
        for state in ("not-ready", "unreachable")
    ]


def _claim(name: str, mode: str, size: str) -> Manifest:
    wanted = {"accessModes": [mode], "resources": {"requests": {"storage": size}}}
    return _manifest("PersistentVolumeClaim", name, wanted)


# ── hubs ──


def _hubs(hubs: int, pod: Mapping[str, object]) -> list[Manifest]:
    # Connections to a pod that ends are handed on by the service, which keeps the asker's address.
    outside = {"type": "LoadBalancer", "externalTrafficPolicy": "Local", "sessionAffinity": "None"}
    ports: list[Manifest] = [{"name": "https", "port": 443, "targetPort": "https"}]
    budget = {"maxUnavailable": 1, "selector": {"matchLabels": _labels("hub")}}
    deployment = {
        "replicas": hubs,
        "selector": {"matchLabels": _labels("hub")},
        # A new one comes first, and is ready for a while; then an old one goes.
        "strategy": {
            "type": "RollingUpdate",
            "rollingUpdate": {"maxSurge": 1, "maxUnavailable": 0},
        },
        "minReadySeconds": 5,
        "template": _template("hub", pod),
    }
    return [
        # One for all hubs: keys, certificate, imports and what is on its way lie there; recordings
        # and the archive as well, unless they are in a bucket.
        _claim("hub-data", "ReadWriteMany", "50Gi"),
        _manifest("Deployment", "hub", deployment, "apps/v1"),
        _service("hub", ports, outside),
        _manifest("PodDisruptionBudget", "hub", budget, "policy/v1"),
    ]


def _hub_pod(
    hosts: Iterable[str], bucket: FilesChoice | None, histories: Sequence[str]
) -> dict[str, object]:
    words = hub_words(hosts, _DATA)
    words += ["--cluster-file", f"{SECRET_FOLDER}/cluster_url"]
    words += ["--cluster-ca", f"{SECRET_FOLDER}/internal_ca.pem"]
    if bucket is not None:
        words += bucket.hub_words(SECRET_FOLDER)
    if histories:
        words += ["--history-servers", f"{SECRET_FOLDER}/{HISTORY_FILE}"]
    environment: list[Manifest] = [
        {"name": "TALAIA_DATABASE_URL_FILE", "value": f"{SECRET_FOLDER}/database_url"},
        {
            "name": "TALAIA_HUB_CLUSTER_NAME",
            "valueFrom": {"fieldRef": {"fieldPath": "metadata.name"}},
        },
    ]
    container = _container(
        "hub",
        HUB_IMAGE,
        {
            "args": words,
            "env": environment,
            "ports": [{"name": "https", "containerPort": _HUB_PORT}],
            # Tables may have to be made first, and a hub before this one to have left.
            "startupProbe": _hub_probe("/api/health", period=2, timeout=2, failures=60),
            "livenessProbe": _hub_probe("/api/health", period=10, timeout=5, failures=3),
            "readinessProbe": _hub_probe("/api/ready", period=1, timeout=2, failures=2),
            "lifecycle": {"preStop": {"exec": {"command": ["sleep", str(_NOTICE_S)]}}},
            "volumeMounts": [
                _mount("data", "/data"),
                _mount("secrets", SECRET_FOLDER),
                _mount("tmp", "/tmp"),  # noqa: S108 - of the container
            ],
        },
        cpu="500m",
        memory=("512Mi", "4Gi"),
    )
    apart = {
        "maxSkew": 1,
        "topologyKey": "kubernetes.io/hostname",
        # Two on one machine are better than one that waits for a machine.
        "whenUnsatisfiable": "ScheduleAnyway",
        "labelSelector": {"matchLabels": _labels("hub")},
    }
    return _pod(
        USER,
        {
            "terminationGracePeriodSeconds": 45,
            "topologySpreadConstraints": [apart],
            "tolerations": _after_a_machine(),
            "containers": [container],
            "volumes": [
                {"name": "data", "persistentVolumeClaim": {"claimName": "hub-data"}},
                _secret_volume("talaia-hub"),
                _memory_volume("tmp", "256Mi"),
            ],
        },
    )


def _hub_probe(path: str, *, period: int, timeout: int, failures: int) -> dict[str, object]:
    return {
        "httpGet": {
            "path": path,
            "port": "https",
            "scheme": "HTTPS",
            # Else it is the pod's address, which is no name of the hub's.
            "httpHeaders": [{"name": "Host", "value": "127.0.0.1"}],
        },
        "periodSeconds": period,
        "timeoutSeconds": timeout,
        "failureThreshold": failures,
    }


# ── behind them ──


def _nats() -> list[Manifest]:
    probe = {"tcpSocket": {"port": "nats"}, "periodSeconds": 5, "failureThreshold": 3}
    container = _container(
        "nats",
        CLUSTER_IMAGES["nats"],
        {
            "args": ["--config", f"{SECRET_FOLDER}/nats.conf"],
            "ports": [{"name": "nats", "containerPort": NATS_PORT}],
            "readinessProbe": probe,
            "livenessProbe": probe | {"periodSeconds": 10},
            "volumeMounts": [_mount("secrets", SECRET_FOLDER)],
        },
        cpu="200m",
        memory=("64Mi", "512Mi"),
    )
    pod = _pod(
        _NOBODY,
        {
            "tolerations": _after_a_machine(),
            "containers": [container],
            "volumes": [_secret_volume("talaia-nats")],
        },
    )
    deployment = {
        "replicas": 1,
        "selector": {"matchLabels": _labels("nats")},
        # Two that do not know each other would each have a half of the hubs.
        "strategy": {"type": "Recreate"},
        "template": _template("nats", pod),
    }
    ports: list[Manifest] = [{"name": "nats", "port": NATS_PORT, "targetPort": "nats"}]
    return [
        _manifest("Deployment", "nats", deployment, "apps/v1"),
        _service("nats", ports, {}),
    ]


def _database(name: str) -> list[Manifest]:
    """Write a PostgreSQL; the files of its secret begin with its name."""
    folder = "/var/lib/postgresql/data"
    probe = {"exec": {"command": ["pg_isready", "-U", "talaia", "-d", "talaia"]}}
    environment = {
        "POSTGRES_DB": "talaia",
        "POSTGRES_USER": "talaia",
        "POSTGRES_PASSWORD_FILE": f"{SECRET_FOLDER}/{name}_password",
        # A volume's root may hold more than the database.
        "PGDATA": f"{folder}/pgdata",
    }
    tls = {
        "ssl": "on",
        "ssl_cert_file": f"{SECRET_FOLDER}/{name}_cert.pem",
        "ssl_key_file": f"{SECRET_FOLDER}/{name}_key.pem",
    }
    container = _container(
        "postgresql",
        IMAGES["postgresql"],
        {
            "args": [word for option, value in tls.items() for word in ("-c", f"{option}={value}")],
            "env": [{"name": key, "value": value} for key, value in environment.items()],
            "ports": [{"name": "postgresql", "containerPort": _DATABASE_PORT}],
            "startupProbe": {**probe, "periodSeconds": 2, "failureThreshold": 60},
            "readinessProbe": {**probe, "periodSeconds": 5, "timeoutSeconds": 5},
            "livenessProbe": {
                **probe,
                "periodSeconds": 20,
                "timeoutSeconds": 10,
                "failureThreshold": 6,
            },
            "volumeMounts": [
                _mount("data", folder),
                _mount("secrets", SECRET_FOLDER),
                _mount("run", "/var/run/postgresql"),
                _mount("tmp", "/tmp"),  # noqa: S108 - of the container
            ],
        },
        cpu="500m",
        memory=("512Mi", "2Gi"),
    )
    pod = _pod(
        DATABASE_USER,
        {
            "terminationGracePeriodSeconds": 60,
            "containers": [container],
            "volumes": [
                _secret_volume(f"talaia-{name}"),
                _memory_volume("run", "16Mi"),
                _memory_volume("tmp", "64Mi"),
            ],
        },
    )
    stateful = {
        "replicas": 1,
        "serviceName": name,
        "selector": {"matchLabels": _labels(name)},
        "template": _template(name, pod),
        "volumeClaimTemplates": [_claim("data", "ReadWriteOnce", "50Gi")],
    }
    ports: list[Manifest] = [
        {"name": "postgresql", "port": _DATABASE_PORT, "targetPort": "postgresql"}
    ]
    return [
        _service(name, ports, {}),
        _manifest("StatefulSet", name, stateful, "apps/v1"),
    ]


def _network_policies(databases: Iterable[str]) -> list[Manifest]:
    """Let nobody in but to the hubs, and to what is behind them only the hubs."""
    hubs = [{"podSelector": {"matchLabels": _labels("hub")}}]
    policies = [
        _policy("hub", {"ports": [{"port": _HUB_PORT, "protocol": "TCP"}]}),
        _policy("nats", {"from": hubs, "ports": [{"port": NATS_PORT, "protocol": "TCP"}]}),
        *(
            _policy(name, {"from": hubs, "ports": [{"port": _DATABASE_PORT, "protocol": "TCP"}]})
            for name in databases
        ),
    ]
    shut = {"podSelector": {}, "policyTypes": ["Ingress"]}
    return [_manifest("NetworkPolicy", "shut", shut, "networking.k8s.io/v1"), *policies]


def _policy(name: str, ingress: Manifest) -> Manifest:
    spec = {
        "podSelector": {"matchLabels": _labels(name)},
        "policyTypes": ["Ingress"],
        "ingress": [ingress],
    }
    return _manifest("NetworkPolicy", name, spec, "networking.k8s.io/v1")
