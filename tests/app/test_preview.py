"""Tests of the previews of scans in the app."""

import json
import subprocess
import sys

import numpy as np


def test_preview_command_accepts_spacings_along_both_axes(tmp_path):
    np.save(tmp_path / "map.npy", np.random.default_rng(1).standard_normal((16, 16)))
    options = json.dumps({"unit": "um", "spacing": ["1 um", "2 um"]})
    command = [sys.executable, "-m", "stiction.app.preview", str(tmp_path / "map.npy"), options]
    preview = json.loads(subprocess.check_output(command))
    assert preview["words"].startswith("32 µm × 16 µm")
