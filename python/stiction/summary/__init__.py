"""Friction coefficients to report, with caveats and an assessment that states whether they may be quoted."""
