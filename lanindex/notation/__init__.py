"""LND, LPD and LDD: read and write."""
