"""Coefficients to report, with caveats and an assessment that states whether a coefficient may be quoted."""
