"""What a release is made with: pinned actions, a list of what is inside, and its changes."""

from __future__ import annotations

import re
import sys
from pathlib import Path

import pytest
import yaml

ROOT = Path(__file__).resolve().parents[2]
sys.path.insert(0, str(ROOT / "tools"))

from changes_of import changes_of  # noqa: E402
from write_sbom import write_sbom  # noqa: E402

pytestmark = pytest.mark.pure
WORKFLOWS = sorted((ROOT / ".github/workflows").glob("*.yml"))
DIGEST = "ab" * 32
LOCK = f"""\
Alpha.Beta==1.2 ; sys_platform != 'win32' \\
    --hash=sha256:{DIGEST} \\
    --hash=sha256:{DIGEST}
gamma==3 \\
    --hash=sha256:{DIGEST}
"""


@pytest.mark.parametrize("file", WORKFLOWS, ids=lambda file: file.name)
def test_foreign_actions_stand_by_commit_with_their_version(file: Path) -> None:
    used = re.findall(r"uses: (.*)", file.read_text())
    assert used
    for action in used:
        assert re.fullmatch(r"[\w.-]+/[\w.-]+@[0-9a-f]{40} # v\d+\.\d+\.\d+", action), action


@pytest.mark.parametrize("file", WORKFLOWS, ids=lambda file: file.name)
def test_a_workflow_may_only_read_but_where_a_job_says_more_and_every_job_ends(file: Path) -> None:
    workflow = yaml.safe_load(file.read_text())
    assert workflow["permissions"] == {"contents": "read"}
    for name, job in workflow["jobs"].items():
        assert job["timeout-minutes"] <= 90, name


@pytest.mark.parametrize("file", WORKFLOWS, ids=lambda file: file.name)
def test_what_a_workflow_runs_of_ours_is_there(file: Path) -> None:
    for name in re.findall(r"(?:tools|requirements)/[\w.]+", file.read_text()):
        assert (ROOT / name).exists(), name


def test_only_who_publishes_may_write() -> None:
    jobs = yaml.safe_load((ROOT / ".github/workflows/release.yml").read_text())["jobs"]
    writing = {
        name: sorted(right for right, how in job.get("permissions", {}).items() if how == "write")
        for name, job in jobs.items()
    }
    assert writing == {
        "build": ["attestations", "id-token"],
        "try": [],
        "images": ["attestations", "id-token", "packages"],
        "publish": ["id-token"],
        # A branch of its own: pages that were read before they were merged.
        "documentation": ["contents"],
        "announce": ["contents"],
    }
    # What is published was tried, and somebody said yes.
    assert set(jobs["publish"]["needs"]) == {"try", "images"}
    assert jobs["publish"]["environment"] == "package-index"


def test_the_list_of_parts_has_each_package_with_its_hashes() -> None:
    parts = write_sbom(LOCK)["components"]
    assert [part["purl"] for part in parts] == ["pkg:pypi/alpha.beta@1.2", "pkg:pypi/gamma@3"]
    assert [len(part["externalReferences"]) for part in parts] == [2, 1]
    assert write_sbom(LOCK) == write_sbom(LOCK)


@pytest.mark.parametrize("lock", ["", "alpha==1\n"])
def test_a_file_that_is_no_lock_is_refused(lock: str) -> None:
    with pytest.raises(ValueError, match="lock"):
        write_sbom(lock)


def test_a_release_has_its_own_part_of_the_changelog() -> None:
    text = "# C\n\n## Unreleased\n\n- new\n\n## 1.2.0 (2026-11-26)\n\n- old\n- older\n\n## 1.1.0\n"
    assert changes_of(text, "1.2.0") == "- old\n- older\n"
    with pytest.raises(LookupError, match=r"1\.3\.0"):
        changes_of(text, "1.3.0")
    with pytest.raises(LookupError, match=r"1\.1\.0"):
        changes_of(text, "1.1.0")


def test_the_workflow_asks_before_it_builds() -> None:
    steps = yaml.safe_load((ROOT / ".github/workflows/release.yml").read_text())["jobs"]["build"][
        "steps"
    ]
    said = [step.get("run", "") for step in steps]
    (asks,) = (at for at, run in enumerate(said) if "check_release.py" in run)
    (builds,) = (at for at, run in enumerate(said) if "-m build" in run)
    assert asks < builds
    assert steps[asks]["env"] == {"TAG": "${{ github.ref_name }}"}
    # A version is of its tag, so whatever builds has to have it.
    assert steps[0]["uses"].startswith("actions/checkout@")
    assert steps[0]["with"]["fetch-depth"] == 0


def test_all_wheels_are_built_once_and_published_together() -> None:
    jobs = yaml.safe_load((ROOT / ".github/workflows/release.yml").read_text())["jobs"]
    built = "\n".join(step.get("run", "") for step in jobs["build"]["steps"])
    parts = sorted(each.parent for each in (ROOT / "packages").glob("*/pyproject.toml"))
    assert parts
    for part in parts:
        assert (
            f"python -m build --no-isolation --wheel --outdir dist {part.relative_to(ROOT)}"
            in built
        )
