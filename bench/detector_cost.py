"""What the object detector adds to the bare run of its model, of a core.

    PYTHONPATH=src python bench/detector_cost.py [--pictures 60] [--model FILE]

By turns on pictures of 640×480 with things on them, in one process with one thread: the model's run
alone on an input that is ready, and all of it, from the picture to the boxes. Time of the thread;
the middle of each. A limit that is missed makes the exit code 1.
"""

from __future__ import annotations

import argparse
import sys
import time
from pathlib import Path

import numpy as np
import simplejpeg

import talaia.sim.vehicle as pictures_of
from talaia.model.coco_classes import COCO
from talaia.objects.detector import NANODET, Detector
from talaia.objects.network import open_network
from talaia.objects.providers import CPU, parse_provider
from talaia.objects.worker import OWN_FILE

# Beyond the bare run.
MOST = 0.10
HEIGHT, WIDTH = 480, 640


def _pictures() -> list[np.ndarray]:
    """Cut what ships with the simulator to the size of a camera's picture."""
    found = []
    for path in sorted((Path(pictures_of.__file__).parent / "pictures").glob("*.jpg")):
        rgb = simplejpeg.decode_jpeg(path.read_bytes(), colorspace="RGB")
        rows = np.arange(HEIGHT) * rgb.shape[0] // HEIGHT
        columns = np.arange(WIDTH) * rgb.shape[1] // WIDTH
        found.append(np.ascontiguousarray(rgb[rows][:, columns]))
    return found


def main() -> int:
    """Print the share; 1 when it is above the limit."""
    parser = argparse.ArgumentParser(description=__doc__.split("\n", 1)[0])
    parser.add_argument("--pictures", type=int, default=60)
    parser.add_argument("--model", default=str(OWN_FILE))
    asked = parser.parse_args()
    run, shown = open_network(asked.model, parse_provider(CPU)), []
    bare: list[float] = []
    whole: list[float] = []

    def timed(given: np.ndarray) -> list[np.ndarray]:
        shown.append(given)
        return list(run(given))

    detector, pictures, boxes = Detector(NANODET, COCO, timed), _pictures(), 0
    for at in range(asked.pictures + 5):
        began = time.thread_time()
        boxes += len(detector.detect_objects(pictures[at % len(pictures)], 0.3))
        between = time.thread_time()
        run(shown.pop())
        whole.append(between - began)
        bare.append(time.thread_time() - between)
    # The first ones make memory ready.
    ours, model = float(np.median(whole[5:])), float(np.median(bare[5:]))
    print(
        f"the model alone {1000 * model:.1f} ms, all of it {1000 * ours:.1f} ms a picture:"
        f" {ours / model - 1:+.1%} (limit {MOST:+.0%}); {boxes} boxes on {asked.pictures} pictures"
    )
    return int(ours / model - 1 > MOST)


if __name__ == "__main__":
    sys.exit(main())
