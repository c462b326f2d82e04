"""YAML text to `Site`; every error carries the path to the mistake."""

from __future__ import annotations

import os
import re
import stat
from typing import TYPE_CHECKING

import msgspec

from talaia.model.connection import ProcessConnection
from talaia.model.discovery.command_file import read_classic, site_of
from talaia.model.errors import DescriptionError, NotReadable
from talaia.model.site import Site
from talaia.model.yaml_text.document import dump_document, read_document
from talaia.model.yaml_text.meant_words import meant_word
from talaia.model.yaml_text.shape_sentences import shape_error
from talaia.model.yaml_text.source_tags import plain_of, with_tags
from talaia.model.yaml_text.version import require_current

if TYPE_CHECKING:
    from pathlib import Path

__all__ = [
    "beside_of",
    "dump_site",
    "load_site",
    "mapping_in",
    "mapping_of_text",
    "plain_of_text",
    "read_site",
    "require_own_keys",
    "require_short",
    "site_in",
    "site_of_plain",
    "text_of",
    "with_files",
]

_BEGIN = "begin with: talaia: 1; a first description comes from: talaia init"
MAX_BYTES = 4 * 1024 * 1024
_WIDE_TEXT = ("is UTF-16", "save it as UTF-8")
# What is taken for a description, by its first bytes.
_OTHER_FILES = (
    (b"\xff\xfe", *_WIDE_TEXT),
    (b"\xfe\xff", *_WIDE_TEXT),
    (b"\x1f\x8b", "is packed (gzip)", "unpack it: gunzip"),
    (b"PK\x03\x04", "is packed (zip)", "unpack it: unzip"),
)
# A key that is so like a known one was meant to be it.
_SURELY_OWN = 0.75


def read_site(path: Path) -> Site:
    """Load a description from a file, with the devices of the command files that it names.

    A JSON file is taken for a command file of the founding observatory, see `classic`.

    Raises:
        DescriptionError: a file cannot be read, or `load_site` refuses what it says.

    """
    return site_in(text_of(path), path)


def site_in(text: str, path: Path) -> Site:
    """Make a description of ``text`` as if it stood in a file; see `read_site`.

    Raises:
        DescriptionError: `load_site` refuses it, or a file that it names cannot be read.

    """
    if path.suffix == ".json":
        return site_of(text, _NO_WORD.sub("_", path.stem.lower()).strip("_0123456789") or "site")
    return with_files(load_site(text), path.parent)


def beside_of(site: Site, folder: Path) -> list[Path]:
    """Name the files that a description in ``folder`` takes in."""
    return [
        folder / connection.file
        for connection in site.connections.values()
        if isinstance(connection, ProcessConnection) and connection.file
    ]


# msgspec learns a type when it first converts to it, and two threads that do so at once end the
# process (a hub that two gateways reach in its first moments). Imports are done by one thread.
_LEARNED = msgspec.json.Decoder(Site)

_NO_WORD = re.compile(r"[^a-z0-9]+")


def with_files(site: Site, folder: Path) -> Site:
    """Take in the devices of command files; what the description says of the same one wins.

    Raises:
        DescriptionError: one cannot be read, or does not say what such a file says.

    """
    for name, connection in site.connections.items():
        if not isinstance(connection, ProcessConnection) or not connection.file:
            continue
        path = folder / connection.file
        # Where it cannot be read is its path already.
        text = text_of(path)
        try:
            found = read_classic(text, name)
        except DescriptionError as error:
            where = f"{path}: {error.where}"
            raise DescriptionError(where, error.problem, error.remedy) from error
        connection = msgspec.structs.replace(connection, prefix=connection.prefix or found.prefix)
        site = msgspec.structs.replace(
            site,
            connections={**site.connections, name: connection},
            devices={**found.devices, **site.devices},
        )
    return site


def text_of(path: Path) -> str:
    """Read a description's file, or one that it takes in.

    Raises:
        NotReadable: it cannot be read, is no file (a pipe, a folder), is too long, or is no text.

    """
    try:
        data = _bytes_of(path)
    except FileNotFoundError as error:
        remedy = "look at its name"
        if path.suffix in (".yaml", ".yml"):
            remedy += f"; a first description comes from: talaia init -o {path.name}"
        raise NotReadable(str(path), "there is no such file", remedy) from error
    except OSError as error:
        reason = error.strerror or str(error)
        raise NotReadable(str(path), f"cannot be read: {reason}") from error
    # UTF-16 without its mark: every second byte of what is written in our letters is 0.
    if data[1:2] == b"\0" or data[:1] == b"\0":
        raise NotReadable(str(path), *_WIDE_TEXT)
    try:
        return data.decode()
    except UnicodeDecodeError as error:
        raise _no_text(path, data, error.start) from error


def _no_text(path: Path, data: bytes, at: int) -> NotReadable:
    """Say what a file is that is no UTF-8."""
    for start, problem, remedy in _OTHER_FILES:
        if data.startswith(start):
            return NotReadable(str(path), problem, remedy)
    if b"\0" in data:
        return NotReadable(str(path), "is a program or data, and no text", "choose the right file")
    before = data[:at].decode()
    line, column = before.count("\n") + 1, len(before) - before.rfind("\n")
    # Where most of such files come from, this is what stands there.
    letter = data[at : at + 1].decode("cp1252", "replace")
    seen = f"; for Windows it is {letter}" if letter.isprintable() and letter != "\ufffd" else ""
    problem = f"a letter that is not written in UTF-8 (the byte 0x{data[at]:02X}{seen})"
    error = NotReadable(f"line {line}, column {column}", problem, "save the file as UTF-8")
    error.text = data.decode(errors="replace")
    return error


def _bytes_of(path: Path) -> bytes:
    # Not blocking: to open a pipe waits until somebody writes into it, which may be never.
    number = os.open(path, os.O_RDONLY | os.O_NONBLOCK | os.O_CLOEXEC)
    try:
        # Asked of what is open: the name may be given to something else between two questions.
        mode = os.fstat(number).st_mode
        if stat.S_ISDIR(mode):
            raise NotReadable(str(path), "is not a file, but a folder", "name the file in it")
        if not stat.S_ISREG(mode):
            raise NotReadable(str(path), "is not a file (a pipe, a device)", "put the file there")
        with open(number, "rb", closefd=False) as file:
            data = file.read(MAX_BYTES + 1)
    finally:
        os.close(number)
    if len(data) > MAX_BYTES:
        problem = f"is longer than {MAX_BYTES // 1024 // 1024} MiB, as no description is"
        raise NotReadable(str(path), problem, "choose the right file")
    return data


def load_site(text: str) -> Site:
    """Make a `Site` of YAML text.

    The shape is checked here (keys, types); what does not fit together is `check`'s matter.

    Raises:
        DescriptionError: with the path to the mistake (``$.devices.base.signals.speed``),
            what was expected and what was found.

    """
    return site_of_plain(plain_of_text(text))


def plain_of_text(text: str) -> dict[str, object]:
    """Read the plain values of a description in the newest format; see `load_site`.

    Raises:
        DescriptionError: it is not YAML, no mapping, or of another format.

    """
    document = mapping_of_text(text)
    require_current(document.get("talaia"))
    return document


def mapping_of_text(text: str) -> dict[str, object]:
    """Read the plain values of a description, whatever its format.

    Raises:
        DescriptionError: it is not YAML, or no mapping.

    """
    require_short(text)
    return mapping_in(read_document(text))


def require_short(text: str) -> None:
    """Refuse a text that is longer than any description.

    Raises:
        NotReadable: it is.

    """
    if len(text) > MAX_BYTES:
        raise NotReadable("$", f"the description is longer than {MAX_BYTES // 1024 // 1024} MiB")


def mapping_in(document: object) -> dict[str, object]:
    """Give what a text says, where that is a mapping.

    Raises:
        DescriptionError: it is none.

    """
    if isinstance(document, dict):
        return document
    # An empty file, or one of comments.
    if document is None:
        raise DescriptionError("$", "there is no description in it", _BEGIN)
    said = "a list" if isinstance(document, list) else "one word or sentence"
    problem = f"expected a mapping with the keys talaia, site, name and devices, found {said}"
    raise DescriptionError("$", problem, _BEGIN)


def require_own_keys(document: dict[str, object]) -> None:
    """Refuse the file of another program: not one of its keys is a description's.

    Raises:
        DescriptionError: it is one.

    """
    known = {field.encode_name for field in msgspec.structs.fields(Site)}
    keys = [str(key) for key in document]
    if keys and not any(meant_word(key, known, _SURELY_OWN) for key in keys):
        shown = ", ".join(keys[:3]) + ", …" * (len(keys) > 3)
        problem = f"none of its keys is one of a description; found {shown[:100]}"
        raise DescriptionError("$", problem, f"choose the right file, or {_BEGIN}")


def site_of_plain(document: dict[str, object]) -> Site:
    """Make a `Site` of what YAML or JSON says.

    Raises:
        DescriptionError: it does not have the shape of a description; see `load_site`.

    """
    document = with_tags(document)
    try:
        return msgspec.convert(document, Site)
    except (msgspec.ValidationError, RecursionError) as error:
        raise shape_error(str(error), document).error from error


def dump_site(site: Site) -> str:
    """Write a `Site` as YAML text that `load_site` reads back to an equal one."""
    return dump_document(plain_of(site))
