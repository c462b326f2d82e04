"""Each feature brings the routes that its lines of the policy table name."""

from __future__ import annotations

from fastapi.routing import APIRoute, APIWebSocketRoute

from talaia.hub.policy import CLIENT_SOCKETS, ROUTES_OF, SOCKETS


def routes_of(feature):
    return {
        (method, route.path)
        for router in feature.routers
        for route in router.routes
        if isinstance(route, APIRoute)
        for method in route.methods - {"HEAD"}
    }


def test_every_feature_brings_the_routes_of_its_lines_and_no_others(hub_parts) -> None:
    for feature in hub_parts.features:
        assert routes_of(feature) == set(feature.rules), feature.name


def test_every_line_of_the_policy_is_of_a_feature(hub_parts) -> None:
    assert set(ROUTES_OF) <= {feature.name for feature in hub_parts.features}


def test_every_socket_is_brought_by_one_feature(hub_parts) -> None:
    found = [
        route.path
        for feature in hub_parts.features
        for router in feature.sockets
        for route in router.routes
        if isinstance(route, APIWebSocketRoute)
    ]
    assert sorted(found) == sorted([*SOCKETS, *CLIENT_SOCKETS])


def test_no_two_features_and_no_two_tasks_have_one_name(hub_parts) -> None:
    names = [feature.name for feature in hub_parts.features]
    assert len(names) == len(set(names))
    for feature in hub_parts.features:
        tasks = [task.name for task in feature.tasks]
        assert len(tasks) == len(set(tasks)), feature.name
