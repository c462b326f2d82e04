"""The command line of the vehicle."""

from __future__ import annotations

import signal

import pytest

from talaia.sim.vehicle.run import main, make_parser

pytestmark = pytest.mark.pure


def test_it_does_not_wander_unless_asked() -> None:
    assert make_parser().parse_args([]).wander is False
    assert make_parser().parse_args(["--wander"]).wander is True


def test_a_domain_that_is_not_safe_is_refused_in_words(capsys: pytest.CaptureFixture[str]) -> None:
    before = signal.getsignal(signal.SIGTERM)
    assert main(["--domain", "0"]) == 1
    assert "from 1 to 101" in capsys.readouterr().err
    assert signal.getsignal(signal.SIGTERM) is before


@pytest.mark.parametrize("rate", ["0", "100", "fast"])
def test_a_camera_rate_that_makes_no_sense_is_refused(rate: str) -> None:
    with pytest.raises(SystemExit) as refused:
        main(["--camera-rate", rate])
    assert refused.value.code == 2
