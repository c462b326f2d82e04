"""Whatever makes keys, accounts or recordings makes files that only their owner can read."""

from __future__ import annotations

import stat
import subprocess
import sys
from typing import TYPE_CHECKING

from patience import PATIENCE_S

if TYPE_CHECKING:
    from pathlib import Path

QUIET = "talaia: 1\nsite: quiet\nname: Quiet\ndevices: {hut: {name: Hut}}\n"


def open_to_others(folder: Path) -> list[str]:
    """List what below a folder anybody else may look into."""
    return [
        str(path.relative_to(folder.parent))
        for path in (folder, *folder.rglob("*"))
        if stat.S_IMODE(path.stat().st_mode) & 0o077
    ]


def test_a_hubs_folder_is_its_owners_alone_whatever_the_machines_umask(tmp_path: Path) -> None:
    words = [sys.executable, "-m", "talaia", "enrol", "agv", "--data", str(tmp_path / "hub")]
    subprocess.run(words, check=True, capture_output=True, umask=0o022)
    assert list((tmp_path / "hub").iterdir())
    assert open_to_others(tmp_path / "hub") == []


def test_a_gateways_folder_is_its_owners_alone_whatever_the_machines_umask(tmp_path: Path) -> None:
    (tmp_path / "site.yaml").write_text(QUIET)
    (tmp_path / "key").write_text("key")
    words = [sys.executable, "-m", "talaia", "gateway", str(tmp_path / "site.yaml")]
    words += ["--hub", "ws://127.0.0.1:1", "--allow-plain", "--key-file", str(tmp_path / "key")]
    with subprocess.Popen(
        [*words, "--data", str(tmp_path / "data")], stderr=subprocess.PIPE, text=True, umask=0o022
    ) as gateway:
        assert gateway.stderr is not None
        # It dials: everything of its folder is there.
        assert any("cannot be reached" in line for line in gateway.stderr)
        gateway.terminate()
        gateway.communicate(timeout=PATIENCE_S)
    assert list((tmp_path / "data").iterdir())
    assert open_to_others(tmp_path / "data") == []
