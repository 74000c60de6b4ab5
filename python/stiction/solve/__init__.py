"""Contact solutions for all members of a study, and storage of the areas and forces summed over contacts."""
