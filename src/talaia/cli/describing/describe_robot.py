"""What ``talaia init`` does: describe what is out there, and ask about it."""

from __future__ import annotations

import socket
import sys
from pathlib import Path
from typing import TYPE_CHECKING

from talaia.cli.describing.init_questions import (
    ask_about_devices,
    ask_about_stop,
    ask_for_name,
    names_called,
    stop_lines,
)
from talaia.cli.errors import CliError
from talaia.cli.local_machine import zone_here
from talaia.cli.probe import probe_robot
from talaia.model.checks.site_checks import check_site
from talaia.model.discovery.generate_description import propose_description
from talaia.model.discovery.probe_report import Found, found_from
from talaia.model.discovery.robot_name import name_robot
from talaia.model.discovery.ros_units import word_of
from talaia.model.discovery.rules.missing_units import numbers_without_unit, unit_lines
from talaia.model.discovery.rules.proposal_answers import (
    ProposalAnswers,
    answered_proposal,
    answers_problems,
)
from talaia.model.interlocks.unguarded import unguarded_notice
from talaia.model.yaml_text.write import write_description

if TYPE_CHECKING:
    import argparse

    from talaia.model.discovery.generate_description import DescriptionProposal

__all__ = ["describe_robot"]

# Of a report on standard input; without a limit a wrong pipe would fill the memory.
MAX_BYTES = 64 * 1024 * 1024
# Lines of what is left out; the largest robot of the tests has some 40.
MAX_LEFT_OUT = 1000
# And of those that are told at the end, where nothing else is there.
_MOST_TOLD = 5


def describe_robot(options: argparse.Namespace) -> int:
    """Write the description; 0 when it runs as it is, 1 when something in it must be mended."""
    if options.web and (options.found or options.no_questions):
        raise CliError("--web asks about the robot that runs; leave --found and --no-questions out")
    shown = str(options.output) == "-"
    if not shown and options.output.exists() and not options.force:
        raise CliError(f"{options.output} is there already; choose another with -o, or --force")
    found = _read_report(options.found) if options.found else probe_robot(options)
    robot = name_robot(found, socket.gethostname().split(".", 1)[0])
    # Cut, for people type it in commands and addresses.
    names = (
        options.site or word_of(robot)[:40],
        options.name or robot[:100] or "Robot",
        options.zone or zone_here(),
    )
    made = propose_description(found, *names)
    _refuse_names(made)
    # Before anything is asked about it.
    if not made.site.devices and not found.devices:
        raise CliError(_nothing_found(found))
    if options.web:
        return _ask_in_page(options, found, names, made)
    if not options.no_questions and sys.stdin.isatty() and sys.stderr.isatty():
        if not options.name:
            names = names_called(names, ask_for_name(names[1], input)[:100], options.site)
        without = ask_about_devices(made, input)
        made = propose_description(found, *names, without=without)
        if made.stops:
            stop = ask_about_stop(made, input)
            made = propose_description(found, *names, without=without, answers=stop)
    _write_file(options.output, found, made)
    return 1 if check_site(made.site) else 0


def _nothing_found(found: Found) -> str:
    elsewhere = (
        "; if it runs, it may be in another domain (its ROS_DOMAIN_ID, here --domain N) or network"
        if found.protocol == "ros2"
        else ""
    )
    return (
        f"nothing was found at {found.where}: start the robot, and see what `talaia probe` "
        f"lists{elsewhere}; nothing was written"
    )


def _write_file(output: Path, found: Found, made: DescriptionProposal) -> None:
    # Made in memory first: nothing is written when there is nothing to write.
    text = write_description(made.site, _file_header(found, made))
    shown = str(output) == "-"
    if shown:
        print(text, end="")
    else:
        output.write_text(text)
    _print_summary(output, made, shown=shown)


def _ask_in_page(
    options: argparse.Namespace,
    found: Found,
    names: tuple[str, str, str],
    made: DescriptionProposal,
) -> int:
    """Serve the questions until they are answered; 130 when Ctrl-C ends it, as shells say it."""
    # Not at the top: a gateway's readers are loaded only to show what they read.
    from talaia.cli.init_page.session import ask_in_page

    def finish(answers: ProposalAnswers) -> list[str]:
        called = names_called(names, answers.name, options.site)
        answered = answered_proposal(found, called, answers)
        problems = answers_problems(answered)
        if not problems:
            _write_file(options.output, found, answered)
        return problems

    written = ask_in_page(
        made,
        output=str(options.output),
        domain=found.domain if found.protocol == "ros2" else None,
        finish=finish,
        browse=not options.no_browser,
    )
    return 0 if written else 130


def _refuse_names(made: DescriptionProposal) -> None:
    """Refuse a name of the site that `check` would refuse: it would be in keys and addresses.

    Raises:
        CliError: it does not fit, with what to write.

    """
    options = {"$.site": "--site", "$.name": "--name", "$.zone": "--zone"}
    for finding in check_site(made.site):
        if finding.where in options:
            option = options[finding.where]
            raise CliError(
                f"{option}: {finding.problem}; {finding.remedy}; nothing was written".replace(
                    "; ;", ";"
                )
            )


def _read_report(where: str) -> Found:
    """Read what a probe wrote.

    Raises:
        CliError: it cannot be read.
        NotAProbe: it is something else.

    """
    try:
        data = sys.stdin.buffer.read(MAX_BYTES) if where == "-" else Path(where).read_bytes()
    except OSError as error:
        raise CliError(f"{where} cannot be read: {error.strerror}") from error
    return found_from(data, where)


def _file_header(found: Found, made: DescriptionProposal) -> list[str]:
    lines = [
        f"Made by talaia init from {found.where}. Change what you like: names, units, limits,",
        "what is on the first page (primary). `talaia check` validates it.",
    ]
    if any(device.drive is not None for device in made.site.devices.values()):
        lines += [
            "",
            "Driving is limited to careful speeds: raise max_speed (m/s), max_turn (rad/s),",
            "max_steering (rad) or those of joints to what your robot may do. A base that moves",
            "sideways has max_sideways (m/s).",
        ]
    for choice in made.stops:
        # What is not wanted has no STOP, either.
        device = made.site.devices.get(choice.device)
        if device is not None and device.drive is not None:
            said = stop_lines(choice, device.drive.stop)
            lines += ["", *said] if said else []
    if without := unit_lines(list(numbers_without_unit(made.site))):
        lines += ["", *without]
    if made.left_out:
        # All of it: what is missing here would have been left out in silence.
        lines += ["", "Left out:", *(f"  {reason}" for reason in made.left_out[:MAX_LEFT_OUT])]
        if len(made.left_out) > MAX_LEFT_OUT:
            lines.append(f"  and {len(made.left_out) - MAX_LEFT_OUT} more")
    return lines


def _print_summary(output: Path, made: DescriptionProposal, *, shown: bool) -> None:
    devices = made.site.devices.values()
    counts = (
        f"{len(devices)} devices, {sum(len(device.signals) for device in devices)} signals, "
        f"{sum(len(device.streams) for device in devices)} cameras, "
        f"{sum(len(device.commands) for device in devices)} commands"
    )
    print(f"{'found' if shown else f'{output}:'} {counts}", file=sys.stderr)
    count = len(made.left_out)
    if not devices:
        # All that there is was left out: then the reason is what one has to know.
        for reason in made.left_out[:_MOST_TOLD]:
            print(f"note: {reason}", file=sys.stderr)
    elif count:
        said = "1 item was" if count == 1 else f"{count} items were"
        print(f"{said} left out; the file lists them", file=sys.stderr)
    if without := len(list(numbers_without_unit(made.site))):
        said = "1 number has" if without == 1 else f"{without} numbers have"
        print(f"{said} no unit, for the robot says none; the file lists them", file=sys.stderr)
    if notice := unguarded_notice(made.site):
        print(f"note: {notice}", file=sys.stderr)
    if not shown:
        print(f"next: talaia up {output}", file=sys.stderr)
