"""Reports as text: one format a file, all registered in ``formats``."""
