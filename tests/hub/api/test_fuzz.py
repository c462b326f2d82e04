"""The API under generated requests, as each kind of person: no failure, no undeclared answer.

The description is the one of the reference. The requests are the same in each run.
"""

from __future__ import annotations

import asyncio
import contextlib
import itertools
from collections import defaultdict
from typing import TYPE_CHECKING

import pytest
import requests
import schemathesis
from hypothesis import HealthCheck, Phase, given, settings
from hypothesis.errors import Unsatisfiable
from many_examples import examples
from patience import PATIENCE_S
from schemathesis.core.failures import Failure, FailureGroup
from schemathesis.specs.openapi.checks import (
    content_type_conformance,
    response_schema_conformance,
    status_code_conformance,
)

from talaia.hub.api.openapi import needs_in_words
from talaia.hub.policy import ROUTES

from ..everyone.routes import ABOUT_PEOPLE, RECIPES
from ..everyone.world import NOW
from ..kept_description import kept_description

if TYPE_CHECKING:
    from collections.abc import Mapping, Sequence

pytestmark = [
    # The hub, in the other thread, draws random numbers while a request is made up in this one.
    pytest.mark.filterwarnings("ignore:Do not use the .random. module inside strategies"),
]
ACTORS = ("nobody", "guest", "operator", "admin")
# How far a request is about what there is.
TURNS = ("answerable", "known", "made up")
# Requests of each route that do not fit its description; to make one up takes longest of all.
WRONG = examples(1, many=20)
# A third of what is asked else; what is refused takes the hub as long as what is not.
EVERYONE_ASKS_ALL = bool(examples(0, many=1))
# No 5xx is declared anywhere: the first of these finds each.
CHECKS = [
    status_code_conformance,
    content_type_conformance,
    response_schema_conformance,
]
SETTINGS = settings(
    # One for each of the turns of `Fuzz`, of what is right.
    max_examples=examples(3, many=20),
    derandomize=True,
    database=None,
    deadline=None,
    phases=(Phase.generate,),
    suppress_health_check=list(HealthCheck),
)


class Fuzz:
    """Asks a running hub what the description makes up, and keeps what is not as described."""

    def __init__(self, world, how: settings) -> None:
        """Ask ``world``'s hub, as often as ``how`` says."""
        self._settings = how
        self.wrong: set[str] = set()
        self.seen: defaultdict[tuple[str, str], set[int]] = defaultdict(set)
        self._world = world
        # Of the route that is tried: objects that there are, and questions that have an answer.
        self._known: Mapping[str, object] = {}
        self._query: Mapping[str, object] = {}
        self._cookies: dict[str, dict[str, str]] = {}
        self._turn = itertools.cycle(TURNS)
        self._one = itertools.cycle(ACTORS)
        self._is_right = True
        self._session = requests.Session()
        self._session.trust_env = False

    def __enter__(self) -> Fuzz:
        return self

    def __exit__(self, *_exc: object) -> None:
        self._session.close()

    async def run(self, description: dict) -> None:
        """Go through every operation, with what fits its description and with what does not."""
        for found in schemathesis.openapi.from_dict(description).get_all_operations():
            operation = found.ok()
            if not self._cookies:
                self._world.forget_clients()
                self._cookies = {actor: await self._world.cookies(actor) for actor in ACTORS}
            recipe = RECIPES[operation.method.upper(), operation.path]
            ask = await recipe.make(self._world, await self._world.admin(), recipe.objects[0])
            self._known, self._query = {**ask.params, **ask.query}, ask.query
            await asyncio.to_thread(self._try, operation)
            if operation.path.startswith(ABOUT_PEOPLE):
                # It may have ended anyone's session.
                self._cookies = {}

    def _try(self, operation: schemathesis.APIOperation) -> None:
        for mode in schemathesis.GenerationMode:
            # However few there are, one has an answer.
            self._turn = itertools.cycle(TURNS)
            self._is_right = mode is schemathesis.GenerationMode.POSITIVE
            ask = given(operation.as_strategy(generation_mode=mode))(self._ask)
            how = self._settings if self._is_right else settings(self._settings, max_examples=WRONG)
            # Without parameters and without a body nothing can be wrong in a request.
            with contextlib.suppress(Unsatisfiable):
                how(ask)()

    def _ask(self, case: schemathesis.Case) -> None:
        turn = next(self._turn)
        if turn != "made up":
            # Two of three requests are about something that exists.
            for where in (case.path_parameters, case.query):
                where.update({name: self._known[name] for name in where if name in self._known})
        if turn == "answerable" and self._query:
            case.query.clear()
            case.query.update(self._query)
        for actor in self._actors_of(turn):
            answer = case.call(
                self._world.hub.origin,
                session=self._session,
                headers={"Origin": self._world.hub.origin},
                cookies=self._cookies[actor],
                timeout=PATIENCE_S,
            )
            route = (case.method.upper(), case.operation.path)
            self.seen[route].add(answer.status_code)
            try:
                case.validate_response(answer, checks=CHECKS)
            except (Failure, FailureGroup) as failure:
                said = str(failure).partition("Reproduce with")[0]
                self.wrong.add(f"{actor}, {route}, {answer.status_code}: {said[:1000]}")

    def _actors_of(self, turn: str) -> Sequence[str]:
        """Give who asks: everyone what has an answer; what has none, one after the other."""
        if EVERYONE_ASKS_ALL or (turn == "answerable" and self._is_right):
            return ACTORS
        return (next(self._one),)


async def fuzz(world, description: dict, how: settings = SETTINGS) -> Fuzz:
    await world.gateways["agv"].samples(("base/open", NOW, 1.0))
    asking = Fuzz(world, how)
    with asking:
        await asking.run(description)
    return asking


async def test_every_answer_is_declared_and_none_is_a_failure(unhurried, world) -> None:
    description = kept_description(world.hub.hub.app)
    asking = await fuzz(world, description)
    assert sorted(asking.wrong) == []
    # Each route that wants no words of its own was really reached: it did what it was asked.
    unreached = {
        (method, path)
        for (method, path), statuses in asking.seen.items()
        if min(statuses) >= 300 and method in {"GET", "DELETE"}
    }
    # Its person has no second factor.
    # Metrics and Socket.IO are shut until an admin opens them, whoever asks.
    # These sites do not observe by themselves; see `test_observing`.
    # And no test asks Google; see `test_maps`.
    # The file of its film has no pictures; see `test_film_pictures`.
    # No detector is at work there, so nothing is known of one; see `test_cause_pages`.
    assert unreached <= {
        ("DELETE", "/api/sites/{site}/causes/known/{known}"),
        ("GET", "/api/maps/sources/{source}/session"),
        ("DELETE", "/api/people/{person}/factor"),
        ("GET", "/metrics"),
        ("POST", "/clients/prometheus/read"),
        ("GET", "/socket.io/"),
        ("GET", "/api/sites/{site}/night/forecast"),
        ("GET", "/api/sites/{site}/night/week"),
        ("GET", "/api/sites/{site}/films/{recording}/picture"),
    }


async def test_answer_that_is_not_declared_is_found(unhurried, world) -> None:
    description = kept_description(world.hub.hub.app)
    site = description["paths"]["/api/sites/{site}"]["get"]
    description["paths"] = {"/api/sites/{site}": {"get": site}}
    del site["responses"]["404"]
    # Of one route alone, so that a site that is not there is among what is made up.
    assert (await fuzz(world, description, settings(SETTINGS, max_examples=5))).wrong


def test_description_holds_every_route_with_its_right(hub_parts) -> None:
    described = {
        (method.upper(), path): operation
        for path, methods in kept_description(hub_parts.app)["paths"].items()
        for method, operation in methods.items()
    }
    assert set(described) == {route for route in ROUTES if ":path}" not in route[1]}
    for route, operation in described.items():
        assert operation["x-talaia-need"] == ROUTES[route].name.lower()
        assert f"Needs: {needs_in_words(*route)}" in operation["description"]


def test_no_body_takes_a_key_that_is_not_described(hub_parts) -> None:
    description = kept_description(hub_parts.app)
    bodies = [
        operation["requestBody"]["content"]
        for methods in description["paths"].values()
        for operation in methods.values()
        if "requestBody" in operation
    ]
    assert bodies
    for body in bodies:
        # No form and no file is taken anywhere.
        assert set(body) == {"application/json"}
        name = body["application/json"]["schema"]["$ref"].rpartition("/")[2]
        assert description["components"]["schemas"][name]["additionalProperties"] is False
