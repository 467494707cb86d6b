"""Search by example: movement that is like other movement, whatever it is called.

A part's symbols are points of a sphere with times. ``moves`` lays those of many clips side by
side, ``align`` measures how much of the movement two clips do not share, ``candidates`` tells
cheaply which clips cannot be alike, ``nearest`` finds the clips, and of long ones the stretches,
that are most like one, ``groups`` joins clips that are alike, ``motifs`` counts the sequences that
recur, ``positions`` compares joints where the files are at hand. All of it is plain numpy over
arrays; nothing here knows a file or a table.
"""
