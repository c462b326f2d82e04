"""Only what the publisher has signed, for this gateway, whole and unchanged, is unpacked."""

from __future__ import annotations

import zipfile
from pathlib import Path

import msgspec
import pytest
from cryptography.hazmat.primitives.asymmetric.ed25519 import Ed25519PrivateKey

from talaia.updates.errors import UpdateError, UpdateRefused
from talaia.updates.signed_release import open_release, public_key_of, sign_release

KEY = Ed25519PrivateKey.generate()
WHEEL = "talaia-1.1.0-py3-none-any.whl"


@pytest.fixture
def release(tmp_path: Path) -> Path:
    (tmp_path / WHEEL).write_bytes(b"wheel" * 1_000)
    (tmp_path / "numpy-2.0-py3-none-any.whl").write_bytes(b"another")
    wheels = sorted(tmp_path.glob("*.whl"))
    sign_release(wheels, tmp_path / "release", KEY, version="1.1.0", site="agv")
    return tmp_path / "release"


def rewrite(release: Path, changes: dict[str, bytes]) -> Path:
    """Write the release with other contents of some files."""
    other = release.with_name("other")
    with zipfile.ZipFile(release) as source, zipfile.ZipFile(other, "x") as target:
        for name in [*source.namelist(), *(set(changes) - set(source.namelist()))]:
            target.writestr(name, changes[name] if name in changes else source.read(name))
    return other


def signed_text(**manifest: object) -> dict[str, bytes]:
    """Sign another list with the right key."""
    text = msgspec.json.encode(manifest)
    return {"manifest.json": text, "manifest.sig": KEY.sign(b"talaia release 1\n" + text)}


def test_what_the_publisher_signed_comes_out_as_it_went_in(release: Path, tmp_path: Path) -> None:
    found = open_release(
        release, [Ed25519PrivateKey.generate().public_key(), KEY.public_key()], "agv"
    )
    assert found.manifest.version == "1.1.0"
    (tmp_path / "out").mkdir()
    written = found.unpack_wheels(tmp_path / "out")
    assert {path.name: path.read_bytes() for path in written} == {
        WHEEL: b"wheel" * 1_000,
        "numpy-2.0-py3-none-any.whl": b"another",
    }


def test_the_key_of_somebody_else_opens_nothing(release: Path) -> None:
    for keys in ([], [Ed25519PrivateKey.generate().public_key()]):
        with pytest.raises(UpdateRefused, match="signed by nobody"):
            open_release(release, keys, "agv")


def test_a_changed_list_or_signature_is_refused(release: Path) -> None:
    with zipfile.ZipFile(release) as archive:
        text, signature = archive.read("manifest.json"), archive.read("manifest.sig")
    forged = {
        "manifest.json": text.replace(b"1.1.0", b"9.9.9", 1),
        "manifest.sig": bytes([signature[0] ^ 1]) + signature[1:],
    }
    for name, content in forged.items():
        other = rewrite(release, {name: content})
        with pytest.raises(UpdateRefused, match="signed by nobody"):
            open_release(other, [KEY.public_key()], "agv")
        other.unlink()
    # Signed by the key for something else.
    other = rewrite(release, {"manifest.sig": KEY.sign(text)})
    with pytest.raises(UpdateRefused, match="signed by nobody"):
        open_release(other, [KEY.public_key()], "agv")


def test_a_release_for_another_site_is_refused_and_one_for_all_is_not(
    release: Path, tmp_path: Path
) -> None:
    with pytest.raises(UpdateRefused, match="for the gateway of agv, not for dome"):
        open_release(release, [KEY.public_key()], "dome")
    sign_release([tmp_path / WHEEL], tmp_path / "all", KEY, version="1.1.0")
    assert open_release(tmp_path / "all", [KEY.public_key()], "dome").manifest.site == ""


def test_a_swapped_wheel_is_refused_before_anything_runs(release: Path, tmp_path: Path) -> None:
    found = open_release(rewrite(release, {WHEEL: b"evil!" * 1_000}), [KEY.public_key()], "agv")
    (tmp_path / "out").mkdir()
    with pytest.raises(UpdateRefused, match="not the file that was signed"):
        found.unpack_wheels(tmp_path / "out")


@pytest.mark.parametrize("share", [0.0, 0.3, 0.6, 0.9, 0.99])
def test_a_truncated_file_is_refused(release: Path, tmp_path: Path, share: float) -> None:
    whole = release.read_bytes()
    cut = tmp_path / "cut"
    cut.write_bytes(whole[: int(len(whole) * share)])
    with pytest.raises(UpdateRefused, match="not whole"):
        open_release(cut, [KEY.public_key()], "agv")


def test_a_damaged_wheel_is_refused(release: Path, tmp_path: Path) -> None:
    content = bytearray(release.read_bytes())
    content[content.index(b"another")] ^= 1
    release.write_bytes(content)
    (tmp_path / "out").mkdir()
    with pytest.raises(UpdateRefused):
        open_release(release, [KEY.public_key()], "agv").unpack_wheels(tmp_path / "out")


def test_a_signed_list_is_still_held_against_its_form(release: Path) -> None:
    digest = "0" * 64
    for manifest, said in (
        ({"form": 2, "version": "1.1.0", "files": {WHEEL: digest}}, "form 2"),
        ({"form": 1, "version": "1.1.0", "files": {"../x.whl": digest}}, "no name of a wheel"),
        ({"form": 1, "version": "1.1.0", "files": {}}, "another form"),
        ({"form": 1, "version": "1.1.0", "files": {WHEEL: "x"}}, "another form"),
        ({"form": 1, "version": "../..", "files": {WHEEL: digest}}, "no version"),
        ({"form": 1, "version": "1.1.0", "files": {WHEEL: digest}, "run": "x"}, "another form"),
    ):
        other = rewrite(release, signed_text(**manifest))
        with pytest.raises(UpdateError, match=said):
            open_release(other, [KEY.public_key()], "agv")
        other.unlink()


def test_a_key_is_64_hexadecimal_digits() -> None:
    text = KEY.public_key().public_bytes_raw().hex()
    assert public_key_of(f" {text}\n").public_bytes_raw().hex() == text
    for wrong in ("", "ab", text + "00", "zz" * 32):
        with pytest.raises(UpdateError):
            public_key_of(wrong)
