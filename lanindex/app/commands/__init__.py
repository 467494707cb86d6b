"""The verbs by subject; `lanindex.app.cli.VERBS` says which module has which verb."""
