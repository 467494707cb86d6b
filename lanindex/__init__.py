"""Find human movement by what it is."""
