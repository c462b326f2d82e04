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
