"""The domains, by name; a module or a folder each, with `CASES`."""
