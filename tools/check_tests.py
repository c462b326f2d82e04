"""Hold tests to their places, and what they should hardly do to its number of today.

    .venv/bin/python tools/check_tests.py

A *replaced part* is a ``monkeypatch.setattr`` or something of `unittest.mock`. A *fixed wait* is a
``sleep`` that is in no loop: it waits for time and not for a condition. What a test *does* for some
time (a fault that lasts, a pause) stands in ``patience.lasts_for`` and is a number of its own.
The numbers only ever go down: who brings one down writes the new one here.

A test file lies in the folder of `tests` that mirrors its source's: `tests/gateway/safety` for
`src/talaia/gateway/safety`. How many are named after their module, too, only ever goes up.
"""

from __future__ import annotations

import ast
import sys
from pathlib import Path
from typing import TYPE_CHECKING

if TYPE_CHECKING:
    from collections.abc import Iterator

ROOT = Path(__file__).resolve().parent.parent
MOST = {"replaced parts": 61, "fixed waits": 0, "things that last": 35}
# The one place where a test may let time pass.
WAITS = "tests/patience.py"
# Tests of whole sites, and of what is no part of the package.
NO_MIRROR = ("system", "docs", "tools")
# File names that say nothing of what is held.
SAY_NOTHING = {"test_whole", "test_pieces", "test_any", "test_parts", "test_misc", "test_all"}
LEAST_NAMED_AFTER_MODULE = 0.7
MOCKS = {"Mock", "MagicMock", "AsyncMock", "patch", "create_autospec"}


def name_of(call: ast.Call) -> str:
    """Give the last word of what is called."""
    match call.func:
        case ast.Attribute(attr=name) | ast.Name(id=name):
            return name
    return ""


def is_replacement(call: ast.Call) -> bool:
    """Tell whether a call replaces a part of the program."""
    match call.func:
        case ast.Attribute(value=ast.Name(id="monkeypatch"), attr="setattr" | "setitem"):
            return True
    if isinstance(call.func, ast.Attribute) and any(word.arg == "json" for word in call.keywords):
        return False  # a request: HTTP's PATCH
    return name_of(call) in MOCKS


def is_wait(call: ast.Call) -> bool:
    """Tell whether a call waits for some time: ``sleep(0)`` only lets others have their turn."""
    if name_of(call) != "sleep" or not call.args:
        return False
    match call.args[0]:
        case ast.Constant(value=0):
            return False
    return True


def find(node: ast.AST, *, in_loop: bool = False) -> Iterator[tuple[int, str]]:
    """Find lines below ``node`` that count, and as what."""
    for child in ast.iter_child_nodes(node):
        inside = in_loop
        if isinstance(child, ast.While | ast.For | ast.AsyncFor):
            inside = True
        elif isinstance(child, ast.FunctionDef | ast.AsyncFunctionDef):
            inside = False
        if isinstance(child, ast.Call):
            if is_replacement(child):
                yield child.lineno, "replaced parts"
            elif name_of(child) in {"lasts_for", "blocks_for"}:
                yield child.lineno, "things that last"
            elif is_wait(child) and not in_loop:
                yield child.lineno, "fixed waits"
        yield from find(child, in_loop=inside)


def check_places() -> int:
    """Print each test file that lies in no mirrored folder, or has an empty name; 1 if one does."""
    tests, source = ROOT / "tests", ROOT / "src" / "talaia"
    strays, mirrored, named = [], 0, 0
    for path in sorted(tests.rglob("test_*.py")):
        place = path.relative_to(tests)
        if (
            path.stem in SAY_NOTHING
            and not (source / place.parent / f"{path.stem[5:]}.py").exists()
        ):
            strays.append(f"tests/{place.as_posix()} does not say what it holds")
        if place.parts[0] in NO_MIRROR:
            continue
        mirrored += 1
        module = source / place.parent / path.stem.removeprefix("test_")
        named += module.with_suffix(".py").exists() or module.is_dir()
        if not (source / place.parent).is_dir():
            strays.append(
                f"tests/{place.as_posix()}: no folder src/talaia/{place.parent.as_posix()}"
            )
    share = named / (mirrored or 1)
    print(f"{share:.1%} of {mirrored} test files are named after their module")
    print("\n".join(strays), end="\n" if strays else "")
    if share < LEAST_NAMED_AFTER_MODULE:
        print(f"at least {LEAST_NAMED_AFTER_MODULE:.0%} are to be")
    return int(bool(strays) or share < LEAST_NAMED_AFTER_MODULE)


def main() -> int:
    """Print each place of what is too often there; 1 when something is."""
    found: dict[str, list[str]] = {kind: [] for kind in MOST}
    tests = 0
    for path in sorted((ROOT / "tests").rglob("*.py")):
        tree = ast.parse(path.read_text())
        functions = (ast.FunctionDef, ast.AsyncFunctionDef)
        tests += sum(
            isinstance(node, functions) and node.name.startswith("test_") for node in ast.walk(tree)
        )
        place = path.relative_to(ROOT).as_posix()
        for line, kind in find(tree):
            if place != WAITS:
                found[kind].append(f"{place}:{line}")
    wrong = check_places()
    for kind, places in found.items():
        print(f"{len(places)} {kind} in {tests} tests; at most {MOST[kind]}")
        if len(places) > MOST[kind]:
            wrong = 1
            print("\n".join(places))
        elif len(places) < MOST[kind]:
            print(f"Write {len(places)} into tools/check_tests.py, so that it stays at that.")
    return wrong


if __name__ == "__main__":
    sys.exit(main())
