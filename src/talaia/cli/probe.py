"""``talaia probe``: what is out there, for people to read or as JSON for `talaia init`."""

from __future__ import annotations

import argparse
import sys
from typing import TYPE_CHECKING

import msgspec

from talaia.cli.errors import CliError, PartMissing

if TYPE_CHECKING:
    from collections.abc import Sequence

    from talaia.model.found import Found, TopicFound

__all__ = ["look", "main"]

MAX_SECONDS = 600.0


def main(argv: Sequence[str]) -> int:
    """Look and print; 0 when something was found, 1 when the graph is empty."""
    parser = argparse.ArgumentParser(
        "talaia probe",
        description="List what a live ROS 2 graph offers: topics with fields and rates, services, "
        "actions. It only listens.",
    )
    add_options(parser)
    parser.add_argument("--json", action="store_true", help="print JSON, as talaia init reads it")
    options = parser.parse_args(argv)
    found = look(options.seconds, options.domain)
    if options.json:
        print(msgspec.json.format(msgspec.json.encode(found), indent=1).decode())
    else:
        print(_told(found))
    return 0 if found.topics or found.services else 1


def add_options(parser: argparse.ArgumentParser) -> None:
    """Add what looking needs to know."""
    parser.add_argument(
        "--seconds", type=_seconds, default=5.0, help="how long to listen (default: 5)"
    )
    parser.add_argument("--domain", type=int, help="ROS domain (default: ROS_DOMAIN_ID, or 0)")


def _seconds(text: str) -> float:
    value = float(text)
    if not 0.5 <= value <= MAX_SECONDS:
        raise argparse.ArgumentTypeError(f"expected 0.5 to {MAX_SECONDS:g} seconds, found {text}")
    return value


def look(seconds: float, domain: int | None) -> Found:
    """Look at the graph of this machine.

    Raises:
        PartMissing: there is no ROS 2 here.
        CliError: the domain is not one.
        AdapterLost: the graph cannot be joined.

    """
    if domain is not None and not 0 <= domain <= 232:
        raise CliError(f"--domain: expected a ROS domain id from 0 to 232, found {domain}")
    try:
        from talaia.gateway.adapters.ros2_probe import look as look_at_ros2
    except ImportError as error:
        raise PartMissing("talaia probe", error.name or "rclpy", "ros2") from error
    print(f"listening for {seconds:g} s …", file=sys.stderr, flush=True)
    return look_at_ros2(domain, seconds)


def _told(found: Found) -> str:
    lines = [f"{found.where}, after {found.seconds:g} s"]
    lines += ["", "topics that are published"]
    lines += [_row(each) for each in found.topics if each.publishers] or ["  none"]
    heard = [each for each in found.topics if not each.publishers]
    if heard:
        lines += ["", "topics that somebody only listens to"]
        lines += [f"  {each.topic:<36} {each.type}" for each in heard]
    for title, rows in (
        ("services", [(each.service, each.type, each.problem) for each in found.services]),
        ("actions", [(each.action, each.type, each.problem) for each in found.actions]),
    ):
        if rows:
            lines += ["", title]
            lines += [
                f"  {name:<36} {kind}" + (f"   ({problem})" if problem else "")
                for name, kind, problem in rows
            ]
    if not found.topics and not found.services:
        lines += [
            "",
            "Nothing was heard. Is the robot running, in the same ROS domain",
            f"({found.domain}), on the same network, with the same RMW_IMPLEMENTATION?",
        ]
    return "\n".join(lines)


def _row(topic: TopicFound) -> str:
    what = topic.problem or (
        f"{len(topic.names)} sensors by name"
        if topic.names
        else f"{len(topic.fields)} field{'s' if len(topic.fields) != 1 else ''}"
    )
    return f"  {topic.topic:<36} {topic.type:<36} {topic.rate:>7.1f} Hz   {what}"
