"""Cut."""
def cutter(file):
    raise NotImplementedError
