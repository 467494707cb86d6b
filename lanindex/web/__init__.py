"""The page: a local server of a library, and what a browser shows of it."""
