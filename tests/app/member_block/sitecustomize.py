"""While a file exists, block the commands of a tested server at the ensemble member whose number the file contains.

Python imports this module at its start in every process whose PYTHONPATH contains this directory.
"""

import os
import time
from pathlib import Path

BLOCKED_MEMBER_FILE = Path(os.environ.get("STICTION_TEST_HOLD", "/nowhere"))
if BLOCKED_MEMBER_FILE.exists():
    from stiction.solve import runner

    compute_sums, compute_preview = runner.compute_member_arrays, runner.compute_preview_sums

    def is_blocked(member):
        try:
            return member >= int(BLOCKED_MEMBER_FILE.read_text(encoding="utf-8") or 0)
        except FileNotFoundError:  # The file may be removed at any moment.
            return False

    def compute_member_arrays(study, member, *record):
        """Return the sums of a member after the file no longer blocks it."""
        while is_blocked(member):
            time.sleep(0.02)
        return compute_sums(study, member, *record)

    def compute_preview_sums(study):
        """Return the preview, which is never blocked."""
        runner.compute_member_arrays = compute_sums
        try:
            return compute_preview(study)
        finally:
            runner.compute_member_arrays = compute_member_arrays

    runner.compute_member_arrays, runner.compute_preview_sums = compute_member_arrays, compute_preview_sums
