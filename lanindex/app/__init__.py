"""The faces: the only code that prints, parses arguments or speaks HTTP."""
