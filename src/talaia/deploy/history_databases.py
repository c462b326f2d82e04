"""Databases of their own for histories, beside the one of accounts: names, URLs and secrets."""

from __future__ import annotations

import datetime as dt
from typing import TYPE_CHECKING

from talaia.deploy.several_hubs import HISTORY_FILE, SECRET_FOLDER, history_names

if TYPE_CHECKING:
    from collections.abc import Callable, Mapping

__all__ = ["history_secret_names", "make_history_secrets"]

_AUTHORITY = "history_ca.pem"
_ABOUT = """\
# Made by `talaia generate`: which databases have histories. A new site's is where `default` says;
# `talaia history move SITE --to NAME` moves one while the hubs run.
"""
_ABOUT_SHARDS = """\
# Made by `talaia generate`: which databases have histories. Each of `shards` has a lead of its own
# for the sites whose history is there; a new site's is where the fewest are. All hubs have the same
# file: to change `shards`, end them all first. `talaia history move SITE --to NAME` takes a site to
# another shard while the hubs run.
"""


def history_secret_names(count: int) -> list[str]:
    """Name the files in ``secrets/`` that are made together."""
    if not count:
        return []
    parts = ("password", "cert.pem", "key.pem")
    own = [f"{name}_{part}" for name in history_names(count) for part in parts]
    return [HISTORY_FILE, f"kubernetes_{HISTORY_FILE}", _AUTHORITY, *own]


def make_history_secrets(
    count: int, random: Callable[[], str], *, shards: bool = False
) -> dict[str, str]:
    """Make them: texts by name. In Kubernetes they are on other machines, so there with TLS.

    ``shards``: each of them has a lead of its own, and new sites are spread over them.
    """
    from talaia.deploy.internal_tls import make_server_pairs

    names = history_names(count)
    passwords = {name: random() for name in names}
    authority, pairs = make_server_pairs(names, dt.datetime.now(dt.UTC))
    checked = f"?sslmode=verify-full&sslrootcert={SECRET_FOLDER}/{_AUTHORITY}"
    return {
        HISTORY_FILE: _servers_text(passwords, "", shards=shards),
        f"kubernetes_{HISTORY_FILE}": _servers_text(passwords, checked, shards=shards),
        _AUTHORITY: authority,
        **{f"{name}_password": password for name, password in passwords.items()},
        **{f"{name}_cert.pem": pair.certificate for name, pair in pairs.items()},
        **{f"{name}_key.pem": pair.key for name, pair in pairs.items()},
    }


def _servers_text(passwords: Mapping[str, str], more: str, *, shards: bool) -> str:
    # Letters and digits need no escape in a URL, and a URL none in YAML's double quotes.
    lines = [
        f'  {name}: "postgresql://talaia:{password}@{name}/talaia{more}"\n'
        for name, password in passwords.items()
    ]
    names = f"[{', '.join(passwords)}]"
    divided = f"default: {names}\nshards: {names}\n"
    rest = divided if shards else f"default: {next(iter(passwords))}\n"
    return f"{_ABOUT_SHARDS if shards else _ABOUT}servers:\n{''.join(lines)}{rest}"
