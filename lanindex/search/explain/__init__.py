"""For people: what a query says in English, how the search runs, and why it finds nothing."""
