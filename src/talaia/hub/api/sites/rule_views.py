"""A site's rules, roofs and place as a person may see them. Pure."""

from __future__ import annotations

from typing import TYPE_CHECKING

from talaia.hub.api.schemas.observatory_schemas import (
    ConditionShape,
    EnclosurePartShape,
    EnclosureShape,
    LimitShape,
    PlaceShape,
    PointingShape,
    RuleShape,
    SightingShape,
    SlewShape,
)
from talaia.hub.auth.permissions import Right, sees_device, sees_signal
from talaia.model.interlocks.capabilities import capabilities_of

if TYPE_CHECKING:
    from collections.abc import Iterable

    from talaia.hub.auth.permissions import Grants
    from talaia.model.interlocks.enclosure import Enclosure, EnclosurePart, Pointing, Sighting
    from talaia.model.interlocks.interlock import Condition
    from talaia.model.site import Site

__all__ = ["describe_enclosures", "describe_place", "describe_pointing", "describe_rules"]


def describe_place(site: Site, grants: Grants) -> PlaceShape | None:
    """Say where a site is, to those who may view something of it beyond what is public."""
    viewed = grants.devices(Right.VIEW, site.site)
    # None is the whole site; an empty set is nothing but what is public.
    if site.place is None or (viewed is not None and not viewed):
        return None
    return PlaceShape(
        latitude=site.place.latitude,
        longitude=site.place.longitude,
        elevation=site.place.elevation,
    )


def describe_pointing(pointing: Pointing) -> PointingShape:
    """Say where a telescope may not point, and by which commands it is pointed."""
    return PointingShape(
        commands=[
            SlewShape(command=name, ra=command.ra, dec=command.dec, alt=command.alt, az=command.az)
            for name, command in pointing.commands.items()
        ],
        horizon=pointing.horizon,
        sun=pointing.sun,
    )


def describe_rules(site: Site, grants: Grants) -> list[RuleShape]:
    """Say when each interlock is unsafe, by the signals that the person sees."""
    made = []
    for name, rule in site.interlocks.items():
        # Whole or not at all: the limits of one signal would be wrong without the others.
        seen = [
            condition for condition in rule.when if _sees_all(site, grants, condition.signals())
        ]
        targets = [command for command in rule.refuse if _sees_target(site, grants, command)]
        if not seen and not targets:
            continue
        made.append(
            RuleShape(
                id=name,
                name=rule.name,
                conditions=[_condition_schema(address) for address in seen],
                hidden=len(rule.when) - len(seen),
                targets=targets,
                # The longest: only then is it certain that the rule lets go (s).
                dwell=max([rule.dwell, *(condition.dwell or 0.0 for condition in rule.when)]),
            )
        )
    return made


def describe_enclosures(site: Site, grants: Grants) -> list[EnclosureShape]:
    """Say by which sensors each roof is closed, to those who see all of them."""
    return [
        EnclosureShape(
            id=name,
            name=roof.name,
            closed=[_sighting_schema(sensor) for sensor in roof.closed],
            moving=[_sighting_schema(sensor) for sensor in roof.moving],
            close=roof.close.command,
            stop=roof.stop,
            unsafe=list(roof.unsafe),
            position=roof.position,
            segments=[_part_schema(key, segment) for key, segment in roof.segments.items()],
            flap=None if roof.flap is None else _part_schema("flap", roof.flap),
            can=capabilities_of(site, roof),
        )
        for name, roof in site.enclosures.items()
        if _sees_all(site, grants, _roof_signals(roof))
    ]


def _roof_signals(roof: Enclosure) -> list[str]:
    """Name all signals that say how a roof stands."""
    found = [sensor.signal for sensor in (*roof.closed, *roof.moving)]
    for part in roof.parts().values():
        found += [sensor.signal for sensor in part.closed]
        found += [part.position] if part.position else []
    return [*found, *([roof.position] if roof.position else [])]


def _part_schema(key: str, part: EnclosurePart) -> EnclosurePartShape:
    closed = [_sighting_schema(sensor) for sensor in part.closed]
    return EnclosurePartShape(id=key, name=part.name, closed=closed, position=part.position)


def _sighting_schema(sighting: Sighting) -> SightingShape:
    return SightingShape(
        signal=sighting.signal,
        states=list(sighting.is_one_of),
        above=sighting.above,
        below=sighting.below,
    )


def _sees_all(site: Site, grants: Grants, signals: Iterable[str]) -> bool:
    places = (signal.partition("/") for signal in signals)
    return all(sees_signal(grants, site, device, signal) for device, _, signal in places)


def _sees_target(site: Site, grants: Grants, target: str) -> bool:
    return sees_device(grants, site, target.partition("/")[0])


def _condition_schema(condition: Condition) -> ConditionShape:
    alone = condition.signal or condition.sun is not None
    # Where a robot is has no limits to compare: its gateway says it in words.
    limits = [one for one in condition.all_of or ((condition,) if alone else ()) if not one.zone]
    return ConditionShape(
        limits=[_limit_schema(limit) for limit in limits],
        lasting=condition.lasting,
        link_lost=condition.link_lost,
        sun=condition.sun or "",
    )


def _limit_schema(condition: Condition) -> LimitShape:
    return LimitShape(
        signal=condition.signal,
        minus=condition.minus,
        humidity=condition.humidity,
        above=condition.above,
        until_below=condition.until_below,
        below=condition.below,
        until_above=condition.until_above,
        states=list(condition.is_one_of),
        safe_states=list(condition.is_not),
    )
