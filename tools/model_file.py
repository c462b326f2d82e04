"""Keeps the file of a model that a script makes: in the tree, and in the user's folder.

What a model is made of is large, what is needed of it small; so the file is kept in the user's
folder for such things (``$XDG_CACHE_HOME/talaia``), and the next clone takes it from there.
"""

from __future__ import annotations

import contextlib
import hashlib
import os
import sys
import tempfile
from pathlib import Path
from typing import TYPE_CHECKING, NamedTuple

if TYPE_CHECKING:
    from collections.abc import Callable

ROOT = Path(__file__).resolve().parent.parent


class Problem(Exception):
    """The package is not what the script knows."""


class ModelFile(NamedTuple):
    """A file, and how it is known.

    Attributes:
        target: in the tree, ``src/talaia/objects/models/<name>.onnx``.
        sha256: of the file as it is made (hex).
        what: it is, for people, such as ``the object detector``.
        announced: what is printed before anything is fetched.

    """

    target: Path
    sha256: str
    what: str
    announced: str

    def kept(self) -> Path:
        """Tell where the file is kept for the next clone."""
        base = os.environ.get("XDG_CACHE_HOME") or "~/.cache"
        name = f"{self.target.stem}-{self.sha256[:16]}{self.target.suffix}"
        return Path(base).expanduser() / "talaia" / name

    def is_good(self, path: Path) -> bool:
        """Tell whether the file that the script makes is there, whole."""
        try:
            with path.open("rb") as file:
                return hashlib.file_digest(file, "sha256").hexdigest() == self.sha256
        except OSError:
            return False

    def make(
        self,
        make: Callable[[Path], bytes],
        failures: tuple[type[Exception], ...],
        *,
        anew: bool,
    ) -> int:
        """Make the file when it is not there; give 1 when it cannot be made.

        ``make`` gives its bytes with the help of a folder that goes again; ``failures`` are what
        it raises beside `Problem` where that is not to be had.
        """
        if self.is_good(self.target) and not anew:
            return 0
        if self.is_good(self.kept()) and not anew:
            write_whole(self.target, self.kept().read_bytes())
            return 0
        print(f"talaia set-up: {self.announced} …", flush=True)
        try:
            with tempfile.TemporaryDirectory() as folder:
                made = make(Path(folder))
        except (Problem, OSError, *failures) as problem:
            print(f"{self.what} cannot be made: {problem}", file=sys.stderr)
            return 1
        write_whole(self.target, made)
        found = hashlib.sha256(made).hexdigest()
        if found != self.sha256:
            shown = self.target.relative_to(ROOT)
            print(f"{shown} is not the one that is known: {found}", file=sys.stderr)
            return 1
        with contextlib.suppress(OSError):  # whoever cannot keep it fetches it again
            write_whole(self.kept(), made)
        return 0


def write_whole(path: Path, made: bytes) -> None:
    """Write a file that is either whole or not there."""
    path.parent.mkdir(parents=True, exist_ok=True)
    beside = path.with_name(f"{path.name}.{os.getpid()}")
    beside.write_bytes(made)
    beside.replace(path)
