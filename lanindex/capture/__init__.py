"""File to Motion: the reader is chosen by content."""
