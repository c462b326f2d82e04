"""Releases are handed out by the hub, stage by stage; a real gateway takes what is signed."""

from __future__ import annotations

import asyncio
import sys
import zipfile
from pathlib import Path

from async_program import start_program
from bare_release import bare_release
from cryptography.hazmat.primitives.asymmetric.ed25519 import Ed25519PrivateKey
from patience import until_answered

from talaia.updates.hub_source import HubSource, write_hub_source
from talaia.updates.signed_release import sign_release
from talaia.updates.slot_folder import SlotFolder
from talaia.wire.frames import (
    FILES_FROM_GATEWAY,
    FILES_FROM_HUB,
    PIECE,
    ReleaseOffer,
    ReleasePiece,
    ReleaseRequest,
    ReleaseState,
)

from ..conftest import DESCRIPTION

KEY = Ed25519PrivateKey.generate()
SITE = """
talaia: 1
site: agv
name: Shed
connections: {shell: {kind: process, poll: 1}}
devices:
  base:
    name: Base
    connection: shell
    signals:
      speed: {name: Speed, unit: m/s, source: {run: echo 1, pattern: '([0-9.]+)'}}
"""
# The package under test, which calls itself by the version of its release.
LAUNCH = """\
import sys
sys.path[:0] = {path!r}
def main():
    import talaia
    talaia.__version__ = "{version}"
    from talaia.cli.main import main
    return main()
"""


def write_program(_wheels: list[Path], slot: Path) -> None:
    """Build the first release, without an environment of its own."""
    program = slot / "bin" / "talaia"
    program.parent.mkdir()
    launch = LAUNCH.format(path=sys.path, version="1.0.0")
    program.write_text(f"#!{sys.executable}\n{launch}sys.exit(main())\n")
    program.chmod(0o700)


def wheel_of(folder: Path, version: str) -> Path:
    """Write a wheel whose program is the one under test."""
    name = f"talaia_launch-{version}"
    about = f"{name}.dist-info"
    path = folder / f"{name}-py3-none-any.whl"
    files = {
        "talaia_launch.py": LAUNCH.format(path=sys.path, version=version),
        f"{about}/METADATA": f"Metadata-Version: 2.1\nName: talaia-launch\nVersion: {version}\n",
        f"{about}/WHEEL": "Wheel-Version: 1.0\nRoot-Is-Purelib: true\nTag: py3-none-any\n",
        f"{about}/entry_points.txt": "[console_scripts]\ntalaia = talaia_launch:main\n",
    }
    files[f"{about}/RECORD"] = "".join(f"{one},,\n" for one in [*files, f"{about}/RECORD"])
    with zipfile.ZipFile(path, "w") as archive:
        for one, text in files.items():
            archive.writestr(one, text)
    return path


def release_of(folder: Path, version: str, key=KEY, name: str = "") -> Path:
    """Sign a release of that wheel."""
    folder.mkdir(exist_ok=True)
    target = folder / f"{name or version}.release"
    sign_release([wheel_of(folder, version)], target, key, version=version)
    return target


async def overview(client):
    answer = await client.get("/api/releases")
    assert answer.status_code == 200, answer.text
    return answer.json()


async def test_a_release_is_offered_fetched_in_pieces_and_its_end_is_told(hub, tmp_path) -> None:
    release = release_of(tmp_path / "releases", "1.1.0")
    (tmp_path / "releases" / "broken.release").write_bytes(b"no release")
    admin = await hub.client("admin")
    gateway = await hub.gateway()
    welcome = await gateway.hello(DESCRIPTION)
    assert "release_state" in welcome.takes
    rows = (await overview(admin))["releases"]
    assert {row["name"]: row["version"] for row in rows} == {
        "1.1.0.release": "1.1.0", "broken.release": "",
    }  # fmt: skip
    assert "is no release" in next(row["problem"] for row in rows if not row["version"])
    # One that takes none from its hub cannot be chosen.
    asked = {"version": "1.1.0", "sites": ["agv"]}
    refused = await admin.post("/api/rollouts", json=asked)
    assert (refused.status_code, "takes no releases" in refused.text) == (409, True)
    await gateway.say(ReleaseState(current="1.0.0"))

    async def takes_releases() -> bool:
        return bool((await overview(admin))["gateways"])

    await until_answered(takes_releases)
    unknown = await admin.post("/api/rollouts", json={**asked, "version": "9.9.9"})
    assert (unknown.status_code, "no release 9.9.9" in unknown.text) == (409, True)
    assert (await admin.post("/api/rollouts", json=asked)).status_code == 201
    again = await admin.post("/api/rollouts", json=asked)
    assert (again.status_code, "under way" in again.text) == (409, True)
    offer = await gateway.hear(ReleaseOffer)
    body = release.read_bytes()
    assert (offer.version, offer.size) == ("1.1.0", len(body))
    files = await hub.dial("/gateway/files", {"Authorization": f"Bearer {hub.keys['agv']}"})

    async def ask_piece(version: str, at: int) -> ReleasePiece:
        await files.send(FILES_FROM_GATEWAY.encode(ReleaseRequest(version=version, at=at)))
        return FILES_FROM_HUB.decode(await files.recv())

    fetched = b""
    while len(fetched) < offer.size:
        piece = await ask_piece("1.1.0", len(fetched))
        assert 0 < len(piece.data) <= PIECE
        fetched += piece.data
    assert fetched == body
    assert "no longer" in (await ask_piece("../1.1.0", 0)).refused
    assert "not as long" in (await ask_piece("1.1.0", len(body))).refused
    await gateway.say(ReleaseState(current="1.0.0", phase="waiting", candidate="1.1.0"))
    await gateway.say(ReleaseState(current="1.1.0"))

    async def has_ended() -> bool:
        return not (await overview(admin))["rollout"]["runs"]

    await until_answered(has_ended)
    assert (await overview(admin))["rollout"]["sites"] == [
        {"site": "agv", "stage": "done", "why": ""}
    ]
    kinds = {row["kind"] for row in (await admin.get("/api/audit")).json()["rows"]}
    assert {"release handed out", "gateway updated"} <= kinds
    # What has ended cannot be stopped.
    assert (await admin.post("/api/rollouts/stop", json={})).status_code == 409


async def test_a_real_gateway_leaves_what_a_stranger_signed_and_changes_to_what_is_trusted(
    hub, tmp_path
) -> None:
    root, folder = tmp_path / "software", tmp_path / "releases"
    release_of(folder, "1.1.0", Ed25519PrivateKey.generate())
    trusted = KEY.public_key()
    slots = SlotFolder(root)

    slots.set_up(bare_release("1.0.0"), write_program)
    write_hub_source(root, HubSource(publishers=[trusted.public_bytes_raw().hex()]))
    (tmp_path / "agv.yaml").write_text(SITE)
    (tmp_path / "key").write_text(hub.keys["agv"])
    words = ["-m", "talaia", "update", "run", "--root", str(root), "--", str(tmp_path / "agv.yaml")]
    words += ["--hub", f"ws://127.0.0.1:{hub.port}", "--allow-plain", "--update-rest", "0.5"]
    words += ["--key-file", str(tmp_path / "key"), "--data", str(tmp_path / "gateway")]
    admin = await hub.client("admin")

    async def hand_out(version: str) -> None:
        async def is_begun() -> bool:
            asked = {"version": version, "sites": ["agv"]}
            return (await admin.post("/api/rollouts", json=asked)).status_code == 201

        async def has_ended() -> bool:
            return not (await overview(admin))["rollout"]["runs"]

        # As soon as it has told how its releases stand.
        await until_answered(is_begun)
        await until_answered(has_ended)

    running = await start_program(*words)
    try:
        await hand_out("1.1.0")
        seen = await overview(admin)
        assert "signed by nobody whom this gateway trusts" in seen["rollout"]["stopped"]
        assert seen["gateways"][0]["current"] == "1.0.0"
        (folder / "1.1.0.release").unlink()
        release_of(folder, "1.2.0")
        handing = asyncio.create_task(hand_out("1.2.0"))
        # It ends in favour of the new one; its service manager starts it again.
        assert await running.wait() == 0
        running = await start_program(*words)
        await handing
        seen = await overview(admin)
        assert seen["rollout"]["stopped"] == ""
        assert seen["gateways"][0]["current"] == "1.2.0"
        assert slots.read_state().previous == "1.0.0"
        assert not list((root / "from-hub").iterdir())
    finally:
        running.send_signal(15)
        await running.wait()
