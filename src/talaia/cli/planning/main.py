"""What ``talaia plan`` does: plan a night from a file, or play one against its judge.

``drive`` speaks one JSON object a line on standard input and output, and writes nothing else there.
"""

from __future__ import annotations

import sys
from typing import TYPE_CHECKING

import msgspec

from talaia.planner.bound import bound_value
from talaia.planner.drive import DrivenNight
from talaia.planner.errors import NotANight, UnknownRequest
from talaia.planner.night_file import make_problem, read_night
from talaia.planner.outlook import CERTAIN
from talaia.planner.session import PlanningSession
from talaia.planner.why_not import clock_words

if TYPE_CHECKING:
    from pathlib import Path
    from typing import BinaryIO

    from talaia.planner.fairness import FairnessRule

__all__ = ["answer_lines", "print_night"]


def answer_lines(lines: BinaryIO, answers: BinaryIO, fairness: FairnessRule) -> int:
    """Answer each line of a judge, until it ends.

    Raises:
        NotANight: a line is not what the format says; names its number.

    """
    night = DrivenNight(fairness)
    for number, line in enumerate(iter(lines.readline, b""), start=1):
        try:
            answer = night.answer_line(line)
        except NotANight as error:
            problem = f"{error.where}: {error.problem}"
            raise NotANight(f"line {number}", problem, error.remedy) from error
        except UnknownRequest as error:
            raise NotANight(f"line {number}", str(error)) from error
        answers.write(msgspec.json.encode(answer) + b"\n")
        answers.flush()
    return 0


def print_night(path: Path, fairness: FairnessRule) -> int:
    """Print the plan of a night that stays clear, with reasons, the bound and the gap.

    Raises:
        NotANight: the file cannot be read, or is none; names it.

    """
    try:
        night, unknown = read_night(path.read_bytes())
        problem = make_problem(night)
    except OSError as error:
        raise NotANight(str(path), f"cannot be read: {error.strerror}") from error
    except NotANight as error:
        raise NotANight(str(path), f"{error.where}: {error.problem}", error.remedy) from error
    for key, count in sorted(unknown.items()):
        # Beside the plan, not in it: a constraint with a slip in its name would hold nothing back.
        times = "" if count == 1 else f" ({count} times)"
        print(
            f"talaia plan: {path}: {key} is no key of the format{times}; passed over",
            file=sys.stderr,
        )
    if len(problem.table) == 0:
        print("nothing is asked for at the start of this night: there is nothing to plan")
        _print_later(len(night.requests))
        return 0
    session = PlanningSession(problem, outlook=CERTAIN, fairness=fairness)
    session.improve(problem.start)
    plan = session.plan(problem.start)
    for block in plan.blocks:
        start, end = clock_words(block.start)[:5], clock_words(block.end)[:5]
        print(f"{start}-{end}  {block.request}  after {block.overhead:.0f} s  {block.reason}")
    bound = bound_value(problem)
    gap = 100.0 * (1.0 - plan.value / bound) if bound > 0.0 else 0.0
    print(
        f"{len(plan.blocks)} visits worth {plan.value:.0f}; no plan is worth more than "
        f"{bound:.0f}: {gap:.1f} % at the most are missing"
    )
    waiting = len(problem.table) - len(plan.blocks)
    for why in session.why_not(problem.start)[:10]:
        print(f"not now: {why.request}: {why.sentence}")
    print(
        "1 request is not in the plan"
        if waiting == 1
        else f"{waiting} requests are not in the plan"
    )
    _print_later(len(night.requests) - len(problem.table))
    return 0


def _print_later(later: int) -> None:
    if later:
        said = "1 request comes" if later == 1 else f"{later} requests come"
        print(f"{said} later in the night: what is there at its start is planned")
