"""Search by example: movement that is like other movement, whatever it is called."""
