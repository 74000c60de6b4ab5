"""Values and intervals, evaluated from the contact sums of the members."""
