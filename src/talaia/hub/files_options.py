"""Options that say where recordings and pictures are kept; of the hub, and of who moves them."""

from __future__ import annotations

from pathlib import Path
from typing import TYPE_CHECKING

from talaia.hub.settings import Settings

if TYPE_CHECKING:
    import argparse

__all__ = ["add_files_options", "read_files_settings"]


def add_files_options(parser: argparse.ArgumentParser, *, required: bool = False) -> None:
    """Add them; ``required``: a bucket must be named."""
    parser.add_argument(
        "--files",
        default="",
        required=required,
        metavar="URL",
        help="bucket of an object store that speaks S3 (s3://bucket/folder), for recordings, films"
        " and the archive's pictures (the data folder)",
    )
    parser.add_argument(
        "--files-endpoint",
        default="",
        metavar="URL",
        help="address of that store (https://store.example:9000; AWS's own)",
    )
    parser.add_argument(
        "--files-region", default="", metavar="NAME", help="region of that store (us-east-1)"
    )
    parser.add_argument(
        "--files-key-file",
        type=Path,
        metavar="FILE",
        help="file with the key's id and its secret, a line each, so that none stands in a list of"
        " processes (AWS_ACCESS_KEY_ID and AWS_SECRET_ACCESS_KEY)",
    )
    said = "certificate authorities of that store (PEM), besides the system's"
    parser.add_argument("--files-ca", type=Path, metavar="FILE", help=said)


def read_files_settings(options: argparse.Namespace, data: Path) -> Settings:
    """Give settings in which nothing is said but a data folder and where its files are kept."""
    return Settings(
        data=data,
        files=options.files,
        files_endpoint=options.files_endpoint,
        files_region=options.files_region,
        files_key_file=options.files_key_file,
        files_ca=options.files_ca,
    )
