"""The forms of a project file, TOML and spreadsheet, read and written."""
