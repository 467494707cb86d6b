"""Search by example: movement that is like other movement, whatever it is called.

``likeness`` lays the movements of many clips side by side, as points of a sphere with times,
measures by edit distance how alike two are, and finds the nearest neighbours of one,
``groups`` clusters clips that are alike, ``motifs`` counts the sequences that recur. All of it is
plain numpy over arrays; nothing here knows a file or a database.
"""
