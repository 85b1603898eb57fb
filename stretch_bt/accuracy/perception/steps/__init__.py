"""The steps of perception that are measured, one a module with `points(quick)`."""
