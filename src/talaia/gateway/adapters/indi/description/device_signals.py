"""The signals of one INDI device, from what its driver has defined. Pure.

Standard properties come first, under the field's names and units (`standard_tables`); whatever
else the driver has is shown by its own labels. No property's element is given twice, and a device
has at most `MAX_SIGNALS` of them, however much a driver defines.
"""

from __future__ import annotations

from typing import TYPE_CHECKING

import msgspec

from talaia.gateway.adapters.indi.description.labels import (
    is_describable,
    label_without_unit,
    shown_name,
    unit_in_label,
    word_of,
)
from talaia.gateway.adapters.indi.description.shown_properties import is_property_shown
from talaia.gateway.adapters.indi.description.standard_tables import (
    STANDARD_NUMBERS,
    STANDARD_SWITCHES,
)
from talaia.gateway.adapters.indi.protocol import SwitchRule, VectorKind
from talaia.gateway.adapters.indi.standard_properties import MESSAGE, moving_words
from talaia.model.connection import IndiSource
from talaia.model.site import Signal, SignalType

if TYPE_CHECKING:
    from talaia.gateway.adapters.indi.description.standard_tables import NumberRow
    from talaia.gateway.adapters.indi.protocol import Element
    from talaia.gateway.adapters.indi.state import IndiDevice, StoredVector

__all__ = ["MAX_SIGNALS", "signals_of"]

# The page of a device with more would help nobody; the standard ones are always among them.
MAX_SIGNALS = 80


def signals_of(device: IndiDevice) -> dict[str, Signal]:
    """Give a device's signals by their words: known ones first, then all others."""
    made: dict[str, Signal] = {}
    # Properties that a table has named, and that are not shown a second time.
    known: set[str] = set()
    weather = device.vectors.get("WEATHER_STATUS")
    max_age = _weather_age(device)
    if weather is not None:
        known.add("WEATHER_STATUS")
        made["safety"] = Signal(
            name="Safety",
            source=IndiSource(property="WEATHER_STATUS"),
            type=SignalType.STATE,
            # In the order of Idle, Ok, Busy, Alert.
            states=("unknown", "safe", "warning", "unsafe"),
            max_age=max_age,
        )
    for ways in STANDARD_SWITCHES:
        if ways.property in device.vectors:
            known.add(ways.property)
            made[word_of(ways.id, made)] = Signal(
                name=ways.name,
                source=IndiSource(property=ways.property),
                type=SignalType.STATE,
                states=moving_words(ways.property),
                primary=ways.primary,
            )
    for row in STANDARD_NUMBERS:
        held = device.vectors.get(row.property)
        element = None if held is None else held.elements.get(row.element)
        # Several rows may lead to one signal; the first that the driver has is it.
        if held is None or element is None or row.id in made:
            continue
        known.add(row.property)
        made[row.id] = _standard_signal(device, row, element, max_age)
    for held in device.vectors.values():
        if len(made) >= MAX_SIGNALS:
            break
        # Weather stations have readings of their own beside those in the table.
        shown = held.name == "WEATHER_PARAMETERS" or held.name not in known
        if shown and is_property_shown(held, device):
            _add_elements(made, held, max_age)
    # The driver's newest sentence says what no property does: why it refused.
    made["message"] = Signal(
        name="Message",
        source=IndiSource(property=MESSAGE),
        type=SignalType.TEXT,
        primary=False,
    )
    return made


def _weather_age(device: IndiDevice) -> float:
    """Two and a half of the driver's own periods (s)."""
    period = device.element_value("WEATHER_UPDATE", "PERIOD")
    return 2.5 * period if isinstance(period, float) and 0 < period <= 3600 else 150.0


def _standard_signal(
    device: IndiDevice, row: NumberRow, element: Element, max_age: float
) -> Signal:
    unit = row.unit
    if row.property == "WEATHER_PARAMETERS":
        # The driver's label says what it really measures in, except that rain is by the hour.
        own = unit_in_label(element.label)
        unit = own if own and row.id != "rain" else unit
    source = IndiSource(property=row.property, element=row.element)
    names = _filter_names(device) if row.property == "FILTER_SLOT" else ()
    if names:
        # Slots count from one.
        return Signal(name=row.name, source=source, type=SignalType.STATE, states=("–", *names))
    return Signal(
        name=row.name,
        source=source,
        unit=unit,
        minimum=row.low,
        maximum=row.high,
        decimals=row.decimals,
        max_age=max_age if row.property == "WEATHER_PARAMETERS" else 5.0,
        primary=row.primary,
    )


def _filter_names(device: IndiDevice) -> tuple[str, ...]:
    held = device.vectors.get("FILTER_NAME")
    if held is None:
        return ()
    names = [shown_name(str(element.value)) for element in held.elements.values()][:50]
    # States must differ; two slots may hold the same filter.
    return tuple(
        name if names.count(name) == 1 else f"{name} {at}" for at, name in enumerate(names, 1)
    )


def _add_elements(made: dict[str, Signal], held: StoredVector, max_age: float) -> None:
    title = shown_name(held.label or held.name)
    sources = {
        (signal.source.property, signal.source.element)
        for signal in made.values()
        if isinstance(signal.source, IndiSource)
    }
    # Of such switches one is on, so they are one state; of "any of many" each is its own.
    if held.kind is VectorKind.SWITCH and held.rule is not SwitchRule.ANY:
        # A single one is a button, and has no state.
        if len(held.elements) < 2:
            return
        states = _switch_labels(held)
        made[word_of(held.name, made)] = Signal(
            name=title,
            source=IndiSource(property=held.name),
            type=SignalType.STATE,
            states=states,
            primary=False,
        )
        return
    for element in held.elements.values():
        if len(made) >= MAX_SIGNALS or not is_describable(element.name):
            return
        if (held.name, element.name) in sources:
            continue
        single = len(held.elements) == 1
        label = shown_name(label_without_unit(element.label) or element.name)
        signal = Signal(
            name=(title if single else f"{title}: {label}")[:100],
            source=IndiSource(property=held.name, element=element.name),
            primary=False,
            max_age=max_age if held.name == "WEATHER_PARAMETERS" else 5.0,
        )
        word = word_of(held.name if single else f"{held.name}_{element.name}", made)
        made[word] = _typed_signal(signal, held, element)


def _switch_labels(held: StoredVector) -> tuple[str, ...]:
    labels = [shown_name(element.label or element.name) for element in held.elements.values()]
    unique = tuple(
        label if labels.count(label) == 1 else shown_name(element.name)
        for label, element in zip(labels, held.elements.values(), strict=True)
    )
    # The state's number is the place of the switch that is on; behind all of them: none is.
    return (*unique, "none") if held.rule is SwitchRule.AT_MOST_ONE else unique


def _typed_signal(signal: Signal, held: StoredVector, element: Element) -> Signal:
    match held.kind:
        case VectorKind.TEXT:
            return msgspec.structs.replace(signal, type=SignalType.TEXT)
        case VectorKind.LIGHT:
            return msgspec.structs.replace(
                signal, type=SignalType.STATE, states=("idle", "ok", "busy", "alert")
            )
        case VectorKind.SWITCH:
            return msgspec.structs.replace(signal, type=SignalType.STATE, states=("off", "on"))
        case _:
            return msgspec.structs.replace(signal, unit=unit_in_label(element.label))
