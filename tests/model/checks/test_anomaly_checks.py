"""What is watched for anomalies is read and checked with the description."""

import pytest

from talaia.hub.anomaly.kinds import KINDS
from talaia.model.alarms.anomaly import DetectorKind
from talaia.model.checks.site_checks import check_site
from talaia.model.yaml_text.load import load_site

HEAD = """
talaia: 1
site: agv
name: AGV
ros2: {}
devices:
  power:
    name: Battery
    signals:
      voltage:
        name: Voltage
        unit: V
        source: {topic: /battery, type: sensor_msgs/msg/BatteryState, field: voltage}
"""


def findings(text: str) -> list[tuple[str, str]]:
    return [(each.where, each.problem) for each in check_site(load_site(HEAD + text))]


def test_a_signal_is_watched_by_the_detectors_of_its_list():
    site = load_site(
        HEAD + "        anomalies: [{detector: together}, {detector: limits, maximum: 15}]"
    )
    watches = site.devices["power"].signals["voltage"].anomalies
    assert [each.detector for each in watches] == [DetectorKind.TOGETHER, DetectorKind.LIMITS]
    assert watches[1].maximum == 15
    assert check_site(site) == []


def test_nothing_is_watched_by_default():
    assert load_site(HEAD).devices["power"].signals["voltage"].anomalies == ()


@pytest.mark.parametrize(
    ("watch", "where", "problem"),
    [
        ("{detector: limits}", "", "limits without a limit"),
        ("{detector: limits, minimum: 5, maximum: 3}", ".minimum", "5 is not below"),
        ("{detector: change, k: 3}", ".k", "'change' does not know 'k'"),
        ("{detector: iqr, k: 0}", ".k", "more than 0"),
        ("{detector: still, after: -1}", ".after", "0 or more"),
        ("{detector: change, bar: 2}", ".bar", "0 to 1"),
        ("{detector: change, rest: 0}", ".rest", "1 to 1000000"),
        ("{detector: rate}, {detector: rate}", "", "stands here twice"),
    ],
)
def test_what_does_not_fit_is_said_with_its_place(watch, where, problem):
    ((at, said),) = findings(f"        anomalies: [{watch}]")
    assert at.startswith("$.devices.power.signals.voltage.anomalies[")
    assert where in at
    assert problem in said


def test_a_text_is_not_watched():
    text = HEAD.replace("unit: V", "type: text") + "        anomalies: [{detector: change}]"
    said = [each.problem for each in check_site(load_site(text))]
    assert said == ["only numbers are watched"]


def test_every_detector_of_the_description_is_one_of_the_hubs():
    own = set(DetectorKind) - {DetectorKind.EXTENSION}
    assert {str(each) for each in own} == set(KINDS)


CURRENT = """
      current:
        name: Current
        unit: A
        source: {topic: /battery, type: sensor_msgs/msg/BatteryState, field: current}
      mode:
        name: Mode
        type: state
        states: [docked, driving]
        source: {topic: /mode, type: std_msgs/msg/UInt8, field: data}
"""


def in_group(keys: str) -> list[tuple[str, str]]:
    return findings(CURRENT + f"anomaly_groups:\n  power: {{{keys}}}\n")


def test_signals_are_judged_together_where_a_description_says_so():
    assert in_group("signals: [power/voltage, power/current], state: power/mode") == []
    assert in_group("device: power, modes: 4, name: All of the battery") == []


@pytest.mark.parametrize(
    ("keys", "where", "problem"),
    [
        ("", "", "either signals or a device"),
        ("device: power, signals: [power/voltage, power/current]", "", "either signals or"),
        ("device: pover", ".device", "unknown device 'pover'"),
        ("signals: [power/voltage, power/curent]", ".signals[1]", "unknown number 'power/curent'"),
        ("signals: [power/voltage, power/mode]", ".signals[1]", "unknown number 'power/mode'"),
        ("signals: [power/voltage, power/voltage]", ".signals[1]", "stands here twice"),
        ("signals: [power/voltage]", "", "expected 2 to 64 numbers, found 1"),
        ("device: power, state: power/current", ".state", "unknown state 'power/current'"),
        ("device: power, state: power/mode, modes: 2", ".modes", "not both"),
        ("device: power, modes: 17", ".modes", "expected 1 to 16"),
        ("device: power, step: 0.1", ".step", "expected 1 to 3600 s"),
        ("device: power, learn: 59", ".learn", "expected 60 to 30000 steps"),
        ("device: power, bar: 0", ".bar", "more than 0, at most 1"),
    ],
)
def test_what_does_not_fit_in_a_group_is_said_with_its_place(keys, where, problem):
    ((at, said),) = in_group(keys)
    assert at == f"$.anomaly_groups.power{where}"
    assert problem in said


def test_all_groups_together_keep_a_bounded_number_of_values_while_they_learn():
    group = "{device: power, learn: 30000, modes: 16}"
    rows = "\n".join(f"  group{at}: {group}" for at in range(5))
    ((at, said),) = findings(CURRENT + f"anomaly_groups:\n{rows}\n")
    assert at == "$.anomaly_groups"
    assert "4800000 numbers while they learn" in said


def test_an_alarm_may_be_about_a_group_and_no_other_kind_may():
    group = CURRENT + "anomaly_groups: {all: {device: power}}\nalarms:\n  unusual: {name: U, "
    assert findings(group + "kind: anomaly, signal: /all}") == []
    ((where, _),) = findings(group + "kind: stale, signal: /all}")
    assert where == "$.alarms.unusual.signal"


@pytest.mark.parametrize(
    ("alarm", "key", "problem"),
    [
        ("device: powr", "device", "unknown device 'powr'"),
        ("device: power", "device", "no detector of anomalies looks at any signal of power"),
        ("device: power, signal: power/voltage", "signal", "not both"),
    ],
)
def test_an_alarm_about_a_device_needs_a_device_at_which_a_detector_looks(alarm, key, problem):
    wrong = "alarms:\n  odd: {name: O, kind: anomaly, " + alarm + "}\n"
    found = dict(findings(wrong))
    assert problem in found[f"$.alarms.odd.{key}"]
    right = "services: {anomaly_detection: true}\n" + wrong
    assert (findings(right) == []) is (alarm == "device: power")


def test_false_alarms_that_are_borne_are_none_or_a_number_that_can_be_counted():
    assert check_site(load_site(HEAD + "services: {false_alarms_a_week: 0.5}\n")) == []
    for asked in ("0.01", "-1", "1000"):
        ((at, said),) = findings(f"services: {{false_alarms_a_week: {asked}}}\n")
        assert at == "$.services.false_alarms_a_week"
        assert said.startswith("expected 0, or 0.05 to 50 a week")
