"""A detector that an extension brings, in a description and at the hub."""

from __future__ import annotations

import time
from typing import TYPE_CHECKING

import pytest

from talaia.extensions.installed import installed_extensions
from talaia.hub.anomaly.episode_runner import AnomalyBegan
from talaia.hub.anomaly.guarded import GuardedDetector
from talaia.hub.anomaly.runner import DetectorRunner
from talaia.model.alarms.anomaly import DetectorKind, Watch
from talaia.model.checks.site_checks import check_site
from talaia.model.yaml_text.load import dump_site, load_site

from .broken_packages import DETECTOR, write_package

if TYPE_CHECKING:
    from pathlib import Path

SITE = """
talaia: 1
site: lab
name: Lab
ros2: {}
devices:
  power:
    name: Power
    signals:
      voltage:
        name: Voltage
        unit: V
        source: {topic: /v, type: std_msgs/msg/Float64, field: data}
        anomalies: [{detector: extension, extension: cusum, keys: {slack: 0.25, limit: 5}}]
"""
CUSUM = Watch(detector=DetectorKind.EXTENSION, extension="cusum", keys={"slack": 0.25})


def test_its_keys_are_checked_where_it_is_installed_and_kept_where_it_is_not(
    beside: Path,
) -> None:
    wrong = load_site(SITE.replace("slack: 0.25", "slak: 0.25"))
    assert check_site(wrong) == []
    (finding,) = check_site(wrong, installed_extensions().description_rules())
    assert finding.where == "$.devices.power.signals.voltage.anomalies[0].keys.slak"
    assert "did you mean 'slack'?" in finding.remedy
    (finding,) = check_site(
        load_site(SITE.replace("limit: 5", "limit: soon")),
        installed_extensions().description_rules(),
    )
    assert finding.where.endswith(".keys.limit")
    assert "expected float, got str" in finding.problem
    (finding,) = check_site(
        load_site(SITE.replace("limit: 5", "limit: -5")), installed_extensions().description_rules()
    )
    assert "expected slack from 0, limit above 0" in finding.problem
    right = load_site(SITE)
    assert check_site(right, installed_extensions().description_rules()) == []
    assert load_site(dump_site(right)) == right


@pytest.mark.parametrize(
    ("entry", "problem"),
    [
        ("{detector: extension}", "cannot be a name"),
        ("{detector: extension, extension: limits}", "is a detector of Talaia itself"),
        ("{detector: change, extension: cusum}", "does not know 'extension'"),
        ("{detector: extension, extension: " + "x" * 21 + "}", "at most 20 letters"),
        ("{detector: extension, extension: a}, {detector: extension, extension: a}", "twice"),
    ],
)
def test_a_detector_that_is_named_wrongly_is_found(entry: str, problem: str) -> None:
    begin = SITE.partition("anomalies:")[0]
    found = check_site(load_site(f"{begin}anomalies: [{entry}]\n"))
    assert any(problem in each.problem for each in found), found


def test_a_slow_drift_is_told_with_its_reason_and_survives_a_restart(beside: Path) -> None:
    watched = DetectorRunner("power/voltage", "V", CUSUM)
    assert (watched.word, watched.kind.name) == ("cusum", "slow drift (CUSUM)")
    now = 0
    for step in range(200):
        now += 1_000_000
        assert watched.score_sample(now, 12.0 + 0.1 * (-1) ** step) is None
    again = DetectorRunner("power/voltage", "V", CUSUM, watched.dump_state())
    turns = []
    for _ in range(30):
        now += 1_000_000
        turns.append(again.score_sample(now, 12.15))
    began = [each for each in turns if isinstance(each, AnomalyBegan)]
    assert len(began) == 1
    assert began[0].why == "it has stayed above its mean of 12 V for long"
    assert again.dismiss_peak()


def broken_detector(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, name: str, see: str
) -> DetectorRunner:
    write_package(tmp_path, name, "talaia.detectors", name, DETECTOR.format(see=see))
    monkeypatch.syspath_prepend(str(tmp_path))
    installed_extensions.cache_clear()
    watch = Watch(detector=DetectorKind.EXTENSION, extension=name)
    return DetectorRunner("power/voltage", "V", watch)


@pytest.mark.parametrize(
    ("name", "see", "problem"),
    [
        ("raises", "return 1 / 0", "it fails: ZeroDivisionError: division by zero"),
        ("no_number", "return float('nan')", "its score is no number"),
        ("a_text", "return 'high'", "it fails: ValueError"),
    ],
)
def test_a_detector_that_fails_is_named_and_asked_no_more(
    name: str, see: str, problem: str, tmp_path: Path, monkeypatch: pytest.MonkeyPatch,
    beside: Path,
) -> None:  # fmt: skip
    watched = broken_detector(tmp_path, monkeypatch, name, see)
    other = DetectorRunner("power/voltage", "V", CUSUM)
    for at in range(10):
        assert watched.score_sample(at + 1, 1.0) is None
        other.score_sample(at + 1, 1.0)
    assert isinstance(watched.detector, GuardedDetector)
    assert watched.detector.off
    said = [each.problem for each in installed_extensions().list_broken()]
    assert any(problem in each for each in said)
    assert any("asked no more after 3 failures" in each for each in said)
    assert watched.dump_state()
    assert isinstance(other.detector, GuardedDetector)
    assert not other.detector.off


def test_a_detector_that_is_slow_is_asked_no_more(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, beside: Path
) -> None:
    watched = broken_detector(tmp_path, monkeypatch, "slow_one", "return 0.0")
    assert isinstance(watched.detector, GuardedDetector)
    for _ in range(3):
        watched.detector.record_duration(0.2)
    assert "more than 50 ms" in watched.detector.off
    began = time.perf_counter()
    watched.score_sample(1, 1.0)
    assert time.perf_counter() >= began


def test_a_detector_that_is_not_installed_here_is_named_and_sees_nothing(beside: Path) -> None:
    watch = Watch(detector=DetectorKind.EXTENSION, extension="elsewhere")
    watched = DetectorRunner("power/voltage", "V", watch)
    assert watched.score_sample(1, 1e9) is None
    assert watched.kind.name == "not installed at this hub"
    (broken,) = installed_extensions().list_broken()
    assert broken.name == "elsewhere"
    assert "not installed at this hub" in broken.problem
