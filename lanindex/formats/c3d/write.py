"""Write."""
def write(motion):
    raise NotImplementedError
