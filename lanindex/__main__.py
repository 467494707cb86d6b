"""``python -m lanindex`` is the command ``lanindex``."""

from lanindex.app.cli import main

if __name__ == "__main__":
    main()
