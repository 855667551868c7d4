"""Plans, clouds and matches as pictures."""
