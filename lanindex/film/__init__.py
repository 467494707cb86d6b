"""A motion as a moving figure, and the same beside its staff.

`lanindex.film.figure` takes the body out of a motion and chooses the view; `lanindex.film.film`
writes films, `lanindex.film.hits` sheets and pages of hits. Nothing here knows formats.
"""
