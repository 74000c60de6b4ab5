"""Block the commands of a tested server at an ensemble member, as long as a file with the member's number exists.

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
        except FileNotFoundError:  # the file may be removed at any moment
            return False

    def compute_member_arrays(study, member, *record):
        """Wait until the file no longer blocks the member, and return its arrays."""
        while is_blocked(member):
            time.sleep(0.02)
        return compute_sums(study, member, *record)

    def compute_preview_sums(study):
        """Return the sums of a preview, which is never blocked."""
        runner.compute_member_arrays = compute_sums
        try:
            return compute_preview(study)
        finally:
            runner.compute_member_arrays = compute_member_arrays

    runner.compute_member_arrays, runner.compute_preview_sums = compute_member_arrays, compute_preview_sums
