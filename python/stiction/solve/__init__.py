"""Contact solutions for the members of a study, and storage of forces and areas summed over contacts."""
