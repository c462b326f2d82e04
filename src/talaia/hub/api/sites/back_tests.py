"""Back-tests: what a detector would have said of stored history."""

from __future__ import annotations

from typing import TYPE_CHECKING

import msgspec
from fastapi import APIRouter, Request

from talaia.hub.anomaly.groups.group_runner import GroupRunner
from talaia.hub.anomaly.kinds import KINDS
from talaia.hub.anomaly.runner import DetectorRunner
from talaia.hub.api.access import live_of, who_of
from talaia.hub.api.guarded_routes import GuardedRoute
from talaia.hub.api.problems import ApiProblem
from talaia.hub.api.schemas.anomaly_schemas import (
    BackTestAsk,
    BackTestShape,
    PastAnomalyShape,
)
from talaia.hub.api.sites.anomaly_views import check_past_window, share_shapes
from talaia.hub.auth.permissions import sees_signal
from talaia.hub.live.detection.back_test import (
    MOST_RUNNING,
    GroupTrial,
    SignalTrial,
    TooManyTests,
)
from talaia.model.alarms.anomaly import DetectorKind, Watch
from talaia.model.alarms.signal_groups import GROUP_DETECTOR, group_named
from talaia.model.checks.anomaly_checks import anomaly_findings, group_findings

if TYPE_CHECKING:
    from talaia.clock import Clock
    from talaia.hub.live.detection.back_test import BackTest, BackTests, PastTrial
    from talaia.model.site import Site

__all__ = ["BackTestPages"]

_LONGEST_US = 31 * 86_400_000_000
_BUSY_S = 5
# Silence is nothing that rows show.
_TRIED = [name for name in KINDS if name != DetectorKind.MISSING]


class BackTestPages:
    """The routes of back-tests."""

    def __init__(self, tests: BackTests, clock: Clock) -> None:
        """Answer from ``tests``."""
        self._tests, self._clock = tests, clock

    def make_router(self) -> APIRouter:
        """Give the routes."""
        router = APIRouter(route_class=GuardedRoute)
        at = "/api/sites/{site}/anomalies/tests"
        router.post(at, status_code=201)(self.begin)
        router.get(at + "/{test}")(self.show)
        router.delete(at + "/{test}", status_code=204)(self.cancel)
        return router

    async def begin(self, site: str, asked: BackTestAsk, request: Request) -> BackTestShape:
        """Begin to try a detector on stored history; `show` says how far it is."""
        live = live_of(request)
        self._check_window(asked)
        device, _, name = asked.address.partition("/")
        if not sees_signal(who_of(request).grants, live.description, device, name):
            raise ApiProblem(404, "unknown", f"there is no signal {asked.address!r}")
        trial = _trial_of(live.description, asked)
        try:
            test = self._tests.begin_test(site, trial, asked.from_us, asked.to_us)
        except TooManyTests as error:
            raise ApiProblem(
                429, "busy", f"{MOST_RUNNING} tests compute already; wait for one", _BUSY_S
            ) from error
        return _test_schema(test)

    async def show(self, site: str, test: str, request: Request) -> BackTestShape:
        """Say how far a test is, and what it has found up to now."""
        return _test_schema(self._find_test(site, test, request))

    async def cancel(self, site: str, test: str, request: Request) -> None:
        """End a test; what it found stays to be seen."""
        self._tests.cancel_test(self._find_test(site, test, request))

    def _find_test(self, site: str, key: str, request: Request) -> BackTest:
        found = self._tests.find_test(site, key)
        if found is not None:
            device, _, name = found.trial.runner.address.partition("/")
            if sees_signal(who_of(request).grants, live_of(request).description, device, name):
                return found
        raise ApiProblem(404, "unknown", "there is no such test; a hub forgets them at its end")

    def _check_window(self, asked: BackTestAsk) -> None:
        check_past_window(asked.from_us, asked.to_us, self._clock)
        if asked.to_us - asked.from_us > _LONGEST_US:
            raise ApiProblem(422, "invalid", "expected at most 31 days, choose a shorter window")


def _trial_of(site: Site, asked: BackTestAsk) -> PastTrial:
    """Make what is tried; 422 where it does not fit."""
    if asked.address.startswith("/"):
        return _group_trial(site, asked)
    signal = site.signal(asked.address)
    if signal is None or signal.type != "number":
        raise ApiProblem(422, "invalid", f"{asked.address!r} is no number; only these are judged")
    if asked.detector not in _TRIED:
        raise ApiProblem(
            422, "invalid", f"expected one of {', '.join(_TRIED)}, found {asked.detector!r}"
        )
    watch = Watch(
        detector=DetectorKind(asked.detector),
        bar=asked.bar,
        minimum=asked.minimum,
        maximum=asked.maximum,
    )
    for finding in anomaly_findings(asked.address, (watch,), number=True):
        raise ApiProblem(422, "invalid", f"{finding.where}: {finding.problem}")
    return SignalTrial(DetectorRunner(asked.address, signal.unit, watch))


def _group_trial(site: Site, asked: BackTestAsk) -> GroupTrial:
    if asked.detector != GROUP_DETECTOR:
        raise ApiProblem(422, "invalid", f"expected 'group' for a group, found {asked.detector!r}")
    found = group_named(site, asked.address[1:])
    if found is None:
        raise ApiProblem(404, "unknown", "no such group of signals is at work")
    if found.is_single:
        raise ApiProblem(
            422,
            "invalid",
            f"{found.name} has one number, which is judged against others under a budget alone:"
            " try a detector of that signal",
        )
    group = msgspec.structs.replace(
        found.group, bar=asked.bar or found.group.bar, learn=asked.learn or found.group.learn
    )
    # As `check` would judge it in a description.
    alone = msgspec.structs.replace(site, anomaly_groups={found.key: group})
    for finding in group_findings(alone):
        raise ApiProblem(422, "invalid", f"{finding.where}: {finding.problem}")
    return GroupTrial(GroupRunner(found._replace(group=group)))


def _test_schema(test: BackTest) -> BackTestShape:
    runner = test.trial.runner
    return BackTestShape(
        key=test.key,
        address=runner.address,
        detector=runner.word,
        bar=runner.episodes.bar,
        from_us=test.from_us,
        to_us=test.to_us,
        state=test.state.value,
        problem=test.problem,
        progress=test.progress,
        rows=test.rows,
        cpu_s=test.cpu_s,
        count=test.count,
        anomalies=[
            PastAnomalyShape(
                from_us=found.from_us,
                to_us=found.to_us,
                score=found.score,
                why=found.why,
                shares=share_shapes(runner, found.shares),
            )
            for found in test.anomalies
        ],
        scores=test.scores,
        learning=test.learning,
    )
