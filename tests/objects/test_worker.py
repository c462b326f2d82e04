"""Detectors in processes of their own: what they see, and what becomes of one that ends."""

from __future__ import annotations

import asyncio
import contextlib
import os
import signal
import subprocess
import sys
from pathlib import Path

import numpy as np
import psutil
import pytest
from patience import PATIENCE_S

from talaia.model.detection import ModelKind, ObjectModel
from talaia.objects import worker as module
from talaia.objects.child import MOST_FILES, MOST_MEMORY
from talaia.objects.errors import DetectorError
from talaia.objects.worker import USUAL, Worker, WorkerTimes

sys.path.insert(0, str(Path(__file__).resolve().parent.parent / "gateway"))
from detector_files import red_detector, require_own, require_runtime

PICTURES = Path(__file__).resolve().parents[2] / "src/talaia/sim/vehicle/pictures"
RED = np.full((48, 64, 3), (255, 0, 0), np.uint8)
GREY = np.full((48, 64, 3), 90, np.uint8)


class Bench:
    """A worker with a red detector, and what it was told."""

    def __init__(  # noqa: D107
        self,
        folder: Path,
        times: WorkerTimes = USUAL,
        *,
        provider: str = "cpu",
        **more: ObjectModel,
    ) -> None:
        require_runtime()
        red_detector(folder / "red.onnx")
        red = ObjectModel(file="red.onnx", kind=ModelKind.YOLO, classes=("red thing",), side=32)
        self.said: list[tuple[str, str]] = []
        self.worker = Worker(
            {"red": red, **more},
            folder,
            lambda model, why: self.said.append((model, why)),
            times,
            provider=provider,
        )

    async def __aenter__(self) -> Bench:
        return self

    async def __aexit__(self, *_: object) -> None:
        await self.worker.close()

    def process(self) -> psutil.Process:
        # Other tests of this process may have children of their own.
        children = psutil.Process().children()
        (found,) = [child for child in children if "talaia.objects.child" in child.cmdline()]
        return found


async def test_person_and_a_cat_are_found_where_they_are(tmp_path: Path) -> None:
    require_own()
    import simplejpeg

    shown = {}
    async with Bench(tmp_path) as bench:
        for name in ("astronaut", "cat"):
            data = (PICTURES / f"{name}.jpg").read_bytes()
            picture = np.full((480, 640, 3), 110, np.uint8)
            pixels = simplejpeg.decode_jpeg(data)
            picture[20 : 20 + pixels.shape[0], 100 : 100 + pixels.shape[1]] = pixels
            shown[name] = await bench.worker.detect_objects("", picture, 0.5)
    person, cat = shown["astronaut"][0], shown["cat"][0]
    assert (person.label, cat.label) == ("person", "cat")
    # The pictures are in the left part of the canvas, from 100 of 640 px on.
    assert 0.15 < person.left < 0.35 < 0.5 < person.right < 0.86
    assert 0.15 < cat.left < cat.right < 0.86
    assert cat.bottom < 0.75 < person.bottom


async def test_detector_of_ones_own_is_shown_pictures_of_any_size(tmp_path: Path) -> None:
    async with Bench(tmp_path) as bench:
        for height, width in ((48, 64), (1, 1), (3000, 2400)):
            picture = np.full((height, width, 3), (255, 0, 0), np.uint8)
            (thing,) = await bench.worker.detect_objects("red", picture, 0.5)
            assert thing.label == "red thing"
            # Beside a narrow picture the square is grey.
            assert thing.left < 0.5 < thing.right
        assert await bench.worker.detect_objects("red", GREY, 0.5) == []
        assert bench.said == []


@pytest.mark.parametrize("provider", ["tensorrt", "npu=/nowhere/libep.so"])
async def test_without_the_device_the_processor_sees_and_it_is_told(
    tmp_path: Path, provider: str, caplog: pytest.LogCaptureFixture
) -> None:
    async with Bench(tmp_path, provider=provider) as bench:
        (thing,) = await bench.worker.detect_objects("red", RED, 0.5)
        assert thing.label == "red thing"
        assert bench.said == []
    (record,) = [record for record in caplog.records if record.name == module.__name__]
    assert record.getMessage().startswith("objects are seen by the processor: ")


async def test_its_process_gives_way_to_all_others(tmp_path: Path) -> None:
    async with Bench(tmp_path) as bench:
        await bench.worker.detect_objects("red", RED, 0.5)
        process = bench.process()
        assert process.nice() == min(19, os.nice(0) + 10)
        assert os.sched_getscheduler(process.pid) == os.SCHED_BATCH
        score = Path(f"/proc/{process.pid}/oom_score_adj").read_text()  # noqa: ASYNC240
        assert score.strip() == "1000"
        # And cannot take what is theirs.
        assert process.rlimit(psutil.RLIMIT_DATA) == (MOST_MEMORY, MOST_MEMORY)
        assert process.rlimit(psutil.RLIMIT_NOFILE) == (MOST_FILES, MOST_FILES)
        assert "talaia.objects.child" in process.cmdline()
    assert not psutil.pid_exists(process.pid)


async def test_killed_process_is_begun_anew_and_both_are_said_once(
    tmp_path: Path,
) -> None:
    async with Bench(tmp_path, WorkerTimes(first_wait=0.05, steady=0.0)) as bench:
        await bench.worker.detect_objects("red", RED, 0.5)
        first = bench.process()
        first.send_signal(signal.SIGSEGV)
        problems = []
        async with asyncio.timeout(PATIENCE_S):
            while not (bench.said and not bench.said[-1][1]):
                try:
                    await bench.worker.detect_objects("red", RED, 0.5)
                except DetectorError as error:
                    problems.append(str(error))
        assert "ended by signal 11" in problems[0]
        assert bench.said == [("red", problems[0]), ("red", "")]
        assert bench.process().pid != first.pid


def test_detector_ends_with_a_process_that_is_killed(tmp_path: Path) -> None:
    require_runtime()
    red_detector(tmp_path / "red.onnx")
    program = """
import asyncio, os, signal, sys
from pathlib import Path
import numpy as np, psutil
from talaia.model.detection import ModelKind, ObjectModel
from talaia.objects.worker import USUAL, Worker, WorkerTimes

async def main():
    red = ObjectModel(file="red.onnx", kind=ModelKind.YOLO, classes=("a",), side=32)
    worker = Worker({"red": red}, Path(sys.argv[1]), print)
    await worker.detect_objects("red", np.zeros((48, 64, 3), np.uint8), 0.5)
    print(psutil.Process().children()[0].pid, flush=True)
    os.kill(os.getpid(), signal.SIGKILL)

asyncio.run(main())
"""
    done = subprocess.run(
        [sys.executable, "-c", program, str(tmp_path)],
        capture_output=True, text=True, check=False, timeout=PATIENCE_S,
    )  # fmt: skip
    assert done.returncode == -signal.SIGKILL, done.stderr
    with contextlib.suppress(psutil.NoSuchProcess):
        psutil.Process(int(done.stdout)).wait(20)


async def test_one_that_hangs_is_ended_and_holds_up_no_other(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    other = ObjectModel(file="red.onnx", kind=ModelKind.YOLO, classes=("other",), side=32)
    async with Bench(tmp_path, other=other) as bench:
        await bench.worker.detect_objects("red", RED, 0.5)
        process = bench.process()
        await bench.worker.detect_objects("other", RED, 0.5)
        monkeypatch.setattr(module, "PATIENCE_S", 2.0)
        process.suspend()
        hung, seen = await asyncio.gather(
            bench.worker.detect_objects("red", RED, 0.5),
            bench.worker.detect_objects("other", RED, 0.5),
            return_exceptions=True,
        )
        assert isinstance(hung, DetectorError)
        assert "ended by signal 9" in str(hung)
        assert [each.label for each in seen] == ["other"]


@pytest.mark.parametrize(
    ("model", "problem"),
    [
        (ObjectModel(file="no.onnx", kind=ModelKind.YOLO, classes=("a",)), "there is no such file"),
        (ObjectModel(file="text.onnx", kind=ModelKind.YOLO, classes=("a",)), "cannot be loaded"),
        (
            ObjectModel(file="red.onnx", kind=ModelKind.YOLO, classes=("a", "b"), side=32),
            "choose another kind or list of classes",
        ),
        (
            ObjectModel(file="red.onnx", kind=ModelKind.YOLO, classes=("a",), side=64),
            "cannot be run",
        ),
    ],
)
async def test_file_that_is_none_is_said_once_with_what_to_do(
    tmp_path: Path, model: ObjectModel, problem: str
) -> None:
    (tmp_path / "text.onnx").write_text("this is no detector")
    async with Bench(tmp_path, bad=model) as bench:
        for _ in range(3):
            with pytest.raises(DetectorError, match=problem):
                await bench.worker.detect_objects("bad", RED, 0.5)
        assert [name for name, _ in bench.said] == ["bad"]
        # The others see.
        assert await bench.worker.detect_objects("red", RED, 0.5)


def test_a_detector_that_prints_where_its_answer_belongs_is_ended_and_named() -> None:
    child = module._Child({})
    words = [sys.executable, "-c", "print('Downloading weights …'); input()"]
    with subprocess.Popen(words, stdin=subprocess.PIPE, stdout=subprocess.PIPE) as process:
        child._process = process
        with pytest.raises(DetectorError, match=r"Downloading weights .* instead of an answer"):
            child._read_answer(process)
        assert process.returncode is not None


async def test_runtime_that_is_missing_is_said_with_what_to_install(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    (tmp_path / "hidden").mkdir()
    (tmp_path / "hidden" / "onnxruntime.py").write_text("raise ImportError('no onnxruntime')")
    async with Bench(tmp_path) as bench:
        found = os.pathsep.join([str(tmp_path / "hidden"), *filter(None, sys.path)])
        monkeypatch.setenv("PYTHONPATH", found)
        with pytest.raises(DetectorError, match=r"install talaia\[objects\]"):
            await bench.worker.detect_objects("red", RED, 0.5)


async def test_detector_that_is_described_otherwise_is_loaded_anew(tmp_path: Path) -> None:
    async with Bench(tmp_path) as bench:
        await bench.worker.detect_objects("red", RED, 0.5)
        first = bench.process()
        red = ObjectModel(file="red.onnx", kind=ModelKind.YOLO, classes=("fire",), side=32)
        bench.worker.redescribe({"red": red})
        (thing,) = await bench.worker.detect_objects("red", RED, 0.5)
        assert thing.label == "fire"
        bench.worker.redescribe({})
        with pytest.raises(DetectorError, match="there is no model 'red'"):
            await bench.worker.detect_objects("red", RED, 0.5)
    assert not psutil.pid_exists(first.pid)
