"""Search: a folder or module for each step; README.md takes one query through them."""
