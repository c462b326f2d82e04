"""Units of systemd for a gateway on a robot's own computer, and for a hub without containers."""

from __future__ import annotations

import re
from typing import TYPE_CHECKING

if TYPE_CHECKING:
    from collections.abc import Iterable

__all__ = ["gateway_unit", "hub_unit", "quoted_argument"]

# Without a sign of life for so long the service is ended and started again (s). The gateway's is
# longer than an enclosure's `watchdog_after`: first the roof closes, then the gateway restarts.
GATEWAY_WATCHDOG_S = 20
HUB_WATCHDOG_S = 60
# What systemd's own manual calls safe without quotes (systemd.service, COMMAND LINES).
# `\Z`: before `$` a line end could stand.
_PLAIN = re.compile(r"[A-Za-z0-9_./:=@,+-]+\Z")
# No right but to run: the gateway needs the network, its own folder and nothing else. No keyword
# here shuts devices: a gateway may have cameras and serial lines (ProtectClock= would, too).
_HARDENED = """\
DynamicUser=no
NoNewPrivileges=yes
CapabilityBoundingSet=
AmbientCapabilities=
ProtectSystem=strict
ProtectHome=yes
PrivateTmp={private_tmp}
ProtectKernelTunables=yes
ProtectKernelModules=yes
ProtectKernelLogs=yes
ProtectControlGroups=yes
ProtectHostname=yes
RestrictSUIDSGID=yes
RestrictNamespaces=yes
RestrictAddressFamilies=AF_UNIX AF_INET AF_INET6 AF_NETLINK
LockPersonality=yes
SystemCallArchitectures=native
SystemCallFilter=@system-service
SystemCallErrorNumber=EPERM
MemoryMax={memory}
TasksMax={tasks}
UMask=0077"""
# What there is room for before a fault of ours takes the machine with it: many times of what is
# used. A larger hub gets more by a drop-in (`systemctl edit`).
_HUB_MEMORY, _GATEWAY_MEMORY = "4G", "2G"
# Threads and processes; a node of ROS has 14, each camera and each extension some.
_MOST_TASKS = 1024
# The hub has no devices of its own.
_NO_DEVICES = "PrivateDevices=yes\nProtectClock=yes\n"


def quoted_argument(text: str) -> str:
    """Write one argument of a command line, so that systemd reads it back.

    Variables ($) are doubled; else as `_quoted_value`.
    """
    # Doubled also within quotes: systemd expands variables there as well.
    return _quoted_value(text.replace("$", "$$"))


def _quoted_value(text: str) -> str:
    """Write one word of any other setting: there "$" has no special meaning.

    Specifiers (%) are doubled; what is not plain stands in double quotes with C escapes. A line
    end cannot end the line.
    """
    # Doubled also within quotes: systemd expands specifiers there as well.
    safe = text.replace("%", "%%")
    if _PLAIN.match(safe):
        return safe
    escaped = safe.replace("\\", "\\\\").replace('"', '\\"')
    return '"' + "".join(_escaped_letter(letter) for letter in escaped) + '"'


def _escaped_letter(letter: str) -> str:
    if letter.isprintable():
        return letter
    # A lone surrogate has no UTF-8; it becomes a question mark.
    return "".join(f"\\x{byte:02x}" for byte in letter.encode("utf-8", "replace"))


def gateway_unit(site: str, program: str, setup: str = "") -> str:
    """Write the unit of a site's gateway.

    Args:
        site: the site's short name.
        program: absolute path of the ``talaia`` program.
        setup: absolute path of the ROS installation's ``setup.bash``; empty where ROS comes from
            wheels or is not used.

    """
    words = [
        program,
        "gateway",
        f"/etc/talaia/{site}/site.yaml",
        "--key-file",
        f"/etc/talaia/{site}/gateway.key",
        "--data",
        f"/var/lib/talaia-gateway-{site}",
    ]
    # The program itself where no ROS has to be read first: no shell, then.
    if setup:
        # bash gets the words as arguments of its own, so nothing in them is read as shell.
        words = ["/bin/bash", "-c", '. "$0" && exec "$@"', setup, *words]
    return _unit_text(
        f"Talaia gateway of {site}",
        words,
        state=f"talaia-gateway-{site}",
        # Fast DDS talks through shared memory and /tmp to robots' nodes outside the unit.
        private_tmp="no",
        watchdog_s=GATEWAY_WATCHDOG_S,
        memory=_GATEWAY_MEMORY,
        # The process that closes the roof outlives a gateway that was killed; the gateway's other
        # processes end by themselves when it does.
        kill="KillMode=process\n",
    )


def hub_unit(program: str, port: int, hosts: Iterable[str], database_url_file: str = "") -> str:
    """Write the unit of a hub.

    Args:
        program: absolute path of the ``talaia`` program.
        port: TCP port of the dashboard.
        hosts: names under which it is reached, beside the machine's own.
        database_url_file: file that holds the database's URL; empty for SQLite.

    """
    words = [program, "hub", "--data", "/var/lib/talaia-hub", "--host", "0.0.0.0"]  # noqa: S104 - a server
    words += ["--port", str(port)]
    for host in hosts:
        words += ["--allow-host", host]
    # Quoted whole: systemd.syntax(7) lets quotes stand only around a whole item.
    variable = _quoted_value(f"TALAIA_DATABASE_URL_FILE={database_url_file}")
    return _unit_text(
        "Talaia hub",
        words,
        state="talaia-hub",
        private_tmp="yes",
        more=_NO_DEVICES + (f"Environment={variable}\n" if database_url_file else ""),
        watchdog_s=HUB_WATCHDOG_S,
        memory=_HUB_MEMORY,
    )


def _unit_text(
    what: str,
    words: Iterable[str],
    *,
    state: str,
    private_tmp: str,
    more: str = "",
    watchdog_s: int,
    memory: str,
    kill: str = "",
) -> str:
    # Quoted one by one: a name with a blank stays one argument.
    line = " ".join(quoted_argument(word) for word in words)
    # A description is no command line: quotes round it would be shown. StartLimitIntervalSec=0:
    # it is started again however often it fails, for nobody may be there to do it.
    return f"""\
[Unit]
Description={_quoted_value(what).strip('"')}
Wants=network-online.target
After=network-online.target time-sync.target
StartLimitIntervalSec=0

[Service]
Type=notify
NotifyAccess=main
WatchdogSec={watchdog_s}
{kill}User=talaia
Group=talaia
StateDirectory={_quoted_value(state)}
StateDirectoryMode=0700
{more}ExecStart={line}
Restart=always
RestartSec=2
TimeoutStopSec=10
{_HARDENED.format(private_tmp=private_tmp, memory=memory, tasks=_MOST_TASKS)}

[Install]
WantedBy=multi-user.target
"""
