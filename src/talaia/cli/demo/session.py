"""What every demo does alike: a folder, throw-away people, descriptions, and the greeting."""

from __future__ import annotations

import hashlib
import secrets
import shlex
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

__all__ = [
    "Login",
    "data_folder",
    "find_example",
    "is_changed",
    "make_logins",
    "print_greeting",
    "write_description",
]

# The built-in roles; each login is named as its role.
ROLES = ("admin", "operator", "guest")


class Login(NamedTuple):
    """A throw-away account."""

    name: str
    # In the clear, for it is printed once; the database has its hash.
    password: str
    role: str


@contextmanager
def data_folder(kept: Path | None, prefix: str) -> Iterator[Path]:
    """Give the folder to keep things in, or one that is removed again."""
    data = kept or Path(tempfile.mkdtemp(prefix=prefix))
    data.mkdir(parents=True, exist_ok=True, mode=0o700)
    try:
        yield data
    finally:
        if kept is None:
            # A file that cannot be removed must not hide why the demo ended.
            shutil.rmtree(data, ignore_errors=True)


async def make_logins(settings: Settings) -> list[Login]:
    """Make a person of each role; in a kept folder the same people get new passwords."""
    # Made at random each time: others on the machine can reach the demo, too.
    logins = [Login(role, secrets.token_urlsafe(9), role) for role in ROLES]
    for login in logins:
        try:
            await accounts.create_user(settings, *login)
        except NameTaken:
            await accounts.set_password(settings, login.name, login.password)
    return logins


def find_example(name: str) -> Path:
    """Find an example: in this tree, or beside the installed package."""
    package = Path(__file__).resolve().parents[2]
    # The source tree before the package: who works on the examples wants to see his own.
    for base in (package.parent.parent / "examples", package / "examples"):
        if (base / name / "site.yaml").exists():
            return base / name / "site.yaml"
    raise CliError(f"the example description {name}/site.yaml was not installed")


def is_changed(path: Path) -> bool:
    """Tell whether somebody changed a description written by `write_description` earlier."""
    try:
        return _digest_of(path.read_text()) != _digest_file(path).read_text()
    except FileNotFoundError:
        # Of a demo that did not note yet what it wrote: it may hold somebody's work.
        return path.exists()


def write_description(path: Path, text: str) -> None:
    """Write a description, and note that it is the demo's own."""
    path.write_text(text)
    # After the text: cut short between the two, the file counts as changed and is left alone.
    _digest_file(path).write_text(_digest_of(text))


def _digest_file(path: Path) -> Path:
    return path.with_name(f".{path.name}.written")


def _digest_of(text: str) -> str:
    return hashlib.sha256(text.encode()).hexdigest()


def print_greeting(
    address: str,
    logins: Sequence[Login],
    *,
    data: Path,
    took: float,
    changed: Sequence[Path] = (),
    notes: Sequence[str] = (),
) -> None:
    """Say where the demo is, who may come in, and how it ends.

    ``changed`` are descriptions that are not the examples, for somebody changed them; ``notes``
    say what does not work here.
    """
    width = max(len(login.name) for login in logins)
    print(f"\n  Talaia is ready ({took:.1f} s):  {address}\n")
    print("  throw-away accounts, made for this demo only:")
    for login in logins:
        print(f"    {login.name:<{width}}   {login.password}")
    for path in changed:
        print(
            f"\n  {path.name} was changed in an earlier run and stays so;"
            f"\n  for the example again, end the demo and run: rm {shlex.quote(str(path))}"
        )
    for note in notes:
        print(f"\n  {note}")
    print(f"\n  data and logs: {data}\n  Ctrl-C stops everything.", flush=True)
