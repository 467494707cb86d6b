"""The main job in one place: a library that reads, finds and exports."""
