"""A deployment's files: what Docker and systemd themselves say of them, and hostile names."""

from __future__ import annotations

import re
import shlex
import shutil
import stat
import subprocess
import sys
from pathlib import Path

import msgspec
import pytest
import yaml
from hypothesis import given, settings, strategies as st
from tests.system.conftest import missing

from talaia.cli.main import main
from talaia.deploy.locks import read_image_lock
from talaia.deploy.options import DatabaseKind
from talaia.deploy.project import DeployOptions, File, make_deployment
from talaia.deploy.systemd import gateway_unit, hub_unit, quoted_argument
from talaia.hub.command_line import _make_parser
from talaia.hub.files.bucket_address import BucketKey, read_bucket_address
from talaia.hub.history.servers.server_file import read_history_servers
from talaia.hub.settings import Settings
from talaia.model.yaml_text.load import load_site, read_site

EXAMPLE = Path(__file__).parents[2] / "examples/agv/site.yaml"
SYSTEM_PATH = "/usr/local/bin:/usr/bin:/usr/sbin"
HOSTILE = [
    "a b",
    "x'; rm -rf / #",
    '"$(id)"',
    "${HOME}",
    "%n%h",
    "line\nExecStart=/bin/sh",
    "ü\u2028",
]


def files_of(database: DatabaseKind, *hosts: str, program: str = "/opt/t") -> dict[str, File]:
    site = read_site(EXAMPLE)
    choice = DeployOptions(database, 8443, hosts, "0.1.0", program)
    words = iter(f"secret{index}" for index in range(9))
    return make_deployment(site, EXAMPLE.read_text(), choice, lambda: next(words))


@pytest.mark.parametrize("database", DatabaseKind)
def test_compose_itself_accepts_the_project(database: DatabaseKind, tmp_path: Path) -> None:
    compose = shutil.which("docker-compose")
    if compose is None:
        missing("docker-compose")
    assert main(["generate", str(EXAMPLE), "--to", str(tmp_path), "--database", database]) == 0
    said = subprocess.run(
        [str(compose), "config", "--quiet"],
        cwd=tmp_path,
        capture_output=True,
        text=True,
        check=False,
    )
    assert said.returncode == 0, said.stderr
    kept = yaml.safe_load((tmp_path / "compose.yaml").read_text())
    assert load_site((tmp_path / "site.yaml").read_text()) == read_site(EXAMPLE)
    text = (tmp_path / "compose.yaml").read_text()
    for secret in (tmp_path / "secrets").glob("*"):
        assert secret.read_text() not in text
    assert all(each["restart"] for each in kept["services"].values())


def several_hubs(folder: Path, *more: str) -> Path:
    words = ["generate", str(EXAMPLE), "--to", str(folder), "--hubs", "3", *more]
    assert main(words) == 0
    return folder


@pytest.fixture
def bucket(tmp_path_factory) -> list[str]:
    """Words that name a bucket, with its key and authority."""
    folder = tmp_path_factory.mktemp("bucket")
    key, authority = folder / "key", folder / "ca.pem"
    key.write_text("AKIDGENERATED\na-secret-of-the-bucket\n")
    authority.write_text("-----BEGIN CERTIFICATE-----\nAAAA\n-----END CERTIFICATE-----\n")
    words = ["--files", "s3://robots/east", "--files-endpoint", "https://store.example:9000"]
    return [*words, "--files-key-file", str(key), "--files-ca", str(authority)]


def name_of(manifest: dict) -> str:
    # Kustomize's own file has none.
    return manifest.get("metadata", {}).get("name", "")


def manifests_of(folder: Path) -> list[dict]:
    return [
        manifest
        for path in sorted((folder / "kubernetes").iterdir())
        for manifest in yaml.safe_load_all(path.read_text())
    ]


@pytest.mark.parametrize("more", [False, True])
def test_compose_haproxy_nats_and_kustomize_accept_the_files_of_several_hubs(
    tmp_path: Path, bucket: list[str], *, more: bool
) -> None:
    words = [*bucket, "--history-servers", "2", "--shards"]
    several_hubs(tmp_path, *(words if more else ()))
    compose, haproxy = shutil.which("docker-compose"), shutil.which("haproxy", path=SYSTEM_PATH)
    nats, kubectl = shutil.which("nats-server", path=SYSTEM_PATH), shutil.which("kubectl")
    # Names of containers are none here, and neither is the folder of their secrets.
    balancer = tmp_path / "here.cfg"
    text = (tmp_path / "haproxy.cfg").read_text()
    balancer.write_text(re.sub(r" hub-\d:8443", " 127.0.0.1:8443", text))
    bus = tmp_path / "here.conf"
    text = (tmp_path / "secrets/nats.conf").read_text()
    bus.write_text(text.replace("/run/secrets", str(tmp_path / "secrets")))
    for words in (
        [compose or "docker-compose", "config", "--quiet"],
        [haproxy or "haproxy", "-c", "-q", "-f", str(balancer)],
        [nats or "nats-server", "-t", "-c", str(bus)],
        # Kubernetes' own; the rest of its judgement is a cluster's.
        [kubectl or "kubectl", "kustomize", "kubernetes"],
    ):
        if not Path(words[0]).is_absolute():
            missing(words[0])
        said = subprocess.run(words, cwd=tmp_path, capture_output=True, text=True, check=False)
        assert said.returncode == 0, said.stdout + said.stderr
        assert "WARNING" not in said.stderr, said.stderr


def test_several_hubs_are_bounded_share_one_folder_and_have_no_port_but_the_balancers(
    tmp_path: Path,
) -> None:
    several_hubs(tmp_path)
    project = yaml.safe_load((tmp_path / "compose.yaml").read_text())
    services = project["services"]
    hubs = {name: each for name, each in services.items() if name.startswith("hub-")}
    assert list(hubs) == ["hub-1", "hub-2", "hub-3"]
    for name, service in services.items():
        assert service["cap_drop"] == ["ALL"], name
        assert service["read_only"], name
        assert service["mem_limit"], name
        assert "build" in service or not service["user"].startswith("0"), name
    assert {name for name, each in services.items() if "ports" in each} == {"haproxy"}
    assert {name for name, each in services.items() if each.get("networks") == ["back"]} == {
        *("database", "nats", "enrol")
    }
    assert project["networks"]["back"]["internal"]
    assert all(each["volumes"] == ["hub-data:/data"] for each in hubs.values())
    assert all("healthcheck" in services[name] for name in (*hubs, "haproxy", "nats", "database"))
    balancer = (tmp_path / "haproxy.cfg").read_text()
    assert "\n  mode tcp\n" in balancer
    assert "GET /api/ready" in balancer
    assert not re.search(r"(?m)^ *(stick|cookie|bind .* ssl)", balancer)
    assert "\nnats-py==" in (tmp_path / "locks/hub.txt").read_text()


def test_histories_have_databases_of_their_own_that_each_hub_is_told_of(tmp_path: Path) -> None:
    words = ["--history-servers", "2"]
    manifests = manifests_of(several_hubs(tmp_path, *words))
    secrets = tmp_path / "secrets"
    project = yaml.safe_load((tmp_path / "compose.yaml").read_text())
    hub = next(each for each in manifests if each["kind"] == "Deployment")
    args = hub["spec"]["template"]["spec"]["containers"][0]["args"]
    for said, file in (
        *((project["services"][f"hub-{n}"]["command"], "history_servers.yaml") for n in (1, 2, 3)),
        (args, "kubernetes_history_servers.yaml"),
    ):
        options = _make_parser().parse_args([str(word) for word in said[1:]])
        assert options.history_servers == Path("/run/secrets/history_servers.yaml")
        # As a hub reads it.
        here = tmp_path / "servers.yaml"
        here.write_text((secrets / file).read_text().replace("/run/secrets", str(secrets)))
        named = read_history_servers(here)
        assert named.default == "history-1"
        assert list(named.servers) == ["history-1", "history-2"]
        for name, url in named.servers.items():
            password = (secrets / f"{name}_password").read_text()
            assert url.startswith(f"postgresql://talaia:{password}@{name}/talaia")
            assert ("sslmode=verify-full" in url) == file.startswith("kubernetes")
    passwords = {(secrets / f"history-{n}_password").read_text() for n in (1, 2)}
    assert len(passwords | {(secrets / "database_password").read_text()}) == 3
    for name in ("history-1", "history-2"):
        service = project["services"][name]
        assert service["secrets"] == [f"{name}_password"]
        assert service["volumes"] == [f"{name}:/var/lib/postgresql/data"]
        assert service["networks"] == ["back"]
        found = {each["kind"] for each in manifests if name_of(each) == name}
        assert found == {"Service", "StatefulSet", "NetworkPolicy"}
    readme = (tmp_path / "README.md").read_text()
    assert "--from-file=history_servers.yaml=secrets/kubernetes_history_servers.yaml" in readme
    # Written anew, the databases' passwords stay; another number would make some of them anew.
    several_hubs(tmp_path, *words, "--force")
    assert {(secrets / f"history-{n}_password").read_text() for n in (1, 2)} == passwords
    site = ["generate", str(EXAMPLE), "--to", str(tmp_path), "--hubs", "3", "--force"]
    assert main([*site, "--history-servers", "3"]) == 2
    assert not (secrets / "history-3_password").exists()


def test_sites_are_divided_where_that_is_asked_for(
    tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    words = ["--history-servers", "2", "--shards"]
    several_hubs(tmp_path, *words)
    secrets = tmp_path / "secrets"
    kept = {}
    for file in ("history_servers.yaml", "kubernetes_history_servers.yaml"):
        # As a hub reads it.
        here = tmp_path / "servers.yaml"
        kept[file] = (secrets / file).read_text()
        here.write_text(kept[file].replace("/run/secrets", str(secrets)))
        named = read_history_servers(here)
        assert named.plan.names == named.default == ("history-1", "history-2")
    assert "divided among 3 leads" in (tmp_path / "README.md").read_text()
    several_hubs(tmp_path, *words, "--force")
    # What has passwords is not written anew: it has to say itself what it is to say.
    capsys.readouterr()
    site = ["generate", str(EXAMPLE), "--to", str(tmp_path), "--hubs", "3", "--force"]
    assert main([*site, "--history-servers", "2"]) == 2
    assert "is kept, and has shards; add --shards" in capsys.readouterr().err
    for file, text in kept.items():
        assert (secrets / file).read_text() == text
        (secrets / file).write_text(text.replace("\nshards:", "\n# shards:"))
    assert main([*site, *words]) == 2
    assert "is kept, and has no shards; end all hubs, write" in capsys.readouterr().err


def test_hubs_keep_their_files_in_a_bucket_whose_key_is_a_secret(
    tmp_path: Path, bucket: list[str]
) -> None:
    manifests = manifests_of(several_hubs(tmp_path, *bucket))
    secrets = tmp_path / "secrets"
    project = yaml.safe_load((tmp_path / "compose.yaml").read_text())
    hub = next(each for each in manifests if each["kind"] == "Deployment")
    pod = hub["spec"]["template"]["spec"]["containers"][0]
    commands = [project["services"][f"hub-{n}"]["command"] for n in (1, 2, 3)]
    for words in (*commands, pod["args"]):
        # As a hub reads them, with the secrets that lie here.
        at_home = [word.replace("/run/secrets", str(secrets)) for word in words[1:]]
        options = _make_parser().parse_args(at_home)
        found = read_bucket_address(
            Settings(
                data=tmp_path,
                files=options.files,
                files_endpoint=options.files_endpoint,
                files_key_file=options.files_key_file,
                files_ca=options.files_ca,
            ),
            {},
        )
        assert found is not None
        assert found.place == "s3://robots/east at https://store.example:9000"
        assert found.key == BucketKey("AKIDGENERATED", "a-secret-of-the-bucket")
        assert found.ca == (secrets / "files_ca.pem").read_text()
    assert {"files_key", "files_ca.pem"} <= set(project["services"]["hub-1"]["secrets"])
    assert "files_key" not in project["services"]["nats"]["secrets"]
    assert project["secrets"]["files_key"] == {"file": "./secrets/files_key"}
    readme = (tmp_path / "README.md").read_text()
    for name in ("files_key", "files_ca.pem"):
        assert f"--from-file=secrets/{name}" in readme
    assert "`s3://robots/east`" in readme
    assert "\nobstore==" in (tmp_path / "locks/hub.txt").read_text()
    for path in tmp_path.rglob("*"):
        if path.is_file() and path.parent != secrets:
            assert "a-secret-of-the-bucket" not in path.read_text(), path


def test_no_secret_stands_anywhere_but_in_its_own_file(tmp_path: Path) -> None:
    several_hubs(tmp_path)
    words = {(tmp_path / "secrets/database_password").read_text()}
    words |= {re.findall(r":([^:@]+)@", (tmp_path / "secrets/cluster_url").read_text())[0]}
    words |= {
        line
        for path in (tmp_path / "secrets").glob("*_key.pem")
        for line in path.read_text().splitlines()
        if not line.startswith("---")
    }
    assert len(words) > 4
    for path in tmp_path.rglob("*"):
        if path.is_file() and path.parent.name != "secrets":
            text = path.read_text()
            assert not any(word in text for word in words), path


def test_pods_are_bounded_probed_and_get_their_secrets_by_name(tmp_path: Path) -> None:
    manifests = manifests_of(several_hubs(tmp_path))
    kinds = [each["kind"] for each in manifests]
    assert {"PodDisruptionBudget", "NetworkPolicy", "Namespace", "Kustomization"} <= set(kinds)
    assert "Secret" not in kinds
    owners = [each for each in manifests if each["kind"] in {"Deployment", "StatefulSet"}]
    assert len(owners) == 3
    named = set()
    for owner in owners:
        pod = owner["spec"]["template"]["spec"]
        assert owner["spec"]["selector"]["matchLabels"].items() <= (
            owner["spec"]["template"]["metadata"]["labels"].items()
        )
        assert pod["securityContext"]["runAsNonRoot"]
        assert pod["securityContext"]["seccompProfile"] == {"type": "RuntimeDefault"}
        assert not pod["automountServiceAccountToken"]
        volumes = {each["name"]: each for each in pod["volumes"]}
        named |= {each["secret"]["secretName"] for each in volumes.values() if "secret" in each}
        volumes |= {
            each["metadata"]["name"]: each for each in owner["spec"].get("volumeClaimTemplates", [])
        }
        for container in pod["containers"]:
            bounds = container["securityContext"]
            assert bounds["readOnlyRootFilesystem"]
            assert not bounds["allowPrivilegeEscalation"]
            assert bounds["capabilities"] == {"drop": ["ALL"]}
            assert {"cpu", "memory"} == container["resources"]["requests"].keys()
            assert "readinessProbe" in container
            assert {each["name"] for each in container["volumeMounts"]} == volumes.keys()
    told = (tmp_path / "README.md").read_text()
    assert all(f"create secret generic {name} " in told for name in named)
    hub = next(each for each in owners if each["metadata"]["name"] == "hub")
    assert hub["spec"]["replicas"] == 3
    container = hub["spec"]["template"]["spec"]["containers"][0]
    assert container["livenessProbe"]["httpGet"]["path"] == "/api/health"
    assert container["readinessProbe"]["httpGet"]["path"] == "/api/ready"


@pytest.mark.parametrize(
    ("more", "told"),
    [
        (["--hubs", "1"], "--hubs: expected 2 to 9, found 1; leave it out for one hub"),
        (["--hubs", "0"], "--hubs: expected 2 to 9, found 0"),
        (["--hubs", "100"], "--hubs: expected 2 to 9, found 100"),
        (["--hubs", "3", "--database", "sqlite"], "with PostgreSQL, not sqlite"),
        (["--hubs", "3", "--database", "mariadb"], "with PostgreSQL, not mariadb"),
        (["--history-servers", "2"], "they are written for several hubs; add --hubs 3"),
        (["--hubs", "3", "--history-servers", "0"], "--history-servers: expected 1 to 9, found 0"),
        (["--hubs", "3", "--shards"], "add --hubs 3 --history-servers 2"),
        (
            ["--hubs", "3", "--history-servers", "3", "--shards"],
            "3 shards and the main one have a lead each, so name at least 4 hubs",
        ),
        (["--files", "s3://robots"], "a bucket is written for several hubs; add --hubs 3"),
        (["--hubs", "3", "--files", "s3://robots"], "--files needs --files-key-file"),
        (
            ["--hubs", "3", "--files", "robots", "--files-key-file", "/dev/null"],
            "expected the address of a bucket",
        ),
    ],
)
def test_a_number_of_hubs_that_cannot_be_is_refused(
    tmp_path: Path, capsys: pytest.CaptureFixture[str], more: list[str], told: str
) -> None:
    assert main(["generate", str(EXAMPLE), "--to", str(tmp_path / "no"), *more]) == 2
    assert told in capsys.readouterr().err
    assert not (tmp_path / "no").exists()


def test_one_hub_becomes_three_with_the_passwords_that_its_database_knows(
    tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    words = ["generate", str(EXAMPLE), "--to", str(tmp_path)]
    assert main([*words, "--database", "postgresql"]) == 0
    kept = (tmp_path / "secrets/database_password").read_text()
    several_hubs(tmp_path, "--force")
    for name in ("database_password", "database_url", "kubernetes_database_url"):
        assert kept in (tmp_path / "secrets" / name).read_text()
    # Of files that were made together none is made anew alone.
    (tmp_path / "secrets/nats_key.pem").unlink()
    assert main([*words, "--hubs", "3", "--force"]) == 2
    assert "no secrets/nats_key.pem, which were made together" in capsys.readouterr().err
    # Another database knows none of the passwords that are kept.
    other = ["generate", str(EXAMPLE), "--to", str(tmp_path / "other")]
    assert main(other) == 0
    assert main([*other, "--hubs", "3", "--force"]) == 2
    assert "was made for mariadb, and its secrets are kept" in capsys.readouterr().err


@pytest.mark.parametrize("database", DatabaseKind)
def test_php_my_admin_starts_only_where_its_profile_is_asked_for(database: DatabaseKind) -> None:
    files = files_of(database)
    services = yaml.safe_load(files["compose.yaml"].text)["services"]
    profiles = {name: each["profiles"] for name, each in services.items() if "profiles" in each}
    mariadb = database is DatabaseKind.MARIADB
    assert profiles == ({"phpmyadmin": ["phpmyadmin"]} if mariadb else {})
    assert ("--profile phpmyadmin" in files["README.md"].text) == mariadb
    # Its image writes this file itself where it is missing, which a read-only root forbids.
    if mariadb:
        (mount,) = services["phpmyadmin"]["volumes"]
        here, there, rights = mount.split(":")
        assert (there, rights) == ("/etc/phpmyadmin/config.secret.inc.php", "ro")
        assert files[here.removeprefix("./")].text.startswith("<?php\n$cfg['blowfish_secret'] = '")


def test_images_of_others_stand_by_their_tags_until_their_digests_are_given(
    tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    digest = "sha256:" + "0a" * 32
    words = ["generate", str(EXAMPLE), "--to", str(tmp_path / "to"), "--ros-distro", "jazzy"]
    pins = ["python:3.12-slim-bookworm", "ros:jazzy-ros-base", "mariadb:11.4"]
    assert main([*words, *(word for each in pins for word in ("--pin", f"{each}@{digest}"))]) == 0
    folder = tmp_path / "to"
    services = yaml.safe_load((folder / "compose.yaml").read_text())["services"]
    assert services["database"]["image"] == f"mariadb:11.4@{digest}"
    assert services["phpmyadmin"]["image"] == "phpmyadmin:5.2"
    for name, image in (("hub", pins[0]), ("gateway", pins[1])):
        assert (folder / f"{name}.Dockerfile").read_text().startswith(f"FROM {image}@{digest}\n")
    for wrong, told in (
        ("postgres:17@" + digest, "mariadb:11.4, phpmyadmin:5.2, python:3.12-slim-bookworm, ros"),
        ("mariadb:11.4@sha256:0a", "64 hexadecimal digits"),
    ):
        assert main([*words[:3], str(tmp_path / "no"), *words[4:], "--pin", wrong]) == 2
        assert told in capsys.readouterr().err
    assert not (tmp_path / "no").exists()


def test_what_images_install_is_locked_as_what_the_tests_run_with() -> None:
    locked = (EXAMPLE.parents[2] / "requirements/dev.txt").read_text()
    for package in read_image_lock():
        name, _, hashes = package.text.partition("\n")
        # uv alone is no part of an environment for development.
        if package.groups != {"uv"}:
            assert re.split(r" [;\\]", name)[0] in locked
            assert hashes in locked
    for database in DatabaseKind:
        for path, file in files_of(database).items():
            if not path.startswith("locks/"):
                continue
            packages = re.split(r"^(?=\S)", file.text, flags=re.MULTILINE)[1:]
            assert packages
            assert all("==" in each and "--hash=sha256:" in each for each in packages)


@pytest.mark.parametrize("database", DatabaseKind)
def test_every_container_is_bounded_has_no_capability_and_writes_only_where_it_must(
    database: DatabaseKind, tmp_path: Path
) -> None:
    words = ["generate", str(EXAMPLE), "--to", str(tmp_path), "--database", database]
    assert main(words) == 0
    services = yaml.safe_load((tmp_path / "compose.yaml").read_text())["services"]
    for name, service in services.items():
        assert service["cap_drop"] == ["ALL"], name
        assert service["security_opt"] == ["no-new-privileges:true"], name
        assert "/tmp" in service["tmpfs"], name  # noqa: S108 - of the container
        assert "cap_add" not in service, name
        assert service["read_only"], name
        assert service["mem_limit"], name
        assert service["pids_limit"] > 0, name
        # Nobody's root: of our own images by their recipe.
        assert "build" in service or not service["user"].startswith("0"), name
    # What compose hands to a database's own user is read by that user, and here by the owner.
    for secret in (tmp_path / "secrets").glob("*"):
        assert stat.S_IMODE(secret.stat().st_mode) == 0o644


def test_systemd_finds_little_that_the_units_leave_open(tmp_path: Path) -> None:
    analyze = shutil.which("systemd-analyze")
    if analyze is None:
        missing("systemd-analyze")
    for name, file in files_of(DatabaseKind.SQLITE).items():
        if not name.startswith("systemd/"):
            continue
        assert "\nMemoryMax=" in file.text
        assert "\nSystemCallFilter=@system-service\n" in file.text
        unit = tmp_path / Path(name).name
        unit.write_text(file.text)
        # Of 100, which is no bound at all; a plain unit has 96.
        words = ["security", "--offline=yes", "--no-pager", "--threshold=40", str(unit)]
        said = subprocess.run([str(analyze), *words], capture_output=True, text=True, check=False)
        assert said.returncode == 0, said.stdout[-400:] + said.stderr


def test_systemd_itself_accepts_the_units(tmp_path: Path) -> None:
    analyze = shutil.which("systemd-analyze")
    if analyze is None:
        missing("systemd-analyze")
    program, setup = sys.executable, str(EXAMPLE.resolve())
    words = ["generate", str(EXAMPLE), "--to", str(tmp_path), "--program", program]
    assert main([*words, "--ros-setup", setup, "--allow-host", "hub.example"]) == 0
    units = sorted(str(each) for each in (tmp_path / "systemd").iterdir())
    assert len(units) == 2
    said = subprocess.run(
        [str(analyze), "verify", *units], capture_output=True, text=True, check=False
    )
    assert said.returncode == 0, said.stderr
    assert said.stderr.strip() == ""


def test_the_units_are_restarted_when_they_give_no_sign_of_life() -> None:
    files = files_of(DatabaseKind.SQLITE)
    units = [each.text for name, each in files.items() if name.startswith("systemd/")]
    assert len(units) == 2
    for unit in units:
        assert {"Type=notify", "NotifyAccess=main", "Restart=always"} <= set(unit.splitlines())
        assert "\nWatchdogSec=" in unit
    # What closes the roof must outlive a gateway that is killed.
    assert "KillMode=process" in next(each for each in units if "gateway" in each)
    assert "KillMode" not in next(each for each in units if "gateway" not in each)


@pytest.mark.parametrize("hostile", HOSTILE)
def test_a_hostile_name_is_one_argument_and_nothing_else(hostile: str) -> None:
    files = files_of(DatabaseKind.MARIADB, hostile, program="/opt/t")
    command = yaml.safe_load(files["compose.yaml"].text)["services"]["hub"]["command"]
    assert command[-1].replace("$$", "$") == hostile
    unit = files["systemd/talaia-hub.service"].text
    assert [line for line in unit.splitlines() if line.startswith("ExecStart=")] == [
        f"ExecStart=/opt/t hub --data /var/lib/talaia-hub --host 0.0.0.0 --port 8443"
        f" --allow-host {quoted_argument(hostile)}"
    ]


@settings(deadline=None)
@given(st.text(max_size=30))
def test_systemd_reads_back_one_word_for_each_argument(text: str) -> None:
    written = quoted_argument(text)
    assert written.isprintable() or written == ""
    plain = written.replace("%%", "%").replace("$$", "$")
    if all(letter.isprintable() for letter in text):
        # Of C escapes only these two are then in it, and shlex knows them the same way.
        assert shlex.split(plain) == [text]


def test_a_site_whose_name_is_hostile_has_a_page_that_shows_it_and_does_nothing_else() -> None:
    site = msgspec.structs.replace(read_site(EXAMPLE), name="<script>x</script>\n# [a](b)")
    choice = DeployOptions(DatabaseKind.SQLITE, 8443, (), "0.1.0", "/opt/t")
    page = make_deployment(site, "", choice, lambda: "")["README.md"].text
    assert "<script>" not in page
    assert "\n# [a](b)" not in page


def test_secrets_are_random_are_the_owners_and_outlive_another_generate(tmp_path: Path) -> None:
    words = ["generate", str(EXAMPLE), "--to", str(tmp_path)]
    assert main(words) == 0
    kept = (tmp_path / "secrets/database_password").read_text()
    assert len(kept) >= 24
    assert kept in (tmp_path / "secrets/database_url").read_text()
    assert kept != (tmp_path / "secrets/database_root_password").read_text()
    assert stat.S_IMODE((tmp_path / "secrets").stat().st_mode) == 0o700
    assert main(words) == 2
    assert main([*words, "--force"]) == 0
    assert (tmp_path / "secrets/database_password").read_text() == kept


def test_nothing_is_written_when_something_is_wrong(
    tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    target = tmp_path / "there"
    bad = tmp_path / "site.yaml"
    bad.write_text(EXAMPLE.read_text().replace("unit: m/s\n", "unit: m/z\n", 1))
    assert main(["generate", str(bad), "--to", str(target)]) == 2
    assert "m/z" in capsys.readouterr().err
    assert main(["generate", str(EXAMPLE), "--to", str(target), "--port", "0"]) == 2
    assert "--port" in capsys.readouterr().err
    words = ["generate", str(EXAMPLE), "--to", str(target), "--ros-setup", "opt/ros/setup.bash"]
    assert main(words) == 2
    assert "absolute" in capsys.readouterr().err
    assert not target.exists()


def test_the_gateways_unit_hands_its_words_to_the_ros_shell_as_they_are() -> None:
    unit = gateway_unit("agv", "/opt/t", "/opt/ros/x y/setup.bash")
    line = next(each for each in unit.splitlines() if each.startswith("ExecStart="))
    assert '"/opt/ros/x y/setup.bash" /opt/t gateway' in line


def test_the_hubs_unit_doubles_a_dollar_sign_only_in_its_command_line() -> None:
    # systemd.exec(5), Environment=: "$" has no special meaning there; "%" has.
    lines = hub_unit("/opt/$t", 8443, (), "/etc/$talaia/100% url").splitlines()
    assert 'Environment="TALAIA_DATABASE_URL_FILE=/etc/$talaia/100%% url"' in lines
    assert any(line.startswith('ExecStart="/opt/$$t" hub') for line in lines)
    plain = hub_unit("/opt/t", 8443, (), "/etc/talaia/database_url").splitlines()
    assert "Environment=TALAIA_DATABASE_URL_FILE=/etc/talaia/database_url" in plain


def test_a_key_that_is_good_is_kept_and_one_that_is_void_is_made_anew(tmp_path: Path) -> None:
    key = tmp_path / "gateway.key"
    words = ["enrol", "agv", "--data", str(tmp_path / "data"), "--to", str(key)]
    assert main(words) == 2
    words += ["--hub", "wss://127.0.0.1:8443"]
    assert main(words) == 0
    first = key.read_text()
    assert stat.S_IMODE(key.stat().st_mode) == 0o600
    assert '"fingerprint"' in first
    assert main(words) == 0
    assert key.read_text() == first
    assert main(["enrol", "agv", "--data", str(tmp_path / "data")]) == 0
    assert main(words) == 0
    assert key.read_text() != first


def test_the_gateway_of_an_observatory_has_what_astronomy_needs_and_a_vehicles_has_not() -> None:
    observatory = EXAMPLE.parents[1] / "observatory" / "site.yaml"
    choice = DeployOptions(DatabaseKind.SQLITE, 8443, (), "0.1.0", "/opt/t")
    made = make_deployment(read_site(observatory), observatory.read_text(), choice, lambda: "word")
    assert "\nastropy==" in made["locks/gateway.txt"].text
    assert "\nastropy==" not in files_of(DatabaseKind.SQLITE)["locks/gateway.txt"].text
