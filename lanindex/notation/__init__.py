"""Text files of notation: scores (LND, read and written), borders (LPD) and rules (LDD, read).

Source: ``encode/METHOD.md``, "Formats".
"""
