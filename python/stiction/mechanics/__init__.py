"""Two profiles pressed together: asperities, contacts, friction."""
