"""What a search is made of, a folder for each step; README.md walks one query through it.

``language`` reads a pattern into a query, as ``LANGUAGE.md`` says; ``plan`` turns that into
programs; ``match`` searches them in the columns of all captures at once. ``fuzzy`` finds what is
nearly a pattern, ``example`` what is like a clip, ``dictionary`` has names for movements.
``fields`` are what conditions and pipes read of hits and captures;
``explain`` says in English what a pattern asks for and why nothing is found, ``hits`` is what comes
back, and ``sphere`` says where symbols point.
"""
