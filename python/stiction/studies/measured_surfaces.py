"""Every table `[surfaces]` of a study of two measured files, by its key `press`."""

from __future__ import annotations

from typing import get_args

from stiction.studies.measured_areas import MeasuredAreas
from stiction.studies.measured_lines import MeasuredLines
from stiction.studies.measured_surrogates import MeasuredSurrogates

Measured = MeasuredAreas | MeasuredLines | MeasuredSurrogates
"""What a study of two measured files presses; a new kind of members is one more of these."""

MEASURED: tuple[type[Measured], ...] = get_args(Measured)
