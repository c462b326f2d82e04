"""Which addresses and keys of a bucket are taken, and that none of a key is ever shown."""

from __future__ import annotations

from pathlib import Path

import pytest

from talaia.hub.errors import CannotStart
from talaia.hub.files.bucket_address import read_bucket_address
from talaia.hub.settings import Settings

pytestmark = pytest.mark.pure
KEYS = {"AWS_ACCESS_KEY_ID": "AKIDKNOWN", "AWS_SECRET_ACCESS_KEY": "s3cr3t-words"}


def settings_of(files: str, **more) -> Settings:
    return Settings(data=Path(), files=files, **more)


def test_a_hub_without_a_bucket_keeps_files_in_its_folder() -> None:
    assert read_bucket_address(settings_of(""), {}) is None


def test_an_address_has_a_bucket_a_folder_a_store_and_a_key() -> None:
    settings = settings_of(
        "s3://robots/east/hub/", files_endpoint="https://store.example:9000/", files_region="eu"
    )
    found = read_bucket_address(settings, KEYS)
    assert found is not None
    assert (found.bucket, found.prefix, found.region) == ("robots", "east/hub", "eu")
    assert (found.url, found.endpoint) == ("s3://robots/east/hub", "https://store.example:9000")
    assert found.key is not None
    assert tuple(found.key) == ("AKIDKNOWN", "s3cr3t-words", "")
    # Whoever prints it, a log or a traceback, shows nothing of the key.
    assert "s3cr3t" not in repr(found)
    assert "AKIDKNOWN" not in repr(found)


def test_a_key_file_goes_before_the_environment(tmp_path) -> None:
    file = tmp_path / "key"
    file.write_text("AKIDFILE\nof-the-file\n")
    found = read_bucket_address(settings_of("s3://robots", files_key_file=file), KEYS)
    assert found is not None
    assert found.key is not None
    assert found.key.id == "AKIDFILE"
    assert (found.prefix, found.url) == ("", "s3://robots")


def test_a_cloud_that_lends_keys_needs_none() -> None:
    found = read_bucket_address(
        settings_of("s3://robots"), {"AWS_WEB_IDENTITY_TOKEN_FILE": "/run/token"}
    )
    assert found is not None
    assert found.key is None


@pytest.mark.parametrize(
    ("files", "more", "said"),
    [
        ("s3://AKIDSHOWN:s3cr3t-words@robots", {}, "no key and no question"),
        ("s3://robots?secret=s3cr3t-words", {}, "no key and no question"),
        ("https://robots", {}, "expected the address of a bucket"),
        ("robots", {}, "expected the address of a bucket"),
        ("s3://r", {}, "expected the address of a bucket"),
        ("s3://robots/../others", {}, "other signs"),
        ("s3://robots/a//b", {}, "other signs"),
        ("s3://robots", {"files_endpoint": "http://store.example"}, "in clear text"),
        ("s3://robots", {"files_endpoint": "https://a:s3cr3t-words@store"}, "no key may stand"),
        ("s3://robots", {"files_endpoint": "store:9000"}, "expected the address of a store"),
        ("s3://robots", {"files_key_file": Path("/nowhere/key")}, "cannot be read: No such file"),
        ("s3://robots", {"files_ca": Path("/nowhere/ca")}, "cannot be read: No such file"),
    ],
)
def test_what_does_not_fit_is_refused_without_showing_a_secret(files, more, said) -> None:
    with pytest.raises(CannotStart) as refused:
        read_bucket_address(settings_of(files, **more), KEYS)
    assert said in str(refused.value)
    assert "s3cr3t" not in str(refused.value)
    assert refused.value.remedy


def test_a_bucket_without_a_key_is_refused_with_what_to_do(tmp_path) -> None:
    with pytest.raises(CannotStart, match="AWS_ACCESS_KEY_ID"):
        read_bucket_address(settings_of("s3://robots"), {"AWS_ACCESS_KEY_ID": "alone"})
    file = tmp_path / "key"
    file.write_text("one-word-s3cr3t")
    with pytest.raises(CannotStart, match="two lines") as refused:
        read_bucket_address(settings_of("s3://robots", files_key_file=file), {})
    assert "s3cr3t" not in str(refused.value)


def test_a_store_on_this_machine_needs_no_tls() -> None:
    settings = settings_of("s3://robots", files_endpoint="http://127.0.0.1:9000")
    assert read_bucket_address(settings, KEYS) is not None
