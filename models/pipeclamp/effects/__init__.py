"""One file per effect; the folder is the registry."""
