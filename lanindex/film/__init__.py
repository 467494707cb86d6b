"""A motion as a moving figure, and the same beside its staff.

Nothing here knows a file or a table. `lanindex.film.figure` takes the body out of a motion,
`lanindex.film.figure` tells from where it is seen best.
"""
