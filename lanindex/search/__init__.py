"""What a search is made of, a room for each step.

``LANGUAGE.md`` says what a pattern means; ``language`` reads one into a query, ``plan`` turns
that into programs. ``plain`` runs them as the page says, word for word, one capture at a time;
``fast`` takes the same programs, goes through the columns of all captures at once, gives the same
hits, is tested against ``plain`` and leaves to it what it does not cover. ``fuzzy`` finds what is
nearly a pattern, ``example`` what is like a clip. ``dictionary`` has names for movements,
``stages`` sorts, cuts and counts hits, ``explain`` says in English what was asked and why nothing
was found, ``hits`` is what comes back.
"""
