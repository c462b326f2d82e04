"""Check names and sizes in the package: figures that may only become better.

    .venv/bin/python tools/check_names.py            compare with tools/ceilings.json
    .venv/bin/python tools/check_names.py --list     also every place that counts
    .venv/bin/python tools/check_names.py --write    lower the ceilings to what is there now

A figure above its ceiling fails. A ceiling is lowered by whoever made the figure better, so that
it stays so. The goals stand in docs/glossary.md.
"""

from __future__ import annotations

import argparse
import ast
import io
import json
import sys
import tokenize
from collections import defaultdict
from pathlib import Path
from typing import TypeGuard

ROOT = Path(__file__).resolve().parent.parent
PACKAGE = ROOT / "src" / "talaia"
CEILINGS = ROOT / "tools" / "ceilings.json"

# Verbs and words that say nothing alone.
EMPTY_NAMES = frozenset(
    {"take", "look", "tell", "say", "said", "told", "put", "give", "note", "go", "do"}
)
# Says of what a loop goes through, or a function takes, nothing at all.
EMPTY_VARIABLES = frozenset({"each"})
# Python's own protocol for files asks for a method of this name.
FILE_METHODS = frozenset({"tell"})
MOST_PARAMETERS = 4
MOST_FILE_LINES = 500
MOST_CLASS_LINES = 300
MOST_FUNCTION_LINES = 80
MOST_FILES = 20
SHARE_SLACK = 0.3
# Alembic names the files; each is a step of its own.
FLAT_FOLDERS = frozenset({"hub/store/migrations/versions"})
# Decorators of frameworks that call by name, or by their own rules.
ROUTE_DECORATORS = frozenset({"get", "post", "put", "patch", "delete", "websocket", "head"})

Function = ast.FunctionDef | ast.AsyncFunctionDef


def lines_of(node: Function | ast.ClassDef, lines: list[str]) -> int:
    """Count a definition's lines, without its decorators and without lines of comment alone.

    A limit that counted them would make the hardest classes those with the fewest comments.
    """
    inside = lines[node.lineno - 1 : node.end_lineno]
    return sum(1 for line in inside if not line.lstrip().startswith("#"))


def is_route(node: Function) -> bool:
    """Tell whether a web framework calls a function, by the names of its parameters."""
    for decorator in node.decorator_list:
        called = decorator.func if isinstance(decorator, ast.Call) else decorator
        if isinstance(called, ast.Attribute) and called.attr in ROUTE_DECORATORS:
            return True
    return False


def has_many_positional(node: Function) -> bool:
    """Tell whether a function takes more than `MOST_PARAMETERS` by position."""
    names = [argument.arg for argument in (*node.args.posonlyargs, *node.args.args)]
    if names and names[0] in {"self", "cls"}:
        names = names[1:]
    return len(names) > MOST_PARAMETERS and not is_route(node)


def is_empty_variable(node: ast.AST) -> TypeGuard[ast.Name | ast.arg]:
    """Tell whether a node binds a variable or a parameter to a name that says nothing."""
    if isinstance(node, ast.Name):
        return isinstance(node.ctx, ast.Store) and node.id in EMPTY_VARIABLES
    return isinstance(node, ast.arg) and node.arg in EMPTY_VARIABLES


def is_file_like(node: ast.ClassDef) -> bool:
    """Tell whether a class is a file for another library: it has ``write`` and ``writable``."""
    names = {inner.name for inner in node.body if isinstance(inner, Function)}
    return {"write", "writable"} <= names


def count_comment_lines(source: str) -> int:
    """Count lines that are, or end in, a comment; marks for tools do not count."""
    lines = set()
    for token in tokenize.generate_tokens(io.StringIO(source).readline):
        text = token.string.lstrip("# ")
        if token.type == tokenize.COMMENT and not text.startswith(("noqa", "type:", "fmt:")):
            lines.add(token.start[0])
    return len(lines)


class Findings:
    """Places for each figure, by the figure's name."""

    def __init__(self) -> None:
        """Start with nothing read."""
        self.places: dict[str, list[str]] = defaultdict(list)
        self.class_files: dict[str, list[str]] = defaultdict(list)
        self.file_methods: set[int] = set()
        self.functions = 0
        self.one_word = 0
        self.code_lines = 0
        self.comment_lines = 0

    def add_file(self, path: Path) -> None:
        """Read one module."""
        source = path.read_text()
        name = path.relative_to(PACKAGE).as_posix()
        lines = source.splitlines()
        if len(lines) > MOST_FILE_LINES:
            self.places["files over 500 lines"].append(f"{name}: {len(lines)}")
        if "fmt: skip" in source:
            places = [f"{name}:{n}" for n, line in enumerate(lines, 1) if "fmt: skip" in line]
            self.places["lines that the formatter skips"] += places
        self.code_lines += sum(1 for line in lines if line.strip())
        self.comment_lines += count_comment_lines(source)
        tree = ast.parse(source)
        for node in tree.body:
            if isinstance(node, ast.ClassDef) and not node.name.startswith("_"):
                self.class_files[node.name].append(f"{name}:{node.lineno}")
        for node in ast.walk(tree):
            if isinstance(node, ast.ClassDef) and is_file_like(node):
                self.file_methods.update(id(inner) for inner in node.body)
            if isinstance(node, ast.ClassDef) and lines_of(node, lines) > MOST_CLASS_LINES:
                place = f"{name}:{node.lineno} {node.name}: {lines_of(node, lines)}"
                self.places["classes over 300 lines"].append(place)
            if isinstance(node, ast.FunctionDef | ast.AsyncFunctionDef):
                self._add_function(name, node, lines)
            if is_empty_variable(node):
                self.places["variables called each"].append(f"{name}:{node.lineno}")

    def _add_function(self, name: str, node: Function, lines: list[str]) -> None:
        place = f"{name}:{node.lineno} {node.name}"
        bare = node.name.strip("_")
        if not node.name.startswith("__"):
            self.functions += 1
            self.one_word += "_" not in bare
        is_of_file = node.name in FILE_METHODS and id(node) in self.file_methods
        if bare in EMPTY_NAMES and not is_of_file:
            self.places["functions named by an empty verb"].append(place)
        if lines_of(node, lines) > MOST_FUNCTION_LINES:
            long = f"{place}: {lines_of(node, lines)}"
            self.places["functions over 80 lines"].append(long)
        if has_many_positional(node):
            self.places["functions with over 4 positional parameters"].append(place)

    def add_folder(self, folder: Path) -> None:
        """Count the modules of one folder."""
        name = folder.relative_to(PACKAGE).as_posix()
        files = len([path for path in folder.glob("*.py") if path.name != "__init__.py"])
        if files > MOST_FILES and name not in FLAT_FOLDERS:
            self.places["folders over 20 modules"].append(f"{name}: {files}")

    def figures(self) -> dict[str, float]:
        """Give each figure; a smaller one is better."""
        twice = {name: files for name, files in self.class_files.items() if len(files) > 1}
        self.places["public class names in several files"] = [
            f"{name}: {', '.join(files)}" for name, files in sorted(twice.items())
        ]
        names = (
            "public class names in several files",
            "functions named by an empty verb",
            "variables called each",
            "functions with over 4 positional parameters",
            "files over 500 lines",
            "classes over 300 lines",
            "functions over 80 lines",
            "folders over 20 modules",
            "lines that the formatter skips",
        )
        counted: dict[str, float] = {name: len(self.places[name]) for name in names}
        counted["function names of one word (%)"] = round(100 * self.one_word / self.functions, 1)
        share = 100 * self.comment_lines / self.code_lines
        counted["lines without a comment (%)"] = round(100 - share, 1)
        return counted


def main(arguments: list[str]) -> int:
    """Print each figure beside its ceiling; 1 when one is above it."""
    parser = argparse.ArgumentParser(description="Check names and sizes in the package.")
    parser.add_argument("--list", action="store_true", help="print every place that counts")
    parser.add_argument("--write", action="store_true", help="lower the ceilings")
    chosen = parser.parse_args(arguments)
    findings = Findings()
    for path in sorted(PACKAGE.rglob("*.py")):
        findings.add_file(path)
    for folder in sorted({path.parent for path in PACKAGE.rglob("*.py")}):
        findings.add_folder(folder)
    figures = findings.figures()
    ceilings: dict[str, float] = json.loads(CEILINGS.read_text()) if CEILINGS.exists() else {}
    above = 0
    for name, figure in figures.items():
        ceiling = ceilings.get(name, figure)
        # A share moves a little with every line that is written.
        is_above = figure > ceiling + (SHARE_SLACK if "%" in name else 0)
        mark = "ABOVE ITS CEILING" if is_above else ""
        above += is_above
        print(f"{figure:7g}  (at most {ceiling:g})  {name} {mark}")
        if chosen.list:
            for place in findings.places.get(name, ()):
                print(f"         {place}")
    if chosen.write:
        lowered = {name: min(now, ceilings.get(name, now)) for name, now in figures.items()}
        CEILINGS.write_text(json.dumps(lowered, indent=1) + "\n")
        return 0
    if above:
        print("--list prints the places")
    return 1 if above else 0


if __name__ == "__main__":
    raise SystemExit(main(sys.argv[1:]))
