"""Solution of the contacts of all members of a study, and storage of the contact sums."""
