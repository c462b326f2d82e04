"""The description of a site: its versions, what differs, and changes that the gateway judges.

Long, because reading, comparing and changing a description ask for the same versions.
"""

from __future__ import annotations

import asyncio
from typing import TYPE_CHECKING, Annotated, Any, cast

from fastapi import APIRouter, Query, Request

from talaia.hub.api.access import address_of, known_live_of, number_of, who_of
from talaia.hub.api.guarded_routes import GuardedRoute
from talaia.hub.api.problems import ApiProblem
from talaia.hub.api.schemas.description_schemas import (
    ChangeAnswer,
    CheckAnswer,
    CheckAsk,
    DescribeAsk,
    DescriptionList,
    DescriptionText,
    DifferenceAnswer,
    DifferenceShape,
    EditAnswer,
    EditAsk,
    FindingShape,
    RestoreAsk,
    VersionShape,
)
from talaia.model.checks.identifiers import Finding
from talaia.model.checks.ros_types.ros_type_checks import ros_type_findings
from talaia.model.checks.site_checks import check_site
from talaia.model.checks.text_checks import Mistake, check_text, place_findings
from talaia.model.errors import DescriptionError
from talaia.model.schema import site_schema
from talaia.model.yaml_text.diff import list_differences, unified_diff
from talaia.model.yaml_text.load import load_site, site_of_plain
from talaia.model.yaml_text.save import save_into_text
from talaia.model.yaml_text.source_tags import plain_of
from talaia.ros_type_library import RosTypeLibrary
from talaia.wire.frames import ChangePhase
from talaia.wire.sealing import MAX_TEXT, digest_of

if TYPE_CHECKING:
    from collections.abc import Iterable

    from talaia.hub.live.gateways.change_requests import ChangeRequestClient
    from talaia.hub.live.sites import LiveSite
    from talaia.hub.store.audit import Audit
    from talaia.hub.store.sites.descriptions import Descriptions
    from talaia.model.site import Site
    from talaia.wire.frames import ChangeState, DescriptionProblem

__all__ = ["DescriptionPages"]

# Versions in one answer.
_PAGE = 50
# Of a difference, and findings of one text: more than anybody reads.
_MOST_LINES = 5_000
_MOST_FINDINGS = 200
# WAITING: no answer came in time, and the gateway may go by it all the same.
_PHASE = {
    ChangePhase.APPLIED: "applied",
    ChangePhase.REFUSED: "refused",
    ChangePhase.WAITING: "unknown",
}
_Number = Annotated[int, Query(ge=0, le=2**53)]


class DescriptionPages:
    """The routes of descriptions."""

    def __init__(self, versions: Descriptions, changes: ChangeRequestClient, audit: Audit) -> None:
        """Answer from ``versions``; hand changes on by ``changes``."""
        self._versions = versions
        self._changes = changes
        self._audit = audit
        # Reading a large description takes a second of a thread: one at a time for all.
        self._reading = asyncio.Lock()

    def make_router(self) -> APIRouter:
        """Give the routes."""
        router = APIRouter(route_class=GuardedRoute)
        at = "/api/sites/{site}/descriptions"
        router.get(at)(self.overview)
        router.post(at)(self.send)
        router.post(at + "/check")(self.check)
        router.post(at + "/edit")(self.edit)
        router.get(at + "/{number}")(self.text)
        router.get(at + "/{number}/difference")(self.difference)
        router.post(at + "/{number}/restore")(self.restore)
        router.get("/api/description-schema")(self.schema)
        return router

    async def overview(
        self, site: str, request: Request, below: _Number = 2**53
    ) -> DescriptionList:
        """List the versions, the newest first, and say whether another can be sent."""
        live = known_live_of(request)
        found = await self._versions.versions_of(site, below, _PAGE + 1)
        # Only on the first page: further down none of them is the current one.
        newest = found[0].number if below == 2**53 and found else 0
        problem = live.gateway.problem
        return DescriptionList(
            zone=live.description.zone,
            online=live.online,
            accepts=live.gateway.accepts,
            editable=live.online
            and bool(live.gateway.source)
            and live.gateway.accepts not in ("", "no"),
            digest=digest_of(live.gateway.source) if live.gateway.source else "",
            versions=[
                VersionShape(**version._asdict(), current=version.number == newest)
                for version in found[:_PAGE]
            ],
            more=len(found) > _PAGE,
            problem=problem.message if problem is not None else "",
            findings=_problem_shapes(problem.problems) if problem is not None else [],
        )

    async def text(self, site: str, number: str) -> DescriptionText:
        """Give a version's text."""
        found = await self._version_text(site, number)
        return DescriptionText(
            number=int(number),
            digest=digest_of(found),
            text=found,
            site=await self._run_reader(_plain_description, found),
        )

    async def difference(self, site: str, number: str, to: _Number) -> DifferenceAnswer:
        """Hold a version against another one."""
        before, after = (
            await self._version_text(site, number),
            await self._version_text(site, str(to)),
        )
        parts, lines = await self._run_reader(_compare_texts, before, after)
        return DifferenceAnswer(
            before=int(number),
            after=to,
            parts=parts,
            lines=lines[:_MOST_LINES],
            long=len(lines) > _MOST_LINES,
        )

    async def check(self, site: str, asked: CheckAsk, request: Request) -> CheckAnswer:
        """Say what does not fit in a text, as ``talaia check`` does."""
        known_live_of(request)
        findings = await self._run_reader(_check_closely, asked.text)
        parts, lines = [], []
        if asked.against:
            before = await self._version_text(site, str(asked.against))
            parts, lines = await self._run_reader(_compare_texts, before, asked.text)
        return CheckAnswer(
            findings=findings,
            site=await self._run_reader(_plain_description, asked.text),
            parts=parts,
            lines=lines[:_MOST_LINES],
        )

    async def edit(self, asked: EditAsk, request: Request) -> EditAnswer:
        """Write a change into a text: comments, order and spelling of the rest survive."""
        known_live_of(request)
        made: EditAnswer = await self._run_reader(_edit_text, asked.text, asked.site)
        return made

    async def send(self, asked: DescribeAsk, request: Request) -> ChangeAnswer:
        """Ask the gateway to go by a text, and give its answer."""
        return await self._send_text(asked.text, asked.base, "edited here", request)

    async def restore(
        self, site: str, number: str, asked: RestoreAsk, request: Request
    ) -> ChangeAnswer:
        """Ask the gateway to go back to a version, and give its answer."""
        text = await self._version_text(site, number)
        return await self._send_text(text, asked.base, f"back to version {int(number)}", request)

    async def schema(self) -> dict[str, Any]:
        """Give the JSON schema of descriptions."""
        return site_schema()

    async def _send_text(self, text: str, base: str, note: str, request: Request) -> ChangeAnswer:
        live, name = known_live_of(request), who_of(request).name
        if len(text.encode()) > MAX_TEXT:
            raise ApiProblem(413, "too_large", "a description has 4 MiB at the most")
        if live.link is None:
            raise ApiProblem(409, "offline", "the gateway is not connected now")
        if not live.gateway.source:
            problem = "this gateway's description is not one YAML file, so it is changed there"
            raise ApiProblem(409, "undescribed", problem)
        # Two who edit at once: the second must see what the first has changed.
        if base != digest_of(live.gateway.source):
            problem = "the description has been changed meanwhile; load it anew"
            raise ApiProblem(409, "changed", problem)
        # The gateway checks for itself; here a mistake is told without the way there and back.
        findings = await self._run_reader(_check_text, text)
        if findings:
            return ChangeAnswer(
                phase="refused",
                message="the description cannot be used as written",
                findings=findings,
            )
        self._append_record(
            request, live, "description change asked", f"{note} {digest_of(text)[:12]}"
        )
        state = await self._changes.request_change(live, text, name, note)
        return await self._change_answer(state, text)

    async def _change_answer(self, state: ChangeState, text: str) -> ChangeAnswer:
        phase: Any = _PHASE[state.phase]
        findings = [
            Finding(problem.where, problem.problem, problem.remedy) for problem in state.problems
        ]
        shapes = await self._run_reader(_place_findings, findings, text) if findings else []
        return ChangeAnswer(phase=phase, message=state.message, findings=shapes)

    async def _version_text(self, site: str, number: str) -> str:
        text = await self._versions.version_text(site, number_of(number, "version"))
        if text is None:
            raise ApiProblem(404, "unknown", "there is no such version")
        return text

    async def _run_reader(self, work: Any, *args: Any) -> Any:  # noqa: ANN401 - gives what ``work`` gives
        async with self._reading:
            return await asyncio.to_thread(work, *args)

    def _append_record(self, request: Request, live: LiveSite, kind: str, message: str) -> None:
        name, address = who_of(request).name, address_of(request)
        self._audit.append_record(kind, who=name, address=address, site=live.name, message=message)


def _check_text(text: str) -> list[FindingShape]:
    return _shapes_of(check_text(text).mistakes)


def _check_closely(text: str) -> list[FindingShape]:
    """Check a text, and note what nothing at the hub knows of units and of types of ROS."""
    report = check_text(text)
    found = list(report.notes)
    if report.site is not None:
        # The gateway has the robot's packages and the last word, so none of it is a mistake here.
        of_types = ros_type_findings(report.site, RosTypeLibrary())
        found += place_findings([*of_types.mistakes, *of_types.notes], text)
    shapes = [shape.model_copy(update={"note": True}) for shape in _shapes_of(found)]
    return [*_shapes_of(report.mistakes), *shapes]


def _place_findings(findings: Iterable[Finding], text: str) -> list[FindingShape]:
    # Where in the text the key stands that each finding is about.
    return _shapes_of(place_findings(findings, text))


def _shapes_of(mistakes: list[Mistake]) -> list[FindingShape]:
    return [FindingShape(**mistake._asdict()) for mistake in mistakes[:_MOST_FINDINGS]]


def _problem_shapes(problems: Iterable[DescriptionProblem]) -> list[FindingShape]:
    return [
        FindingShape(
            where=problem.where,
            line=problem.line,
            column=problem.column,
            problem=problem.problem,
            remedy=problem.remedy,
        )
        for problem in problems
    ]


def _plain_description(text: str) -> dict[str, Any] | None:
    try:
        return _site_to_plain(load_site(text))
    except DescriptionError:
        return None


def _site_to_plain(site: Site) -> dict[str, Any]:
    return cast("dict[str, Any]", plain_of(site))


def _compare_texts(before: str, after: str) -> tuple[list[DifferenceShape], list[str]]:
    lines = unified_diff(before, after)
    try:
        parts = list_differences(load_site(before), load_site(after))
    except DescriptionError:
        # Kept by a version that knew other words: the lines say it all the same.
        parts = []
    return [
        DifferenceShape(kind=part.kind, path=part.path, before=part.before, after=part.after)
        for part in parts
    ], lines


def _edit_text(text: str, plain: dict[str, Any]) -> EditAnswer:
    try:
        site = site_of_plain(plain)
        made = save_into_text(text, site)
    except DescriptionError as error:
        finding = FindingShape(
            where=error.where, problem=error.problem, remedy=error.remedy, line=0, column=0
        )
        return EditAnswer(text="", findings=[finding])
    return EditAnswer(text=made, findings=_place_findings(check_site(site), made))
