"""The faces: the only code that prints or parses arguments."""
