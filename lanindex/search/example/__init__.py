"""Search by example: movement that is like other movement, whatever it is called.

``align`` lays the movements of many clips side by side, as points of a sphere with times, and
measures by edit distance how alike two are, ``nearest`` finds the nearest neighbours of one,
``groups`` clusters clips that are alike, ``motifs`` counts the sequences that recur. All of it is
plain numpy over arrays; nothing here knows a file or a database.
"""
