"""Read and check a description of so many signals; prints what it took as JSON."""

from __future__ import annotations

import json
import sys
import time

from talaia.model.checks.site_checks import check_site
from talaia.model.yaml_text.load import load_site

A_DEVICE = 50


def text_of(signals: int) -> str:
    """Write a description as people write it: a line for each key."""
    rows = ["talaia: 1", "site: big", "name: Large plant", "ros2: {}", "devices:"]
    for at in range(signals):
        if at % A_DEVICE == 0:
            rows += [f"  device{at}:", f"    name: Device {at}", "    signals:"]
        rows += [
            f"      signal{at}:",
            f"        name: Signal {at}",
            "        unit: m/s",
            "        minimum: -1.5",
            "        maximum: 1.5",
            f"        source: {{topic: /plant/value{at}, type: std_msgs/msg/Float64, field: data}}",
        ]
    return "\n".join(rows) + "\n"


def main() -> None:
    """Take the time of the process, and that on the wall."""
    signals = int(sys.argv[1])
    text = text_of(signals)
    began, used = time.perf_counter(), time.process_time()
    site = load_site(text)
    findings = check_site(site)
    took = {"wall_s": time.perf_counter() - began, "cpu_s": time.process_time() - used}
    assert not findings
    assert len(site.channels()) == signals
    print(json.dumps(took))


if __name__ == "__main__":
    main()
