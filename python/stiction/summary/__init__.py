"""Coefficients to report, with their caveats and an assessment of whether they may be quoted."""
