"""What every demo does alike: a folder that goes again, throw-away people, and the greeting."""

from __future__ import annotations

import secrets
import shutil
import tempfile
from contextlib import contextmanager
from pathlib import Path
from typing import TYPE_CHECKING, NamedTuple

from talaia.cli.errors import CliError
from talaia.hub import accounts
from talaia.hub.errors import NameTaken

if TYPE_CHECKING:
    from collections.abc import Iterator, Sequence

    from talaia.hub.settings import Settings

__all__ = ["Login", "example", "folder", "greet", "make_logins"]

ROLES = ("admin", "operator", "guest")


class Login(NamedTuple):
    """A throw-away account."""

    name: str
    password: str
    role: str


@contextmanager
def folder(kept: Path | None, prefix: str) -> Iterator[Path]:
    """Give the folder to keep things in, or one that is removed again."""
    data = kept or Path(tempfile.mkdtemp(prefix=prefix))
    data.mkdir(parents=True, exist_ok=True, mode=0o700)
    try:
        yield data
    finally:
        if kept is None:
            shutil.rmtree(data, ignore_errors=True)


async def make_logins(settings: Settings) -> list[Login]:
    """Make a person of each role; in a kept folder the same people get new passwords."""
    logins = [Login(role, secrets.token_urlsafe(6), role) for role in ROLES]
    for login in logins:
        try:
            await accounts.create_user(settings, *login)
        except NameTaken:
            await accounts.set_password(settings, login.name, login.password)
    return logins


def example(name: str) -> Path:
    """Find an example: in this tree, or beside the installed package."""
    package = Path(__file__).resolve().parent.parent
    for base in (package.parent.parent / "examples", package / "examples"):
        if (base / name / "site.yaml").exists():
            return base / name / "site.yaml"
    raise CliError(f"the example description {name}/site.yaml was not installed")


def greet(address: str, logins: Sequence[Login], data: Path, took: float) -> None:
    """Say where the demo is, who may come in, and how it ends."""
    width = max(len(login.name) for login in logins)
    print(f"\n  Talaia is ready ({took:.1f} s):  {address}\n")
    print("  throw-away accounts, made for this demo only:")
    for login in logins:
        print(f"    {login.name:<{width}}   {login.password}")
    print(f"\n  data and logs: {data}\n  Ctrl-C stops everything.", flush=True)
