"""A small observatory for tests of what is served to others."""

from __future__ import annotations

OBSERVATORY = """
talaia: 1
site: agv
name: Roof
connections: {indi: {kind: indi, discover: false}}
devices:
  dome:
    name: Dome
    kind: dome
    indi: Dome
    signals:
      shutter:
        name: Shutter
        type: state
        role: dome.shutter
        states: [shut, open, opening, closing, jammed]
        meanings: [closed, open, opening, closing, error]
        source: {property: DOME_SHUTTER}
      azimuth:
        name: Azimuth
        unit: °
        role: dome.azimuth
        source: {property: ABS_DOME_POSITION, element: DOME_ABSOLUTE_POSITION}
    commands:
      open:
        {name: Open, kind: indi, role: dome.open, target: DOME_SHUTTER, fixed: {SHUTTER_OPEN: true}}
      close:
        name: Close
        kind: indi
        role: dome.close
        target: DOME_SHUTTER
        fixed: {SHUTTER_CLOSE: true}
      turn:
        name: Turn
        kind: indi
        role: dome.goto
        target: ABS_DOME_POSITION
        arguments:
          azimuth: {type: number, field: DOME_ABSOLUTE_POSITION, unit: °, minimum: 0, maximum: 360}
  weather:
    name: Weather
    kind: weather
    indi: Weather
    signals:
      wind:
        name: Wind
        unit: km/h
        role: weather.wind
        source: {property: WEATHER_PARAMETERS, element: WEATHER_WIND_SPEED}
      temperature:
        name: Temperature
        unit: °C
        role: weather.temperature
        source: {property: WEATHER_PARAMETERS, element: WEATHER_TEMPERATURE}
      status:
        name: Status
        type: state
        role: weather.safety
        states: [fine, doubtful, bad]
        meanings: [safe, warning, unsafe]
        source: {property: WEATHER_STATUS}
interlocks:
  rain:
    name: Rain
    when: [{signal: weather/status, is: [bad]}]
    refuse: [dome/open]
"""
