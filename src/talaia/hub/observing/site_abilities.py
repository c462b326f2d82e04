"""What a site's description says that its camera and mount can do for a request. Pure."""

from __future__ import annotations

from typing import TYPE_CHECKING, NamedTuple

from talaia.model.observing.requests import Guiding, ImageType
from talaia.model.observing.targets import IcrsTarget

if TYPE_CHECKING:
    from collections.abc import Iterable, Iterator

    from talaia.model.night_frames import FrameCommand, NightField, SettingCommand
    from talaia.model.night_section import NightSection
    from talaia.model.observing.requests import (
        Configuration,
        Constraints,
        Request,
        RequestGroup,
    )
    from talaia.model.site import Argument, Site

__all__ = ["SettingRange", "SiteAbilities", "site_abilities", "site_problems"]

_INDOORS = frozenset({ImageType.DARK, ImageType.BIAS})


class SettingRange(NamedTuple):
    """What a number of the camera may be; none: no limit is described."""

    low: float | None
    high: float | None


class SiteAbilities(NamedTuple):
    """What can be asked of a site, for whoever fills in a request.

    Attributes:
        filters: by name; none: there is no wheel, so any name is a note.
        types: kinds of frames that its nights take.
        exposure: of a frame of a target (s).
        binning: none: it cannot be chosen.
        gain: none: it cannot be chosen.
        guides: there is a guider.
        field: how much of the sky a picture shows; none: nobody has described it.
        measures_seeing: its nights know the seeing, so a request may be held to it.
        measures_clouds: likewise of clouds.

    """

    filters: tuple[str, ...] | None
    types: tuple[ImageType, ...]
    exposure: SettingRange
    binning: SettingRange | None
    gain: SettingRange | None
    guides: bool
    field: NightField | None
    measures_seeing: bool
    measures_clouds: bool


def site_abilities(site: Site) -> SiteAbilities | None:
    """Give what its description says can be asked of a site; None: it does not observe."""
    night = site.night
    if night is None:
        return None
    light = night.light
    return SiteAbilities(
        filters=tuple(night.filter.filters) if night.filter is not None else None,
        types=tuple(kind for kind in ImageType if night.frame_for(kind) is not None),
        exposure=_range_of(_arguments(site, light.command, [light.seconds]))
        or SettingRange(None, None),
        binning=_range_of(_taken_by(site, light, light.binning, night.binning)),
        gain=_range_of(_taken_by(site, light, light.gain, night.gain)),
        guides=night.guider is not None,
        field=night.field,
        measures_seeing=_measures_seeing(night),
        measures_clouds=bool(night.clouds),
    )


def _range_of(taken: list[Argument]) -> SettingRange | None:
    """Give what all arguments take that one number is handed to; None: nothing takes it."""
    if not taken:
        return None
    lows = [argument.minimum for argument in taken if argument.minimum is not None]
    highs = [argument.maximum for argument in taken if argument.maximum is not None]
    return SettingRange(max(lows, default=None), min(highs, default=None))


def site_problems(group: RequestGroup, site: Site) -> list[str]:
    """List, in words, what of a group its site cannot do, each once."""
    night = site.night
    if night is None:
        return []
    wanted = [part for request in group.requests for part in request.configurations]
    found = [problem for request in group.requests for problem in _mixture_problems(request)]
    for request in group.requests:
        found += [
            *_target_problems(request),
            *_angle_problems(night, request),
            *_condition_problems(night, request.constraints),
        ]
    found += [
        problem
        for configuration in wanted
        for problem in (
            *_kind_problems(site, night, configuration),
            *_setting_problems(site, night, configuration),
            *_guiding_problems(night, configuration),
        )
    ]
    return list(dict.fromkeys(found))


def _mixture_problems(request: Request) -> Iterator[str]:
    kinds = {part.type for part in request.configurations}
    # Each kind is taken at a time of its own.
    if len(kinds) > 1 and not kinds <= _INDOORS:
        yield (
            "one request has frames of a target (LIGHT), of the twilight (SKY_FLAT) or of a closed"
            " roof (DARK, BIAS), not of several of them"
        )


def _target_problems(request: Request) -> Iterator[str]:
    # Flats are of the sky opposite the Sun, darks and biases of none.
    if request.target is None and any(
        part.type is ImageType.LIGHT for part in request.configurations
    ):
        yield "a LIGHT frame is of a target: name one"


def _condition_problems(night: NightSection, constraints: Constraints) -> Iterator[str]:
    """A limit on what nobody measures would hold nothing back: better said than kept."""
    if constraints.max_seeing is not None and not _measures_seeing(night):
        yield "this site does not measure the seeing: leave its limit open"
    if constraints.max_clouds is not None and not night.clouds:
        yield "this site does not measure clouds: leave their limit open"


def _measures_seeing(night: NightSection) -> bool:
    # By an instrument of its own, or by the stars of each field that is centred.
    return bool(night.seeing) or night.centring is not None


def _angle_problems(night: NightSection, request: Request) -> Iterator[str]:
    """What the camera of a site without a rotator does not show is said before it is handed in."""
    target = request.target
    if not isinstance(target, IcrsTarget) or target.position_angle is None:
        return
    if night.rotator is not None:
        return
    if night.field is None:
        yield "this site does not say how its camera stands: leave the position angle open"
    elif not night.field.shows_angle(target.position_angle):
        yield (
            f"the camera stands at a position angle of {night.field.position_angle:g}° and cannot"
            f" be turned to {target.position_angle:g}°"
        )


def _kind_problems(site: Site, night: NightSection, configuration: Configuration) -> Iterator[str]:
    frame = night.frame_for(configuration.type)
    if frame is None:
        yield f"the nights of this site take no {configuration.type} frames for requests"
    elif configuration.type is not ImageType.SKY_FLAT:
        # A flat's is where it begins: its level decides.
        taken = _arguments(site, frame.command, [frame.seconds])
        if taken:
            yield from _number_problems("an exposure of", configuration.exposure, taken)


def _guiding_problems(night: NightSection, configuration: Configuration) -> Iterator[str]:
    if configuration.guiding is Guiding.ON and night.guider is None:
        yield "this site has no guider: guiding may be OFF or OPTIONAL"


def _setting_problems(
    site: Site, night: NightSection, configuration: Configuration
) -> Iterator[str]:
    frame = night.frame_for(configuration.type) or night.light
    # A binning of 1 is what a camera does that cannot choose.
    if configuration.binning != 1:
        taken = _taken_by(site, frame, frame.binning, night.binning)
        yield from _number_problems("binning", float(configuration.binning), taken)
    if configuration.gain is not None:
        taken = _taken_by(site, frame, frame.gain, night.gain)
        yield from _number_problems("gain", configuration.gain, taken)


def _taken_by(
    site: Site, frame: FrameCommand, argument: str, rule: SettingCommand | None
) -> list[Argument]:
    """Give the arguments that take a setting: the frame's own, or those of a command for it."""
    if argument:
        return _arguments(site, frame.command, [argument])
    return [] if rule is None else _arguments(site, rule.command, rule.arguments)


def _arguments(site: Site, address: str, names: Iterable[str]) -> list[Argument]:
    device, _, command = address.partition("/")
    known = site.devices[device].commands[command].arguments
    return [known[name] for name in names if name in known]


def _number_problems(words: str, value: float, taken: list[Argument]) -> Iterator[str]:
    if not taken:
        yield f"this site cannot choose {words}"
    for argument in taken:
        low, high = argument.minimum, argument.maximum
        if (low is not None and value < low) or (high is not None and value > high):
            least = "" if low is None else f" from {low:g}"
            most = "" if high is None else f" to {high:g}"
            yield f"{words} {value:g} cannot be: it goes{least}{most}"
            return
