"""Contact mechanics of two rough surfaces: contacts, loads, friction and the onset of sliding."""
