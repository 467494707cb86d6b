"""Search by example: movement that is like other movement, whatever it is called.

A part's symbols are points of a sphere with times. ``moves`` lays those of many clips side by
side, ``align`` measures how much of the movement two clips do not share, ``candidates`` tells
cheaply which clips cannot be alike, ``stretches`` finds the stretch of a long clip that is most
alike, ``positions``
compares joints where the files are at hand. All of it is plain numpy over arrays; nothing here
knows a file or a table.
"""
