"""A wheel carries the bundled models, so that an installed obscli lists the same ones as a checkout."""

import os
import subprocess
import sys
import zipfile
from pathlib import Path

from obscli.model.library import bundled_models


ROOT = Path(__file__).parents[2]


def test_the_wheel_brings_the_models(tmp_path):
    build = "import sys; from hatchling.build import build_wheel; print(build_wheel(sys.argv[1]))"
    built = subprocess.run(
        [sys.executable, "-c", build, str(tmp_path)], cwd=ROOT, capture_output=True, text=True, check=False
    )
    assert built.returncode == 0, built.stderr
    [wheel] = tmp_path.glob("*.whl")
    zipfile.ZipFile(wheel).extractall(tmp_path / "site")

    listed = subprocess.run(
        [sys.executable, "-m", "obscli", "model", "list"],
        cwd=tmp_path,
        env=os.environ | {"PYTHONPATH": str(tmp_path / "site")},
        capture_output=True,
        text=True,
        encoding="utf-8",
        check=True,
    )

    assert [line.split()[0] for line in listed.stdout.splitlines()] == list(bundled_models())
    assert (tmp_path / "site" / "obscli" / "py.typed").is_file()
