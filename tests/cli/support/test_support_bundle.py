"""A support bundle says what helps, and none of the secrets of an installation."""

from __future__ import annotations

import os
import stat
import subprocess
import sys
import zipfile
from pathlib import Path
from urllib.parse import quote

import pytest

from talaia.cli.errors import CliError
from talaia.cli.main import main
from talaia.cli.support.bundle import write_bundle

ROOT = Path(__file__).parents[3]
# By where it stands. Without a sign that would give it away, so that names and places must.
SECRETS = {
    "environment": "walrus-one",
    "database": "walrus two/@",
    "url file": "walrusthree",
    "audit key": "walrusfour",
    "seal": "walrusfive",
    "tls": "wALruSSIXaAbBcCdDeEfFgGhHiIjJkKlLmM",
    "gateway key": "walrusseven",
    "password file": "walruseight",
    "token variable": "walrusnine",
    "camera": "walrusten",
    "argument": "walruseleven",
    "query": "walrustwelve",
    "settings": "walrusthirteen",
    "oidc": "walrusfourteen",
    "log": "walrusfifteen",
    "header": "walrussixteen",
    "comment": "walrusseventeen",
    "process": "walruseighteen",
    "pin": "4711470815",
    "hub token": "walrusnineteen",
}
DESCRIPTION = f"""\
talaia: 1
site: agv   # the password is {SECRETS["comment"]}
name: North dome
connections:
  web: {{kind: http, url: "http://ada:{SECRETS["camera"]}@10.0.0.2/", user: ada,
    password_file: web.password}}
  bus: {{kind: mqtt, url: "mqtts://broker", user: ada, password_file: web.password}}
  rb: {{kind: rosbridge, url: "ws://10.0.0.3:9090", token_env: DOME_TOKEN}}
  run: {{kind: process, prefix: "domectl -k {SECRETS["argument"]}"}}
devices:
  dome:
    name: Dome
    connection: web
    signals:
      wind:
        {{name: Wind, unit: m/s,
         source: {{get: "/api?appid={SECRETS["query"]}&units=metric"}}}}
      pin: {SECRETS["pin"]}
"""


def plant_everywhere(folder: Path) -> dict[str, str]:
    """Write an installation with a secret in each place; give its variables."""
    data = folder / "data"
    (data / "tls").mkdir(parents=True)
    words = [sys.executable, "-m", "talaia", "enrol", "agv", "--data", str(data)]
    subprocess.run(words, check=True, capture_output=True, cwd=ROOT, env=environment_of_ours())
    (data / "audit.key").write_text(SECRETS["audit key"])
    (data / "seal.key").write_text(SECRETS["seal"])
    (data / "audit-hub-token").write_text(SECRETS["hub token"] + "\n")
    (data / "tls" / "key.pem").write_text(
        f"-----BEGIN PRIVATE KEY-----\n{SECRETS['tls']}\n-----END PRIVATE KEY-----\n"
    )
    (folder / "agv.key").write_text(
        f'{{"key": "{SECRETS["gateway key"]}", "hub": "wss://10.0.0.9:8443"}}'
    )
    (folder / "web.password").write_text(SECRETS["password file"] + "\n")
    (folder / "oidc.secret").write_text(SECRETS["oidc"] + "\n")
    (folder / "agv.yaml").write_text(DESCRIPTION)
    (folder / "hub-settings.yaml").write_text(
        f"port: 8443\nmqtt-password: {SECRETS['settings']}\nclient_secret_file: oidc.secret\n"
        f"key-file: agv.key\nheaders: {{X-Any: {SECRETS['header']}}}\n"
    )
    (data / "hub.log").write_text(
        "2026-11-27 INFO talaia.hub: the hub listens on 0.0.0.0:8443\n"
        f"oddly {SECRETS['audit key']} and {SECRETS['hub token']}\n"
        f"dial amqp://u:{quote(SECRETS['log'])}@h and ?token={SECRETS['log']}\n"
        f"read {SECRETS['password file']} {SECRETS['token variable']} {SECRETS['tls']}\n"
    )
    (folder / "extra.log").write_text(f'"secret": "{SECRETS["log"]}"\n{SECRETS["gateway key"]}\n')
    (folder / "database-url").write_text(f"postgresql://ada:{SECRETS['url file']}@h/x")
    return {
        "TALAIA_MQTT_PASSWORD": SECRETS["environment"],
        "DOME_TOKEN": SECRETS["token variable"],
        "TALAIA_OTHER": f"postgresql://ada:{quote(SECRETS['database'], safe='')}@h/x",
    }


def environment_of_ours() -> dict[str, str]:
    """Give the variables by which a process of these tests finds the package."""
    return {**os.environ, "PYTHONPATH": str(ROOT / "src")}


def read_archive(path: Path) -> dict[str, str]:
    """Give the texts of a bundle by name."""
    with zipfile.ZipFile(path) as archive:
        return {name: archive.read(name).decode() for name in archive.namelist()}


@pytest.fixture(scope="module")
def bundle(tmp_path_factory: pytest.TempPathFactory) -> Path:
    folder = tmp_path_factory.mktemp("installation")
    variables = plant_everywhere(folder)
    # A program of ours that runs, with a secret among its words and one in its environment.
    (folder / "talaia").write_text("import sys; print(flush=True); sys.stdin.read()")
    with subprocess.Popen(
        [sys.executable, folder / "talaia", "gateway", "--token", SECRETS["process"]],
        stdin=subprocess.PIPE,
        stdout=subprocess.PIPE,
        env={**environment_of_ours(), **variables},
    ) as running:
        assert running.stdin is not None
        assert running.stdout is not None
        running.stdout.readline()
        asked = [sys.executable, "-m", "talaia", "support-bundle", str(folder / "help.zip")]
        asked += ["--data", str(folder / "data"), "--port", "1", "--site", str(folder / "agv.yaml")]
        asked += ["--settings", str(folder / "hub-settings.yaml")]
        asked += ["--log", str(folder / "extra.log")]
        done = subprocess.run(
            asked,
            env={**environment_of_ours(), **variables},
            cwd=ROOT,
            capture_output=True,
            text=True,
            check=False,
        )
        running.stdin.close()
    assert done.returncode == 0, done.stderr
    return folder / "help.zip"


@pytest.mark.parametrize("place", SECRETS)
def test_no_secret_of_an_installation_is_in_its_bundle(bundle: Path, place: str) -> None:
    secret = SECRETS[place]
    for name, text in read_archive(bundle).items():
        assert secret not in text, name
        assert quote(secret, safe="") not in text, name
    # Nor in what the archive says of its files.
    assert secret.encode() not in bundle.read_bytes()


def test_a_bundle_says_what_helps(bundle: Path) -> None:
    texts = read_archive(bundle)
    assert texts["versions.txt"].startswith("Talaia ")
    assert "SQLAlchemy==" in texts["versions.txt"] or "sqlalchemy==" in texts["versions.txt"]
    assert "ok  hub: fastapi" in texts["doctor.txt"]
    assert "Connection refused" in texts["health.txt"]
    assert "rows of gateways" in texts["database.txt"]
    assert "agv: " in texts["gateways.txt"]
    assert "never seen" in texts["gateways.txt"]
    assert "talaia.db" in texts["files.txt"]
    assert "port: 8443" in texts["settings.txt"]
    assert "name: North dome" in texts["site/agv.yaml"]
    assert "url: http://***@" in texts["site/agv.yaml"]
    assert "unit: m/s" in texts["site/agv.yaml"]
    assert "pin" in texts["site/agv.yaml.check.txt"]
    assert "the hub listens on 0.0.0.0:8443" in texts["logs/hub.log"]
    assert "gateway --token ***" in texts["programs.txt"]


def test_a_bundle_is_its_owners_alone_and_never_takes_anothers_place(
    bundle: Path, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    assert stat.S_IMODE(bundle.stat().st_mode) == 0o600
    (tmp_path / "there.zip").write_text("mine")
    with pytest.raises(CliError, match="File exists"):
        write_bundle({}, tmp_path / "there.zip")
    assert main(["support-bundle", str(tmp_path / "there.zip"), "--data", str(tmp_path)]) == 2
    assert "cannot be written" in capsys.readouterr().err
    assert (tmp_path / "there.zip").read_text() == "mine"


def test_an_empty_machine_has_a_bundle_too_and_no_database_is_made(tmp_path: Path) -> None:
    assert main(["support-bundle", str(tmp_path / "a.zip"), "--data", str(tmp_path / "no")]) == 0
    texts = read_archive(tmp_path / "a.zip")
    assert texts["database.txt"] == "there is none\n"
    assert not (tmp_path / "no").exists()
