"""Score to Motion: a standard body carries out a score."""

from lanindex.perform.stage import perform as perform
