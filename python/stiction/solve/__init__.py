"""Contact solutions for all members of a study, and storage of the contact sums."""
