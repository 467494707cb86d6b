"""Motion to Score, one module a stage."""
