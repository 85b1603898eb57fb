"""The advisor: which effects a scene calls for, by closed forms."""
