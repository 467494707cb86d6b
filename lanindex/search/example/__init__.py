"""Search by example: movement that is like other movement, whatever it is called.

A part's symbols are points of a sphere with times. ``moves`` lays those of many clips side by
side, ``align`` measures how much of the movement two clips do not share, ``candidates`` tells
cheaply which clips cannot be alike, ``nearest`` finds the clips that are most like one, and
``stretches`` what of long ones, ``groups`` joins clips that are alike, ``motifs`` counts the
sequences that recur, ``positions`` compares joints where the files are at hand. All of it is plain
numpy over arrays; nothing here knows a file or a table.
"""
