"""Files: one format, one file, one row in `FORMATS`."""
