"""Score to Motion: a standard body carries out a score."""
