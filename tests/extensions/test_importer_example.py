"""The importer example: `talaia import` reads its files, and names what is broken."""

from __future__ import annotations

import os
import subprocess
import sys
from typing import TYPE_CHECKING

from .broken_packages import write_package

if TYPE_CHECKING:
    from pathlib import Path

SITE = """
talaia: 1
site: mast
name: Mast
devices:
  weather:
    name: Weather
    connection: none
    signals:
      temperature: {name: T, unit: °C, source: {run: x}}
      pressure: {name: P, unit: hPa, source: {run: x}}
      wind: {name: W, unit: m/s, source: {run: x}}
connections:
  none: {kind: process}
"""
SENTENCE = "WIMDA,29.9,I,1.0133,B,12.3,C,,C,61.0,,5.1,C,210.0,T,209.0,M,6.2,N,3.2,M"


def line(time: str, sentence: str = SENTENCE, *, wrong: bool = False) -> str:
    total = 0
    for letter in sentence:
        total ^= ord(letter)
    return f"{time} ${sentence}*{total ^ wrong:02X}\n"


def imported(folder: Path, tmp_path: Path, text: str, *words: str) -> tuple[int, str]:
    (tmp_path / "site.yaml").write_text(SITE)
    (tmp_path / "log.nmea").write_text(text)
    done = subprocess.run(
        [
            sys.executable, "-m", "talaia", "import", "--dry-run", "--site",
            str(tmp_path / "site.yaml"), *words, str(tmp_path / "log.nmea"),
        ],
        env={**os.environ, "PYTHONPATH": str(folder)},
        capture_output=True, text=True, check=False,
    )  # fmt: skip
    return done.returncode, done.stdout + done.stderr


def test_a_weather_log_is_read_by_names_and_damaged_sentences_are_left_out(
    target: Path, tmp_path: Path
) -> None:
    text = "".join(
        line(f"2026-03-01T20:15:{second:02}Z", wrong=second == 7) for second in range(10)
    )
    code, said = imported(target, tmp_path, text, "--column", "wind_speed=weather/wind")
    assert code == 0, said
    assert "log.nmea (NMEA weather log)" in said
    for address in ("weather/temperature", "weather/pressure", "weather/wind"):
        assert f"{address:<19}             9 samples  2026-03-01 20:15:00Z" in said
    assert "not read: humidity (no channel has this name" in said
    assert "note: 1 sentences have a wrong checksum and were left out" in said


def test_a_mistake_in_the_file_is_told_with_its_line(target: Path, tmp_path: Path) -> None:
    text = line("2026-03-01T20:15:00Z") + line("2026-03-01T20:15:01")
    code, said = imported(target, tmp_path, text)
    assert code == 2
    assert "log.nmea, line 2: '2026-03-01T20:15:01' names no zone; end it with Z" in said
    assert "nothing was imported" in said


def test_an_importer_that_fails_is_named_and_another_reads_the_file(
    target: Path, tmp_path: Path
) -> None:
    code = """
from talaia.extend.importer import ImporterExtension
def recognizes(path, begin):
    raise RuntimeError("oh")
extension = ImporterExtension(api=1, summary="t", title="T", recognizes=recognizes, read=list)
"""
    write_package(tmp_path, "first", "talaia.importers", "first", code)
    folder = f"{tmp_path}{os.pathsep}{target}"
    done, said = imported(folder, tmp_path, line("2026-03-01T20:15:00Z"))  # type: ignore[arg-type]
    assert done == 0
    assert "the extension 'first' (talaia.importers) of x-first 1.0 is broken: it fails at" in said
    assert "NMEA weather log" in said
