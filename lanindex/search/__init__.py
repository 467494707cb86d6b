"""What a search is made of, a room for each step.

``LANGUAGE.md`` says what a pattern means; ``language`` reads one into a query, ``automaton`` turns
that into programs, ``plain`` runs them as the page says, word for word, ``explain`` says in English
what was asked and why nothing was found, ``hits`` is what comes back. A faster engine is a room
beside ``plain``: it takes the same programs, gives the same hits, and is tested against it.
"""
