"""``talaia update``: a publisher's key, a signed wheel, and the environment made of it."""

from __future__ import annotations

import base64
import hashlib
import stat
import subprocess
import zipfile
from pathlib import Path

import pytest

from talaia.cli.main import main


def write_wheel(folder: Path, version: str) -> Path:
    """Write a wheel whose program ``talaia`` says its version, as PEP 427 has it."""
    info = f"talaia-{version}.dist-info"
    files = {
        "talaia_stand_in.py": f"def main():\n    print('talaia {version}')\n",
        f"{info}/METADATA": f"Metadata-Version: 2.1\nName: talaia\nVersion: {version}\n",
        f"{info}/WHEEL": "Wheel-Version: 1.0\nRoot-Is-Purelib: true\nTag: py3-none-any\n",
        f"{info}/entry_points.txt": "[console_scripts]\ntalaia = talaia_stand_in:main\n",
    }
    path = folder / f"talaia-{version}-py3-none-any.whl"
    with zipfile.ZipFile(path, "w") as archive:
        record = ""
        for name, text in files.items():
            archive.writestr(name, text)
            digest = base64.urlsafe_b64encode(hashlib.sha256(text.encode()).digest())
            record += f"{name},sha256={digest.decode().rstrip('=')},{len(text)}\n"
        archive.writestr(f"{info}/RECORD", record + f"{info}/RECORD,,\n")
    return path


@pytest.fixture
def signed(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> Path:
    """A folder with a publisher's key, its public half, and two releases."""
    assert main(["update", "key", str(tmp_path / "publisher.pem")]) == 0
    (tmp_path / "publisher.pub").write_text(capsys.readouterr().out)
    for version in ("1.0.0", "1.1.0"):
        wheel = write_wheel(tmp_path, version)
        words = ["update", "sign", str(tmp_path / version), str(wheel), "--version", version]
        assert main([*words, "--key", str(tmp_path / "publisher.pem")]) == 0
    return tmp_path


def trusting(folder: Path) -> list[str]:
    """Give the words of whom to trust, and for which site."""
    root = ["--root", str(folder / "software"), "--site", "agv"]
    return [*root, "--publisher", str(folder / "publisher.pub")]


def test_releases_are_installed_beside_each_other_and_the_first_one_runs(
    signed: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    assert main(["update", "setup", str(signed / "1.0.0"), *trusting(signed)]) == 0
    assert main(["update", "install", str(signed / "1.1.0"), *trusting(signed)]) == 0
    for version in ("1.0.0", "1.1.0"):
        program = signed / "software" / "releases" / version / "bin" / "talaia"
        done = subprocess.run([program], capture_output=True, text=True, check=True)
        assert done.stdout == f"talaia {version}\n"
    capsys.readouterr()
    assert main(["update", "status", "--root", str(signed / "software")]) == 0
    assert capsys.readouterr().out == "current: 1.0.0\nnext:    1.1.0 (waiting)\n"
    assert (signed / "software" / "current").resolve().name == "1.0.0"


def test_refusals_say_why_and_change_nothing(
    signed: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    install = ["update", "install", str(signed / "1.1.0"), *trusting(signed)]
    assert main(install) == 2
    assert "begin with: talaia update setup" in capsys.readouterr().err
    (signed / "publisher.pub").write_text("0" * 64)
    assert main(install) == 2
    assert "signed by nobody whom this gateway trusts" in capsys.readouterr().err
    (signed / "publisher.pub").write_text("mine")
    assert main(install) == 2
    assert "64 hexadecimal digits" in capsys.readouterr().err
    assert not (signed / "software" / "releases").exists()


def test_a_publishers_key_is_its_owners_alone_and_is_not_written_over(
    signed: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    key = signed / "publisher.pem"
    assert stat.S_IMODE(key.stat().st_mode) == 0o600
    before = key.read_bytes()
    assert main(["update", "key", str(key)]) == 2
    assert "File exists" in capsys.readouterr().err
    assert key.read_bytes() == before


def test_a_release_is_of_the_version_of_its_wheel(
    signed: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    sign = ["update", "sign", str(signed / "new"), "--key", str(signed / "publisher.pem")]
    own = str(write_wheel(signed, "1.2.0.dev3+g1a2b3c4d"))
    assert main([*sign, own, "--version", "1.2.0"]) == 2
    said = capsys.readouterr().err
    assert "the wheel of Talaia is 1.2.0.dev3+g1a2b3c4d, not 1.2.0 (--version)" in said
    assert main([*sign, str(signed / "numpy-2.0.0-py3-none-any.whl")]) == 2
    assert "none of them is" in capsys.readouterr().err
    assert main([*sign, own, str(signed / "talaia-1.0.0-py3-none-any.whl")]) == 2
    assert "2 of them are" in capsys.readouterr().err
    assert not (signed / "new").exists()
    assert main([*sign, own]) == 0
    assert "(1.2.0.dev3+g1a2b3c4d)" in capsys.readouterr().out
