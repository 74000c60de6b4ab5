"""Results to report, with caveats and an assessment."""
