"""Objects to files, one format a file."""
