"""A site whose signals and commands are parameters of the robot's nodes."""

from __future__ import annotations

SITE = """
talaia: 1
site: agv
name: Agv
ros2: {}
devices:
  base:
    name: Base
    visibility: public
    signals:
      gain: {name: Gain, source: {parameter: /peer/gain}}
      steps: {name: Steps, source: {parameter: /peer/motor.steps}}
      lamp: {name: Lamp, type: state, states: ["false", "true"], source: {parameter: /peer/lamp}}
      mode: {name: Mode, type: text, source: {parameter: /peer/mode}}
      offsets: {name: Offsets, type: text, source: {parameter: /peer/offsets}}
      shown: {name: Shown, visibility: public, source: {parameter: /peer/shown}}
    commands:
      gain:
        name: Gain
        kind: parameter
        target: /peer
        arguments: {value: {type: number, field: gain, maximum: 10}}
      steps:
        name: Steps
        kind: parameter
        target: /peer
        arguments: {value: {type: integer, field: motor.steps}}
      lamp_on: {name: Lamp, kind: parameter, target: /peer, fixed: {lamp: true}}
      offsets:
        name: Offsets
        kind: parameter
        target: /peer
        arguments: {value: {type: numbers, field: offsets}}
      both:
        name: Both
        kind: parameter
        target: /peer
        fixed: {mode: fast, gain: 2.0}
  power:
    name: Power
    visibility: view
    signals: {}
    commands:
      cut:
        name: Cut
        kind: parameter
        target: /fuse
        arguments: {value: {type: boolean, field: cut}}
"""
VALUES = {"gain": 1.5, "steps": 7.0, "lamp": 1.0, "mode": "slow", "offsets": "[1.0, 2.5]"}
# As the robot's parameters are.
KNOWN = {
    "gain": 1.5,
    "motor.steps": 7,
    "lamp": True,
    "mode": "slow",
    "offsets": [1.0, 2.5],
}
NAMES = {
    "guest": {"shown"},
    "driver": {*KNOWN, "shown"},
    "admin": {*KNOWN, "shown"},
}
