"""Values that a result reports, with caveats and an assessment."""
